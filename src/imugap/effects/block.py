"""Effects as blocks of a stream: sample by sample, for programs that have no log.

The steps are plain functions in a subset of Python that :mod:`imugap.interchange.code` translates: arithmetic,
comparisons, assignments, ``if``, ``for ... in range``, the functions named here, and three arguments. ``own`` holds the
constants and states of the block and its random stream (``own.draw.normal()``, ``own.draw.uniform()``). ``x`` is the
sample. ``now`` is the error-free input: ``now.at(channel, k)`` and ``now.time(k)``, k samples after the present one,
held at the ends of the stream, and ``now.known(k)``, whether that sample exists.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, exp, inf, isnan, nan, nextafter, sqrt
from types import MappingProxyType

from imugap.log import COLUMNS

FUNCTIONS = (cos, exp, isnan, nextafter, sqrt)
"""Functions of the standard library that a step may call, besides :func:`rint` and :func:`fabs`."""
CONSTANTS = {"inf": inf, "nan": nan}
"""Values that a step may name."""
CHANNELS: Mapping[str, int] = MappingProxyType({name: channel for channel, name in enumerate(COLUMNS)})
"""Channel of each column of the error-free input."""

Value = float | int | Sequence[float]
Step = Callable[[object, float, object], float]
Start = Callable[[object, float, object], None]


LONGEST = 100_000
"""Largest number of samples that a block may keep."""


def require_short(name: str, samples: float) -> None:
    """Raise a ValueError where a block of an effect would keep more than :data:`LONGEST` samples."""
    if not samples <= LONGEST:
        raise ValueError(f"{name}: expected at most {LONGEST} samples to keep at this rate; found {samples:.3g}")


def rint(value: float) -> float:
    """Round half to even."""
    return float(round(value))


def fabs(value: float) -> float:
    """Return the magnitude."""
    return abs(value)


@dataclass(frozen=True, eq=False)
class Block:
    """One effect of one axis as a step from sample to sample.

    Attributes
    ----------
    step
        Function (own, x, now) that returns the sample behind the effect. ``x`` is the error so far for stages ahead
        of the filter, else the output so far, and the stamp on the pseudo-axis; not a number is a lost sample.
    values
        Constants and initial states by name: numbers, whole numbers (``int``), or lists of numbers.
    start
        Function (own, x, now) that sets the states at the first sample, or None.
    past, ahead
        Number of samples of the input that it needs before and after the present one.
    """

    step: Step
    values: Mapping[str, Value] = field(default_factory=dict)
    start: Start | None = None
    past: int = 0
    ahead: int = 0
