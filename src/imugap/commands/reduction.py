"""Options of the reduction of a model to the parameters of a filter or simulator."""

import argparse

from imugap.commands.arguments import positive
from imugap.interchange.conventions import HOUR, Rule, Triad


def add_rule(parser: argparse.ArgumentParser) -> None:
    """Add the options of the reduction of a model to the parameters of a filter or simulator."""
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


def rule_of(options: argparse.Namespace, rate: float) -> Rule:
    """Return the rule of the reduction for a sampling rate [Hz], from the options of :func:`add_rule`."""
    return Rule(rate, options.horizon, options.correlation_time, Triad(options.triad))
