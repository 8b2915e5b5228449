"""The curve of a view: one statistic at each of many locations."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtri_exp, stdtr

MIN_PROBABILITY = 1e-300
"""Smallest probability that is converted to a score."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A statistic of a fit over location.

    Attributes
    ----------
    view, axis
        Name of the view; canonical name of the axis (two, joined by a comma, where two signals are compared).
    low, high, unit
        Range of each location, shape (m,), and its unit.
    statistic
        Disagreement of data and model at each location, shape (m,). Under the model, approximately standard normal
        for a signed curve; otherwise a gain of log-likelihood, with an exponential tail.
    signed
        Whether the test is two-sided.
    point
        Whether a place is the location of the peak only, without its neighbours.
    windows
        First cell and last cell + 1 of each location, for overlapping windows; else None.
    """

    view: str
    axis: str
    low: np.ndarray
    high: np.ndarray
    unit: str
    statistic: np.ndarray
    signed: bool = True
    point: bool = False
    windows: tuple[np.ndarray, np.ndarray] | None = None


def chi_score(mean_square: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    """Return the normal score of a mean of ``degrees`` squared normal values (Wilson and Hilferty 1931)."""
    spread = 2 / (9 * degrees)
    return (np.cbrt(mean_square) - (1 - spread)) / np.sqrt(spread)


def correlation_score(correlation: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the normal score of a correlation of ``number`` pairs of normal values of mean zero (Student 1908).

    r sqrt((n - 1)/(1 - r^2)) has Student's law of n - 1 degrees of freedom: the score is normal for however few pairs.
    """
    free = np.maximum(number - 1.0, 1.0)
    student = np.abs(correlation) * np.sqrt(free / np.maximum(1 - correlation**2, MIN_PROBABILITY))
    return np.sign(correlation) * -ndtri_exp(np.log(np.maximum(stdtr(free, -student), MIN_PROBABILITY)))


@lru_cache(maxsize=32)
def windows(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return first cell and last cell + 1 of windows of 1, 2, 4 .. cells, up to half of them, half a window apart.

    Wide windows show deviations that are weak in each cell but extend over many.
    """
    first, last = [], []
    width = 1
    while width <= max(cells // 2, 1):
        begin = np.arange(0, cells - width + 1, max(width // 2, 1))
        first.append(begin)
        last.append(begin + width)
        width *= 2
    return np.concatenate(first), np.concatenate(last)


def window_sums(sums: np.ndarray) -> np.ndarray:
    """Return the sums over all windows, from the sums of the cells.

    Each window is summed by itself: a difference of cumulative sums would lose a faint window beside a strong one.
    """
    ends = np.column_stack(windows(len(sums))).ravel()
    return np.add.reduceat(np.append(sums, 0.0), ends)[::2]


def window_ranges(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the range of each window of cells."""
    first, last = windows(len(low))
    return low[first], high[last - 1]


def block_starts(count: int, most: int, shortest: int) -> np.ndarray:
    """Return the first sample of each of at most ``most`` equal blocks of at least ``shortest`` samples."""
    number = max(min(most, count // shortest), 1)
    return np.arange(number) * count // number


def block_maxima(values: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest value of each block and its index."""
    peaks = np.maximum.reduceat(values, first)
    widths = np.diff(np.r_[first, len(values)])
    candidates = np.flatnonzero(values == np.repeat(peaks, widths))
    return peaks, candidates[np.searchsorted(candidates, first)]
