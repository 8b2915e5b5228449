"""Time stamps of a log: assign each row to a sample of an evenly running clock.

A stamp may be rounded, scattered, repeated, reversed or missing, and rows may be lost. The phase of the clock is
tracked over blocks of rows, so that the count is right also for a slightly wrong interval or a wandering clock.
"""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter1d

from imugap.integrity.clock_reset import Continued, continued, row_number
from imugap.integrity.lattice_clock import lattice_interval, lattice_slots
from imugap.integrity.packet_clock import packet_slots
from imugap.integrity.precision import grain
from imugap.integrity.row_clock import every_row_is_a_sample, in_order, longest_rounded_step, rate_change, single_losses
from imugap.integrity.row_clock import slots as slots_of_rows
from imugap.log import TIME, LogError, check, interval
from imugap.numerics.fitting.straight_line import slope

BLURRED = 0.8
"""Rounding of the stamps [intervals], if it does not divide the interval, above which the clock is not observable."""
COARSE = 1 / 3
"""Rounding of the stamps [intervals] above which single steps of one interval are not identifiable."""
WINDOW = 64
"""Rows over which the stamps are compared with an even clock."""
STRAIGHT = 3.0
"""Mean square of the means over windows, in variances of such a mean, above which the clock wanders."""
SPARSE = 50
"""Samples per row above which the stamps are not of one log."""
PAUSED = 0.5
"""Share of the time of a log in one step from which it is that of two."""
FEW = 0.1
"""Share of lost samples up to which the interval is that of most steps, and of stamps out of order up to which those
in order show the clock."""
SAME = 0.1
"""Relative difference up to which two intervals are one."""
ASTRAY = 0.25
"""Share of stamps out of order above which none shows the clock."""
ROUNDED = 2.0
"""Variance of the stamps, in variances of their rounding, below which there is no other cause."""
LEAST = 4 * WINDOW
"""Fewest rows for the scatter of stamps."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """Rows of a log, assigned to the samples of an even clock.

    Attributes
    ----------
    time
        Stamps as read [s], shape (n,); may be NaN.
    interval
        Interval of the clock [s].
    slots
        Index of the sample of each row, shape (n,), increasing; -1 for a row that repeats another.
    advancing
        Mask of the stamps that are finite and in order, shape (n,).
    rounding
        Rounding of each stamp, shape (n,) [s]; zero where there is no stamp.
    even
        Whether the clock is observable in the stamps; if not, each row is a sample.
    remarks
        A sentence for each kind of reset of the clock that was undone.
    """

    time: np.ndarray
    interval: float
    slots: np.ndarray
    advancing: np.ndarray
    rounding: np.ndarray
    even: bool
    remarks: tuple[str, ...] = ()

    @property
    def kept(self) -> np.ndarray:
        """Return which rows hold a sample of their own, shape (n,)."""
        return self.slots >= 0

    @cached_property
    def count(self) -> int:
        """Return the number of samples from the first row to the last, lost ones included."""
        return int(self.slots.max()) + 1

    @cached_property
    def lost(self) -> np.ndarray:
        """Return which samples have no row, shape (count,)."""
        lost = np.ones(self.count, bool)
        lost[self.slots[self.kept]] = False
        return lost

    @cached_property
    def ordered(self) -> np.ndarray:
        """Return the stamps, shape (n,) [s], missing ones interpolated and none before the one of the row before."""
        return in_order(self.time)

    @cached_property
    def grid(self) -> np.ndarray:
        """Return the time of each sample by the stamps around it, shape (count,) [s]; evenly if the clock is unseen."""
        if not self.even:
            return self.line
        rows = self.kept & self.advancing
        return np.interp(np.arange(self.count), self.slots[rows], self.time[rows])

    @cached_property
    def line(self) -> np.ndarray:
        """Return the time of each sample on the straight line through all stamps, shape (count,) [s]."""
        rows = self.kept & self.advancing
        slope, start = np.polyfit(self.slots[rows], self.time[rows] - self.time[rows][0], 1)
        return self.time[rows][0] + start + slope * np.arange(self.count)

    @cached_property
    def course(self) -> np.ndarray:
        """Return the smoothed time of each sample, shape (count,) [s].

        The straight line through the stamps if the means over windows agree with it within their scatter; else a moving
        average of the stamps over a window.
        """
        if not self.scatter.size:
            return self.grid
        off = self.grid - self.line
        windows = len(off) // WINDOW
        means = off[: windows * WINDOW].reshape(windows, WINDOW).mean(axis=1)
        straight = np.mean(means**2) <= STRAIGHT * max(self.variance, self.rounding_variance) / WINDOW
        return self.line if straight else self.line + uniform_filter1d(off, WINDOW, mode="nearest")

    @cached_property
    def scatter(self) -> np.ndarray:
        """Return the residuals of the stamps from the line through each window, shape (windows, WINDOW) [s]."""
        rows = np.flatnonzero(self.kept & self.advancing)
        windows = len(rows) // WINDOW
        rows = rows[: windows * WINDOW].reshape(windows, WINDOW)
        slots = self.slots[rows] - self.slots[rows].mean(axis=1, keepdims=True)
        time = self.time[rows] - self.time[rows[:, :1]]
        time -= time.mean(axis=1, keepdims=True)
        slope = (slots * time).sum(axis=1, keepdims=True) / (slots**2).sum(axis=1, keepdims=True)
        return time - slope * slots

    @property
    def freedom(self) -> int:
        """Return the degrees of freedom of :attr:`scatter`."""
        return self.scatter.size - 2 * len(self.scatter)

    @property
    def variance(self) -> float:
        """Return the variance of the stamps about an even clock [s^2]."""
        return float(np.sum(self.scatter**2) / self.freedom)

    @property
    def rounding_variance(self) -> float:
        """Return the upper limit of the variance of the stamps by rounding alone [s^2]."""
        return float(np.mean(self.rounding[self.advancing] ** 2) / 12)


def stamps(time: np.ndarray, place: Callable[[int], str] = row_number) -> Stamps:
    """Assign stamps ``time`` [s], shape (n,), to an even clock.

    Raises a LogError where time does not advance, another run begins, the rate changes or there is no even clock;
    ``place`` returns the location of a row in its file.
    """
    whole = continued(np.where(np.isfinite(time), time, np.nan), place)
    time, advancing = whole.time, _advancing(whole.time)
    good = time[advancing]
    if len(good) < 2:
        raise LogError("log", "index", "a time that advances", f"{len(good)} stamps in order")
    rounding = np.zeros(len(time))
    rounding[advancing] = grain(good)
    coarse = float(rounding.max())
    ordered = in_order(time)
    change = rate_change(ordered, coarse)
    if change is not None and not change.to_multiple:
        change.refuse(place)
    longest = longest_rounded_step(ordered, coarse)
    if longest is not None:
        return _of_rows(whole, advancing, rounding, longest)
    if single_losses(ordered):
        return _of_lattice(whole, advancing, rounding, lattice_interval(good, coarse) or _nominal(good, coarse))
    packets = packet_slots(ordered)
    if packets is not None:
        return Stamps(time, packets[1], packets[0], advancing, rounding, False, whole.remarks)
    astray = np.count_nonzero(~advancing) / len(time)
    by_rows = every_row_is_a_sample(ordered, coarse)
    nominal = _nominal(good, coarse)
    ratio = nominal / coarse
    blurred = ratio < 1 / BLURRED and abs(ratio - np.rint(ratio)) > 1e-3
    if blurred or astray > ASTRAY or (by_rows and astray > FEW):
        return _of_rows(whole, advancing, rounding)
    found = _of_lattice(whole, advancing, rounding, nominal)
    if found.lost.mean() <= FEW:
        return found
    lattice, rows = lattice_interval(good, coarse), _of_rows(whole, advancing, rounding)
    if by_rows and (lattice is None or abs(lattice / rows.interval - 1) > SAME):
        return rows
    if lattice is None:
        _refuse(time, advancing, place)
    return _of_lattice(whole, advancing, rounding, lattice)


def _of_rows(whole: Continued, advancing: np.ndarray, rounding: np.ndarray, longest: float | None = None) -> Stamps:
    """Assign every row to a sample of its own, and long steps to samples lost.

    With an upper limit ``longest`` [s] of their steps, the stamps are those of an even clock, but for rounding.
    """
    slots, interval = slots_of_rows(in_order(whole.time), longest)
    _require_dense(whole.time[advancing], interval)
    even = longest is not None and rounding.max() < BLURRED * interval
    return Stamps(whole.time, interval, slots, advancing, rounding, even, whole.remarks)


def _of_lattice(whole: Continued, advancing: np.ndarray, rounding: np.ndarray, nominal: float) -> Stamps:
    """Assign stamps near the samples of an even clock of nearly the interval ``nominal`` [s]."""
    good = whole.time[advancing]
    _require_dense(good, nominal)
    slots = np.full(len(whole.time), -1)
    slots[advancing] = lattice_slots(good, nominal)
    mean = slope(slots[advancing], good)
    interval = nominal if abs(mean - nominal) * slots.max() < nominal / 2 else mean
    return Stamps(whole.time, interval, _filled(slots, advancing), advancing, rounding, True, whole.remarks)


def _refuse(time: np.ndarray, advancing: np.ndarray, place: Callable[[int], str]) -> NoReturn:
    """Raise a LogError with the first stamp that goes back, or the steps of stamps, shape (n,), without a clock."""
    rows = np.flatnonzero(np.isfinite(time))
    late = rows[1:][np.diff(time[rows]) <= 0]
    if len(late):
        row = int(late[0])
        found = f"{time[row]:.10g} after {time[rows[rows < row][-1]]:.10g}"
        raise LogError("log", f"{place(row)}, column time", "a time that increases", found)
    low, high = np.quantile(np.diff(time[advancing]), [0.05, 0.95])
    found = f"steps of {low:.3g} to {high:.3g} s in no order, from which no rate follows"
    raise LogError("log", "column time", "stamps of an even clock", found)


def _require_dense(time: np.ndarray, interval: float) -> None:
    """Raise a LogError if increasing stamps, shape (n,) [s], are far too few for the time from first to last."""
    samples = (time[-1] - time[0]) / interval
    if samples > SPARSE * len(time):
        steps = np.diff(time)
        widest = int(np.argmax(steps))
        if steps[widest] > PAUSED * (time[-1] - time[0]):
            expected = "one recording without a pause of most of its time (split the file there)"
            found = f"no row from {time[widest]:.10g} to {time[widest + 1]:.10g} s"
            raise LogError("log", "column time", expected, found)
        expected = (
            "stamps that show the interval of the samples "
            "(--rate HZ, with the rate that the device was set to, takes every row as a sample)"
        )
        found = f"{len(time)} different stamps in {time[-1] - time[0]:g} s, most {np.median(steps):.3g} s apart"
        raise LogError("log", "column time", expected, found)


def filled(log: pd.DataFrame) -> pd.DataFrame:
    """Return a log with lost samples filled by linear interpolation.

    A sample is the mean over the interval that it ends; without filling, the one after a gap would represent all of it.
    """
    found = stamps(log.index.to_numpy())
    if found.count == len(log):
        return log if found.even else log.set_axis(pd.Index(found.grid, name=TIME))
    slots, time = found.slots[found.kept], found.grid
    columns = {name: np.interp(np.arange(found.count), slots, log[name].to_numpy()[found.kept]) for name in log}
    return check(pd.DataFrame(columns, index=pd.Index(time, name=TIME)))


def _nominal(time: np.ndarray, rounding: float) -> float:
    """Return the interval [s] of increasing stamps, shape (n,); the mean over many where the rounding is coarse."""
    mean = interval(pd.DataFrame(index=time))
    if rounding < COARSE * mean or len(time) < 2 * WINDOW:
        return mean
    spans = time[WINDOW:] - time[:-WINDOW]
    low, middle, high = np.quantile(spans, [0.05, 0.5, 0.95])
    return float(middle / WINDOW) if high - low < 2.5 * rounding else mean


def _advancing(time: np.ndarray) -> np.ndarray:
    """Return the mask of the longest increasing subsequence of the stamps, shape (n,)."""
    advancing = np.isfinite(time)
    rows = np.flatnonzero(advancing)
    if np.all(np.diff(time[rows]) > 0):
        return advancing
    rows = rows[np.r_[True, np.diff(time[rows]) != 0]]
    tops: list[float] = []
    ranks = np.empty(len(rows), int)
    for i, stamp in enumerate(time[rows].tolist()):
        ranks[i] = bisect_left(tops, stamp)
        tops[ranks[i] : ranks[i] + 1] = [stamp]
    advancing[:] = False
    rank, above = len(tops) - 1, np.inf
    for i in range(len(rows) - 1, -1, -1):
        if ranks[i] == rank and time[rows[i]] < above:
            advancing[rows[i]] = True
            rank, above = rank - 1, time[rows[i]]
    return advancing


def _filled(slots: np.ndarray, advancing: np.ndarray) -> np.ndarray:
    """Return the slots with rows without a usable stamp assigned after the previous row, if there is a free slot."""
    if advancing.all():
        return slots
    rows = np.flatnonzero(advancing)
    before = np.searchsorted(rows, np.arange(len(slots)), "right") - 1
    inner = (before >= 0) & (before < len(rows) - 1) & ~advancing
    place = slots[rows[before[inner]]] + np.flatnonzero(inner) - rows[before[inner]]
    filled = slots.copy()
    filled[inner] = np.where(place < slots[rows[before[inner] + 1]], place, -1)
    return filled
