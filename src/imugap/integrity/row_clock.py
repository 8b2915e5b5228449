"""Clock of a log in which every row is a sample, although its stamps are uneven: packets, bursts, coarse stamps.

A driver that stamps samples on arrival displaces them by a bounded time; lost rows displace all later ones, so that the
displacement from an even clock grows with the number of rows. That growth separates the two.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from imugap.log import LogError
from imugap.numerics.fitting.straight_line import slope

SHORT, LONGEST = 16, 512
"""Rows of a short span, and most rows of a long one."""
NEIGHBOURS = 5
"""Number of spans of neighbouring lengths; the widest scatter among them counts."""
PARTS, DISTINCT = 8, 4
"""Fewest long spans in a log, and fewest short spans in a long one."""
GROWTH = 0.25
"""Power of the number of rows with which the scatter of a span grows at most; that by random loss does with 1/2."""
SLACK = 1e-3
"""Scatter that is neglected, in mean steps."""
PAUSE = 50.0
"""Step over the mean step of a pause."""
ALONE = 0.05
"""Relative deviation of the longer of two steps from twice the shorter, of a clock that misses single samples."""
WINDOW = 64
"""Rows over which a rate is taken, and the level of the stamps before and after a long step."""
LONG = 1.5
"""Step over the usual longest step, above which samples may be lost."""
ROUNDS = 3
"""Iterations of interval and lost samples."""
DIFFERENT = 0.02
"""Relative difference of two rates."""
COARSEST = 1.1e-3
"""Coarsest unit [s] of stamps: that of a file in milliseconds. Steps of coarser units are intervals of a clock."""
UNEVEN = 1.5
"""Deviation from the mean [rows] of the spacing of one kind of step, of a rounded clock."""
FEW_UNITS = 3
"""Most units of the stamps in an interval of a coarsely rounded clock."""
REGULAR = 0.9
"""Share of steps that follow a pattern, of a regular clock."""
MULTIPLE = 0.01
"""Deviation of a ratio of rates from a whole number."""
UNEQUAL = 0.25
"""Relative deviation from the median of a step that is not equal to it."""
FEWEST_WINDOWS, EACH = 8, 3
"""Fewest windows of a log, and of each part of it, between which rates are compared."""


def in_order(time: np.ndarray) -> np.ndarray:
    """Return stamps, shape (n,) [s], missing ones interpolated and none before the one of the row before."""
    rows = np.flatnonzero(np.isfinite(time))
    return np.maximum.accumulate(np.interp(np.arange(len(time)), rows, time[rows]))


def closed(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return stamps, shape (n,) [s], in order and without pauses, and the steps over pauses, shape (n - 1,) [s]."""
    steps = np.diff(time)
    usual = float(np.mean(steps[steps <= np.quantile(steps, 0.99)]))
    long = steps > PAUSE * usual
    pauses = np.where(long, steps - usual, 0.0)
    return time - np.r_[0.0, np.cumsum(pauses)], pauses


