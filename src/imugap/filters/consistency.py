"""Consistency of a filter: chi-square bands of the NEES, and root mean square errors with intervals.

Bar-Shalom, Li, Kirubarajan (2001), Estimation with Applications to Tracking and Navigation, sec. 5.4. Every bound is
two-sided: a pessimistic filter is as inconsistent as an optimistic one.
"""

import numpy as np
from scipy.special import chdtri


def nees_band(states: int, runs: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the band of the mean NEES of a consistent filter over independent runs.

    The sum over independent runs is chi-square with ``states`` x ``runs`` degrees of freedom.
    """
    tail = (1 - confidence) / 2
    low, high = chdtri(states * runs, [1 - tail, tail]) / runs
    return float(low), float(high)


def root_mean_square(errors: np.ndarray, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the root mean square error over runs, and its confidence interval.

    Errors normalised by their predicted standard deviation give 1 for a consistent filter. Only runs are independent,
    so the members of a run are averaged first. The mean square is taken as chi-square, with the degrees of freedom
    estimated from its scatter over the runs (Satterthwaite 1946).

    Parameters
    ----------
    errors
        Shape (runs, ..., members).

    Returns
    -------
    tuple of numpy.ndarray
        Root mean square, low, high; each of shape (...).
    """
    squares = np.mean(np.square(errors), axis=-1)
    mean = squares.mean(axis=0)
    freedom = 2 * len(squares) * mean**2 / squares.var(axis=0, ddof=1)
    tail = (1 - confidence) / 2
    low, high = (mean * freedom / chdtri(freedom, 1 - quantile) for quantile in (1 - tail, tail))
    return np.sqrt(mean), np.sqrt(low), np.sqrt(high)
