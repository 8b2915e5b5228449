"""Command ``simulate``: write the static log of a device with a given error model."""

import argparse

from imugap import log
from imugap.analysis import static
from imugap.commands.arguments import add_effects, add_examples, add_gravity, add_seed, positive, rate
from imugap.commands.outputs import require_files, room
from imugap.commands.reading import MODEL_HELP, model_at, open_model

STAMP_BYTES = 4
"""Fewest bytes of a sample in a file: those of its stamp."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap simulate model.yaml --duration 600 --rate 100 --out simulated.csv")
    parser.description = (
        "Write the log of a device at rest. A log of more than 1e6 samples is written part by part, in the memory of a "
        "part, unless an effect needs the whole run (stability_restoration, an output_filter of form 2 or 3, an effect "
        "of --effects that does not say otherwise)."
    )
    parser.add_argument("model", help=MODEL_HELP)
    add_effects(parser)
    parser.add_argument("--duration", type=positive, required=True, help="length [s]")
    parser.add_argument("--rate", type=rate, required=True, help="sampling rate [Hz]")
    add_gravity(parser)
    add_seed(parser)
    parser.add_argument("--out", required=True, help="Parquet or CSV file")


def run(options: argparse.Namespace) -> None:
    """Simulate a device at rest and write its log to ``--out``, part by part."""
    require_files({"--out": options.out}, [options.model])
    log.require_format(options.out)
    model = model_at(open_model(options.model, options.effects), options.rate)
    if not model.sensors:
        raise ValueError(f"{options.model}: expected a model of at least one sensor axis; found none")
    static.require_count(options.duration * options.rate, room(options.out) / STAMP_BYTES, options.out)
    parts = static.simulate_parts(model, options.duration, options.rate, options.gravity, options.seed)
    log.write_parts(parts, options.out)