def every_row_is_a_sample(time: np.ndarray, rounding: float) -> bool:
    """Return whether the displacement of stamps, shape (n,) [s], not decreasing, from an even clock is bounded.

    ``rounding`` [s] is that of the stamps.
    """
    long = min(LONGEST, len(time) // PARTS)
    if long < DISTINCT * SHORT:
        return False
    time, _ = closed(time)
    slack = 2 * rounding + SLACK * (time[-1] - time[0]) / len(time)
    return _scatter(time, long) <= (long / SHORT) ** GROWTH * _scatter(time, SHORT) + slack


def _scatter(time: np.ndarray, span: int) -> float:
    """Return the widest interquartile range of the time over ``span`` rows and a few more [s]."""
    widths = [np.subtract(*np.quantile(time[k:] - time[:-k], [0.75, 0.25])) for k in range(span, span + NEIGHBOURS)]
    return float(max(widths))


def longest_rounded_step(time: np.ndarray, rounding: float) -> float | None:
    """Return an upper limit of the steps [s] of an even clock whose stamps in order, shape (n,) [s], are coarse.

    Its steps are two neighbouring numbers of few units ``rounding`` [s], the rarer of them evenly spaced. Losses at
    random are not evenly spaced. None if the stamps are of no such clock.
    """
    units = np.rint(np.diff(time) / rounding)
    low = np.floor(np.mean(units))
    larger = units == low + 1
    if rounding > COARSEST or low > FEW_UNITS or np.mean(larger | (units == low)) < REGULAR:
        return None
    rarer = larger if larger.mean() <= 0.5 else ~larger
    rows = np.flatnonzero(rarer)
    if len(rows) < 2:
        return None
    spacings = np.diff(rows)
    everywhere = max(rows[0], len(rarer) - rows[-1]) < spacings.mean() + UNEVEN
    even = np.mean(np.abs(spacings - spacings.mean()) < UNEVEN) > REGULAR
    return float(low + 1.5) * rounding if everywhere and even else None


def single_losses(time: np.ndarray) -> bool:
    """Return whether the steps of stamps in order, shape (n,), are of one interval and of two, in no other way."""
    steps = np.diff(time)
    low, high = np.quantile(steps, [0.02, 0.98])
    if low <= 0 or abs(high / low - 2) > ALONE:
        return False
    near = np.minimum(np.abs(steps / low - 1), np.abs(steps / low - 2))
    return bool(np.mean(near < ALONE) > REGULAR)


def slots(time: np.ndarray, longest: float | None = None) -> tuple[np.ndarray, float]:
    """Return the sample of each row, shape (n,), and the interval [s], of stamps in order whose rows are samples.

    Samples are lost where the level of the stamps relative to an even clock changes for good, at a step longer than
    ``longest`` [s], by default half longer than nearly all.
    """
    without, pauses = closed(time)
    count = len(time)
    span = min(SHORT * NEIGHBOURS, count - 1)
    interval = float(np.median(without[span:] - without[:-span])) / span
    if not interval > 0:
        raise LogError("log", "column time", "a time that increases", "most stamps equal to those before them")
    result = np.arange(count)
    for _ in range(ROUNDS):
        steps = np.diff(without)
        limit = LONG * np.quantile(steps, 0.99) if longest is None else longest
        long = np.flatnonzero((steps > limit) | (pauses > 0)) + 1
        level = time - interval * np.arange(count)
        lost = np.zeros(count, int)
        for at in long:
            before, after = level[max(at - WINDOW, 0) : at], level[at : at + WINDOW]
            lost[at] = max(round((np.median(after) - np.median(before)) / interval), 0)
        result = np.arange(count) + np.cumsum(lost)
        interval = slope(result, time)
    return result, interval


@dataclass(frozen=True)
class RateChange:
    """Change of the rate of a log at ``row``, from ``before`` to ``after`` [Hz]."""

    row: int
    before: float
    after: float

    @property
    def to_multiple(self) -> bool:
        """Return whether one rate is a multiple of the other, as if samples were lost at the slower one."""
        ratio = max(self.before, self.after) / min(self.before, self.after)
        return abs(ratio - round(ratio)) < MULTIPLE

    def refuse(self, place: Callable[[int], str]) -> NoReturn:
        """Raise a LogError with the location of the change."""
        found = f"{self.before:.4g} Hz before it and {self.after:.4g} Hz from it on; split the file there"
        raise LogError("log", f"{place(self.row)}, column time", "one rate", found)


def rate_change(time: np.ndarray, rounding: float) -> RateChange | None:
    """Return where the rate of stamps in order, shape (n,) [s], changes, or None.

    A rate that changes because other shares of the rows are lost is one rate.
    """
    time, _ = closed(time)
    means = np.diff(time[::WINDOW]) / WINDOW
    if len(means) < FEWEST_WINDOWS or not means.all():
        return None
    logs = np.log(means)
    at = _change(logs)
    parts = logs[: at - 1], logs[at + 1 :]
    if min(map(len, parts)) < EACH:
        return None
    left, right = (float(np.median(part)) for part in parts)
    scatter = max(float(np.subtract(*np.quantile(part, [0.9, 0.1]))) for part in parts)
    if abs(right - left) < max(DIFFERENT, 4 * scatter):
        return None
    first, last = (at - 1) * WINDOW, (at + 1) * WINDOW
    if not all(every_row_is_a_sample(side, rounding) or _is_regular(side) for side in (time[:first], time[last:])):
        return None
    row = first + _change(np.diff(time[first : last + 1]))
    return RateChange(row, float(np.exp(-left)), float(np.exp(-right)))


def _is_regular(time: np.ndarray) -> bool:
    """Return whether most steps of stamps, shape (n,), are nearly equal."""
    steps = np.diff(time)
    return bool(np.mean(np.abs(steps / np.median(steps) - 1) < UNEQUAL) > REGULAR) if np.median(steps) > 0 else False


def _change(values: np.ndarray) -> int:
    """Return the index at which the mean of ``values``, shape (n,), changes most, by least squares."""
    count = np.arange(1, len(values))
    sums = np.cumsum(values)[:-1]
    total = values.sum()
    gain = sums**2 / count + (total - sums) ** 2 / (len(values) - count)
    return int(np.argmax(gain)) + 1
