"""The curve of a view: one statistic at each of many locations."""

from dataclasses import dataclass

import numpy as np


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
    """

    view: str
    axis: str
    low: np.ndarray
    high: np.ndarray
    unit: str
    statistic: np.ndarray
    signed: bool = True
    point: bool = False


def chi_score(mean_square: np.ndarray, degrees: np.ndarray) -> np.ndarray:
    """Return the normal score of a mean of ``degrees`` squared normal values (Wilson and Hilferty 1931)."""
    spread = 2 / (9 * degrees)
    return (np.cbrt(mean_square) - (1 - spread)) / np.sqrt(spread)


def blocks(count: int, most: int, shortest: int) -> np.ndarray:
    """Return the first sample of each of at most ``most`` equal blocks of at least ``shortest`` samples."""
    number = max(min(most, count // shortest), 1)
    return np.arange(number) * count // number


def highest(values: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest value of each block and where it is."""
    peaks = np.maximum.reduceat(values, first)
    widths = np.diff(np.r_[first, len(values)])
    candidates = np.flatnonzero(values == np.repeat(peaks, widths))
    return peaks, candidates[np.searchsorted(candidates, first)]
