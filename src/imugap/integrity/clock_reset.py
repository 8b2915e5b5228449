"""Resets of the clock of a log: counters that wrap, clocks that are set back, runs that begin anew.

Stamps are in seconds, in the order of the rows. A wrapped counter is unwrapped and a clock that was set back by less
than :data:`SET_BACK_S` is continued; a larger step back begins another run, which is refused.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from imugap.log import LogError

UNITS = {1.0: "s", 1e-1: "0.1 s", 1e-2: "10 ms", 1e-3: "ms", 1e-4: "0.1 ms", 1e-5: "10 us", 1e-6: "us", 1e-7: "0.1 us",
         1e-8: "10 ns", 1e-9: "ns"}  # fmt: skip
"""Units in which counters count."""
BITS = (16, 24, 32)
"""Widths of counters."""
CALENDAR = {86400.0: "a time of day", 604800.0: "a time of the GPS week"}
"""Periods of other clocks that begin anew [s]."""
NEAR = (0.2, 5.0)
"""Range of the step over a wrap, in median steps and in long ones."""
WINDOW = 64
"""Rows before and after a step back that show whether the stamps stay behind."""
SHIFTED = 1.5
"""Smallest lasting shift of the stamps, in median steps."""
SCATTERED = 1.0
"""Smallest lasting shift of the stamps, in standard deviations of the stamps about an even clock."""
SET_BACK_S, SET_BACK_SHARE = 1.0, 0.25
"""Largest correction of a running clock [s], also as a share of the log; by more, another run begins."""


@dataclass(frozen=True, eq=False)
class Continued:
    """Stamps of one run without resets: ``time`` [s], shape (n,), and a sentence for each kind of reset."""

    time: np.ndarray
    remarks: tuple[str, ...] = ()


def row_number(row: int) -> str:
    """Return the location of a row, counted from 0."""
    return f"row {row}"


def continued(time: np.ndarray, place: Callable[[int], str] = row_number) -> Continued:
    """Return stamps ``time`` [s], shape (n,), NaN where missing, without resets; LogError where another run begins.

    ``place`` returns the location of a row in its file.
    """
    rows = np.flatnonzero(np.isfinite(time))
    finite = time[rows]
    steps = np.diff(finite)
    if not (steps < 0).any() or not (steps > 0).any():
        return Continued(time)
    wrap = _wrap(finite, steps)
    if wrap is not None:
        period, name = wrap
        turns = np.r_[0, np.cumsum(steps < 0)]
        first, count = rows[int(np.argmax(steps < 0)) + 1], int(turns[-1])
        times = "once" if count == 1 else f"{count} times"
        remark = f"{name} wraps every {period:.10g} s, {times}, first at {place(int(first))}: unwrapped"
        return Continued(_replaced(time, rows, finite + period * turns), (remark,))
    return _without_corrections(time, rows, place)


def _replaced(time: np.ndarray, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    result = time.copy()
    result[rows] = values
    return result


def _wrap(time: np.ndarray, steps: np.ndarray) -> tuple[float, str] | None:
    """Return the period [s] of a counter that explains all steps back, and its name; None if none does."""
    back, ahead = -steps[steps < 0], steps[steps > 0]
    usual, long = float(np.median(ahead)), float(np.quantile(ahead, 0.99))
    named = {2.0**bits * unit: f"a counter of 2^{bits} {text}" for unit, text in UNITS.items() for bits in BITS}
    named |= {2.0**bits * usual: f"a counter of 2^{bits} samples" for bits in BITS} | CALENDAR
    reach = float(np.ptp(time))
    for period, name in named.items():
        over = period - back
        if reach <= period < 2 * back.min() and over.min() > NEAR[0] * usual and over.max() < NEAR[1] * long:
            return period, name
    return None


def _without_corrections(time: np.ndarray, rows: np.ndarray, place: Callable[[int], str]) -> Continued:
    """Return the stamps with the steps undone by which the clock was set back; LogError for another run."""
    finite = time[rows].copy()
    span = min(WINDOW, len(finite) - 1)
    usual = abs(float(np.median(finite[span:] - finite[:-span]))) / span
    set_back = []
    for at in np.flatnonzero(np.diff(finite) < 0) + 1:
        if finite[at] - finite[at - 1] > -SHIFTED * usual:
            continue
        parts = slice(max(at - WINDOW, 0), at), slice(at, min(at + WINDOW, len(finite)))
        levels = [finite[part] - usual * np.arange(part.start, part.stop) for part in parts]
        shift = np.median(levels[1]) - np.median(levels[0])
        if shift > -max(SHIFTED * usual, SCATTERED * max(map(np.std, levels))):
            continue
        if shift < -min(SET_BACK_S, SET_BACK_SHARE * np.ptp(finite)):
            found = (
                f"{time[rows[at]]:.10g} s after {time[rows[at - 1]]:.10g} s: another run begins there; split the file"
            )
            raise LogError("log", f"{place(int(rows[at]))}, column time", "a time that increases", found)
        finite[at:] += finite[at - 1] + usual - finite[at]
        set_back.append((int(rows[at]), -float(shift)))
    if not set_back:
        return Continued(time)
    largest = max(size for _, size in set_back)
    count = f"{len(set_back)} times, first" if len(set_back) > 1 else "once,"
    remark = f"the clock was set back {count} at {place(set_back[0][0])}, by up to {largest:.3g} s: continued evenly"
    return Continued(_replaced(time, rows, finite), (remark,))
