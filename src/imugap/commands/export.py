"""Write an error model in the form that a filter or a simulator reads."""

import argparse

from imugap.atomic import atomic
from imugap.commands.arguments import positive, rate
from imugap.commands.outputs import require_files
from imugap.interchange.conventions import HOUR, Rule, Triad
from imugap.interchange.export import Target, export
from imugap.model import ErrorModel


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("model", help="error model (YAML)")
    parser.add_argument("--to", required=True, help=", ".join(Target))
    parser.add_argument("--rate", type=rate, required=True, help="sampling rate [Hz]")
    parser.add_argument(
        "--horizon", type=positive, default=10.0,
        help="averaging time at which the Allan variance of the slow part is kept [s] (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--correlation-time", type=positive,
        help=f"of the slow process, where the target has one [s] (default: its own if it is alone, or {HOUR:g})",
    )  # fmt: skip
    parser.add_argument(
        "--triad", choices=list(Triad), default=Triad.MEAN_SQUARE, help="three axes to one number (default %(default)s)"
    )
    parser.add_argument("--out", required=True, help="file to write")


def run(options: argparse.Namespace) -> None:
    """Export the model to ``--out``."""
    require_files({"--out": options.out}, [options.model])
    rule = Rule(options.rate, options.horizon, options.correlation_time, Triad(options.triad))
    text = export(ErrorModel.read(options.model), Target.of(options.to), rule)
    with atomic(options.out) as partial:
        partial.write_text(text)
