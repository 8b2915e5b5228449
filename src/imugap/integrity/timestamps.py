"""Time stamps of a log: assign each row to a sample of an evenly running clock.

A stamp may be rounded, scattered, repeated, reversed or missing, and rows may be lost. The phase of the clock is
tracked over blocks of rows, so that the count is right also for a slightly wrong interval or a wandering clock.
"""

from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter1d
from scipy.optimize import isotonic_regression

from imugap.integrity.precision import grain
from imugap.log import TIME, LogError, check, interval

BLOCK = 128
"""Rows over which the phase of the clock is averaged."""
BLOCKS = 40
"""Number of blocks from which the interval is estimated."""
DETUNED = 5e-4 * np.arange(-40, 41)
"""Trial values of the relative error of the interval."""
BLURRED = 0.8
"""Rounding of the stamps [intervals], if it does not divide the interval, above which the clock is not observable."""
DOUBTFUL = 0.2
"""Distance from a sample [intervals] above which the first or last stamp may belong to its neighbour."""
COARSE = 1 / 3
"""Rounding of the stamps [intervals] above which single steps of one interval are not identifiable."""
WINDOW = 64
"""Rows over which the stamps are compared with an even clock."""
STRAIGHT = 3.0
"""Mean square of the means over windows, in variances of such a mean, above which the clock wanders."""
SPARSE = 50
"""Samples per row above which the stamps are not of one log."""
ANEW = 0.1
"""Ratio of backward steps to stamps out of order below which the clock was reset, rather than rows swapped."""
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
    """

    time: np.ndarray
    interval: float
    slots: np.ndarray
    advancing: np.ndarray
    rounding: np.ndarray
    even: bool

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
    def grid(self) -> np.ndarray:
        """Return the time of each sample by the stamps around it, shape (count,) [s]."""
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


def stamps(time: np.ndarray) -> Stamps:
    """Assign stamps ``time`` [s], shape (n,), to an even clock; LogError where time does not advance."""
    time = np.where(np.isfinite(time), time, np.nan)
    advancing = _advancing(time)
    good = time[advancing]
    if len(good) < 2:
        raise LogError("log", "index", "a time that advances", f"{len(good)} stamps in order")
    rounding = np.zeros(len(time))
    rounding[advancing] = grain(good)
    if np.count_nonzero(~advancing) > len(time) / 4:
        _require_one_run(time, np.count_nonzero(~advancing))
        interval = (good[-1] - good[0]) / (len(time) - 1)
        return Stamps(time, float(interval), np.arange(len(time)), advancing, rounding, even=False)
    nominal = _nominal(good, float(rounding.max()))
    ratio = nominal / rounding.max()
    if ratio < 1 / BLURRED and abs(ratio - np.rint(ratio)) > 1e-3:
        return Stamps(time, nominal, np.arange(len(time)), advancing, rounding, even=False)
    _require_dense(good, nominal)
    slots = np.full(len(time), -1)
    slots[advancing] = _slots(good, _tuned(good, nominal))
    mean = float(np.polyfit(slots[advancing], good - good[0], 1)[0])
    interval = nominal if abs(mean - nominal) * slots.max() < nominal / 2 else mean
    return Stamps(time, interval, _filled(slots, advancing), advancing, rounding, even=True)


def _require_one_run(time: np.ndarray, astray: int) -> None:
    """Raise a LogError if few backward steps cause many stamps out of order: the clock was reset."""
    backward = np.flatnonzero(np.diff(time) < 0)
    if 0 < len(backward) < ANEW * astray:
        row = int(backward[0]) + 1
        found = f"{time[row]:g} s after {time[row - 1]:g} s (runs come in files of their own)"
        raise LogError("log", f"row {row}", "a time that advances", found)


def _require_dense(time: np.ndarray, interval: float) -> None:
    """Raise a LogError if increasing stamps, shape (n,) [s], are far too few for the time from first to last."""
    samples = (time[-1] - time[0]) / interval
    if samples > SPARSE * len(time):
        widest = int(np.argmax(np.diff(time)))
        expected = f"a row for one in {SPARSE} samples at least, every {interval:g} s"
        gap = f"none from {time[widest]:.10g} to {time[widest + 1]:.10g} s"
        raise LogError("log", "index", expected, f"{len(time)} rows in {time[-1] - time[0]:g} s, {gap}")


def filled(log: pd.DataFrame) -> pd.DataFrame:
    """Return a log with lost samples filled by linear interpolation.

    A sample is the mean over the interval that it ends; without filling, the one after a gap would represent all of it.
    """
    found = stamps(log.index.to_numpy())
    if not found.even or found.count == len(log):
        return log
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


def _tuned(time: np.ndarray, interval: float) -> float:
    """Return the interval [s] near the given one that maximises the phase coherence of the stamps within blocks."""
    blocks = len(time) // BLOCK
    if not blocks:
        return interval
    chosen = np.unique(np.linspace(0, blocks - 1, min(blocks, BLOCKS)).astype(int))
    parts = time[: blocks * BLOCK].reshape(blocks, BLOCK)[chosen]
    parts = (parts - parts[:, :1]) / interval
    agreement = [np.abs(np.exp(2j * np.pi * parts / (1 + change)).mean(axis=1)).mean() for change in DETUNED]
    return interval * (1 + float(DETUNED[np.argmax(agreement)]))


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


def _slots(time: np.ndarray, interval: float) -> np.ndarray:
    """Return the index of the sample at each increasing stamp, shape (n,), from 0."""
    cycles = (time - time[0]) / interval
    edges = np.arange(0, max(len(time) - BLOCK // 2, 1), BLOCK)
    turns = np.add.reduceat(np.exp(2j * np.pi * cycles), edges)
    sizes = np.diff(np.r_[edges, len(time)])
    phase = np.unwrap(np.angle(turns) / (2 * np.pi), period=1.0)
    cycles -= np.interp(np.arange(len(time)), edges + (sizes - 1) / 2, phase)
    late = np.rint(cycles) - np.arange(len(time))
    for end, inner in ((0, late[:5]), (-1, late[-5:])):
        if abs(late[end] - np.median(inner)) == 1 and abs(cycles[end] - np.rint(cycles[end])) > DOUBTFUL:
            late[end] = np.median(inner)
    order = np.rint(isotonic_regression(late).x) + np.arange(len(time))
    return (order - order[0]).astype(int)


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
