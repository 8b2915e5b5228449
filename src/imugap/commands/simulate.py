"""Command ``simulate``: write the static log of a device with a given error model."""

import argparse

from imugap import log
from imugap.api.logs import simulate
from imugap.commands.arguments import add_effects, add_examples, add_gravity, add_seed, positive, rate
from imugap.commands.outputs import require_files
from imugap.commands.reading import MODEL_HELP, say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap simulate model.yaml --duration 600 --rate 100 --out simulated.csv")
    parser.add_argument("model", help=MODEL_HELP)
    add_effects(parser)
    parser.add_argument("--duration", type=positive, required=True, help="length [s]")
    parser.add_argument("--rate", type=rate, required=True, help="sampling rate [Hz]")
    add_gravity(parser)
    add_seed(parser)
    parser.add_argument("--out", required=True, help="Parquet or CSV file")


def run(options: argparse.Namespace) -> None:
    """Simulate a device at rest and write its log to ``--out``."""
    require_files({"--out": options.out}, [options.model])
    log.require_format(options.out)
    found = simulate(
        options.model, options.duration, options.rate,
        gravity=options.gravity, seed=options.seed, effects=options.effects,
    )  # fmt: skip
    say(options.model, found.recognised)
    log.write(found.table, options.out)
