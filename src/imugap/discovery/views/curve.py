"""The curve of a view: one statistic at each of many locations."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtri_exp, stdtr

SMALLEST = 1e-300
"""Probability below which a score does not grow any more."""


@dataclass(frozen=True, eq=False)
class Curve:
    """What a view says of a fit.

    Attributes
    ----------
    view, axis
        Name of the view; canonical name of the axis (two, joined by a comma, where two signals are compared).
    low, high, unit
        Range of each location, shape (m,), and its unit.
    statistic
        How far data and model are apart at each location, shape (m,). Of a signed curve about standard normal, of
        another one a gain of log-likelihood or its like, whose tail is exponential, if the model is right.
    signed
        Whether small values are as far off as large ones.
    point
        Whether a place is the location where the curve peaks, not all the neighbours that stand out with it.
    windows
        First cell and last cell + 1 of each location, where locations are windows that overlap; else None.
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
    student = np.abs(correlation) * np.sqrt(free / np.maximum(1 - correlation**2, SMALLEST))
    return np.sign(correlation) * -ndtri_exp(np.log(np.maximum(stdtr(free, -student), SMALLEST)))


@lru_cache(maxsize=32)
def windows(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Return first cell and last cell + 1 of windows of 1, 2, 4 .. cells, up to half of them, half a window apart.

    What is weak in each cell but goes on over many shows in the wide ones.
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
    """Return the sums over all windows of the sums of each cell."""
    first, last = windows(len(sums))
    total = np.concatenate([np.zeros(1), np.cumsum(sums)])
    return total[last] - total[first]


def window_ranges(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the range of each window of cells."""
    first, last = windows(len(low))
    return low[first], high[last - 1]


def block_starts(count: int, most: int, shortest: int) -> np.ndarray:
    """Return the first sample of each of at most ``most`` equal blocks of at least ``shortest`` samples."""
    number = max(min(most, count // shortest), 1)
    return np.arange(number) * count // number


def block_maxima(values: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest value of each block and where it is."""
    peaks = np.maximum.reduceat(values, first)
    widths = np.diff(np.r_[first, len(values)])
    candidates = np.flatnonzero(values == np.repeat(peaks, widths))
    return peaks, candidates[np.searchsorted(candidates, first)]
