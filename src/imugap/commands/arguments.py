"""Types of arguments, and arguments that several commands have."""

import argparse
from math import inf

from imugap.units import STANDARD_GRAVITY

SLOWEST_HZ, FASTEST_HZ = 1e-6, 1e6
"""Range of sampling rates, wider than that of any inertial sensor [Hz]."""
GRAVITIES = 0.1, 100.0
"""Range of local gravity, wider than that of the planets [m/s^2]."""
MOST = 1000
"""Largest number of processes."""


def positive(text: str) -> float:
    """Convert to a finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < inf:
        raise argparse.ArgumentTypeError(f"expected a finite number > 0; found {text}")
    return value


def rate(text: str) -> float:
    """Convert to a sampling rate [Hz] that an inertial sensor may have."""
    value = positive(text)
    if not SLOWEST_HZ <= value <= FASTEST_HZ:
        raise argparse.ArgumentTypeError(f"expected a rate of {SLOWEST_HZ:g} to {FASTEST_HZ:g} Hz; found {text}")
    return value


def gravity(text: str) -> float:
    """Convert to a local gravity [m/s^2]."""
    value, (low, high) = positive(text), GRAVITIES
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"expected a gravity of {low:g} to {high:g} m/s^2; found {text}")
    return value


def probability(text: str) -> float:
    """Convert to a number above zero and below one."""
    value = positive(text)
    if value >= 1:
        raise argparse.ArgumentTypeError(f"expected a probability < 1; found {text}")
    return value


def count(text: str) -> int:
    """Convert to a whole number above zero."""
    if not 0 < whole(text) <= MOST:
        raise argparse.ArgumentTypeError(f"expected a whole number > 0, at most {MOST}; found {text}")
    return int(text)


def whole(text: str) -> int:
    """Convert to a whole number that is not negative."""
    if not (text.isascii() and text.isdigit() and len(text) < 20):
        raise argparse.ArgumentTypeError(f"expected a whole number >= 0 of at most 19 digits; found {text}")
    return int(text)


def add_seed(parser: argparse.ArgumentParser) -> None:
    """Add ``--seed``: the seed of all random streams."""
    parser.add_argument("--seed", type=whole, default=0, help="seed of all random numbers (default %(default)s)")


def add_gravity(parser: argparse.ArgumentParser) -> None:
    """Add ``--gravity``: the local gravity [m/s^2]."""
    parser.add_argument(
        "--gravity", type=gravity, default=STANDARD_GRAVITY, help="local gravity [m/s^2] (default %(default)s)"
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """Add ``--effects``: a module of further effects."""
    parser.add_argument(
        "--effects",
        metavar="MODULE",
        help="module of yours whose effects join the catalogue; its code is imported and runs",
    )


class ExampleFormatter(argparse.HelpFormatter):
    """Formatter of help that wraps text, but leaves indented lines as they are."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        lines = text.splitlines()
        fill = super()._fill_text
        return "\n".join(one if one.startswith(" ") else fill(one, width, indent) for one in lines)


def add_examples(parser: argparse.ArgumentParser, *lines: str) -> None:
    """Show command lines below the help of a command, as they are typed."""
    parser.formatter_class = ExampleFormatter
    parser.epilog = "\n".join(["examples:", *(f"  {line}" for line in lines)])
