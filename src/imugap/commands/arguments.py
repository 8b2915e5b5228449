"""Types of arguments, and arguments that several commands have."""

import argparse
from math import inf

from imugap.units import STANDARD_GRAVITY


def positive(text: str) -> float:
    """Convert to a finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < inf:
        raise argparse.ArgumentTypeError(f"expected a finite number > 0; found {text}")
    return value


def probability(text: str) -> float:
    """Convert to a number above zero and below one."""
    value = positive(text)
    if value >= 1:
        raise argparse.ArgumentTypeError(f"expected a probability < 1; found {text}")
    return value


def count(text: str) -> int:
    """Convert to a whole number above zero."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"expected a whole number > 0; found {text}")
    return int(text)


def add_gravity(parser: argparse.ArgumentParser) -> None:
    """Add ``--gravity``: the local gravity [m/s^2]."""
    parser.add_argument(
        "--gravity", type=positive, default=STANDARD_GRAVITY, help="local gravity [m/s^2] (default %(default)s)"
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """Add ``--effects``: a module of further effects."""
    parser.add_argument("--effects", help="module whose effects join the catalogue")
