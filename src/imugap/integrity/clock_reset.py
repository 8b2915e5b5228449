"""Resets of the clock of a log: counters that wrap, clocks that are set back or ahead, runs that begin anew.

Stamps are in seconds, in the order of the rows. A wrapped counter is unwrapped and a clock that was set back by less
than :data:`SET_BACK_S`, or by an hour, is continued; another step back begins another run, which is refused. A clock
that was set ahead at a whole hour, by an hour and no more than a sample, is continued; another step ahead is a pause.
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
CALENDAR = {3600.0: "a time of the hour", 86400.0: "a time of day", 604800.0: "a time of the GPS week"}
"""Periods of clocks that count from zero and begin anew [s]."""
HOUR_S = 3600.0
"""Time by which local clocks are set ahead and back at the begin and at the end of daylight saving."""
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
    ahead = _set_ahead(time[rows])
    if ahead is not None:
        found = continued(_replaced(time, rows, time[rows] - HOUR_S * (np.arange(len(rows)) > ahead)), place)
        at = place(int(rows[ahead + 1]))
        remark = f"the clock was set ahead at {at}, by an hour (begin of daylight saving?): continued evenly"
        return Continued(found.time, (remark, *found.remarks))
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
    named |= {2.0**bits * usual: f"a counter of 2^{bits} samples" for bits in BITS}
    amid = time.min() >= 0 and time[0] > WINDOW * usual  # a run that begins at zero may begin there again
    named |= {period: name for period, name in CALENDAR.items() if amid and time.max() <= period}
    reach = float(np.ptp(time))
    for period, name in named.items():
        over = period - back
        if reach <= period < 2 * back.min() and over.min() > NEAR[0] * usual and over.max() < NEAR[1] * long:
            return period, name
    return None


def _set_ahead(time: np.ndarray) -> int | None:
    """Return the row of stamps (n,) [s] after which a local clock was set ahead at a whole hour; else None."""
    steps = np.diff(time)
    if len(steps) < WINDOW:
        return None
    usual = float(np.median(steps))
    at = int(np.argmax(steps))
    to_the_hour = -time[at] % HOUR_S
    return at if abs(steps[at] - HOUR_S - usual) < usual and to_the_hour < SHIFTED * usual else None


def _is_hour(shift: float, time: np.ndarray, at: int, usual: float) -> bool:
    """Return whether a local clock was set back by an hour at row ``at``, and no run begins anew at the first stamp."""
    begins_anew = abs(time[at] - time[0]) < WINDOW * usual
    return abs(shift + HOUR_S) < SET_BACK_S and not begins_anew


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
        if shift < -min(SET_BACK_S, SET_BACK_SHARE * np.ptp(finite)) and not _is_hour(shift, finite, at, usual):
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
    size = f"up to {largest:.3g} s" if largest < HOUR_S / 2 else "an hour (end of daylight saving?)"
    remark = f"the clock was set back {count} at {place(set_back[0][0])}, by {size}: continued evenly"
    return Continued(_replaced(time, rows, finite), (remark,))
