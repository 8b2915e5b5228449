"""Whether a filter's belief in itself is right: chi-square bands, and actual against predicted spread.

Bar-Shalom, Li, Kirubarajan (2001), Estimation with Applications to Tracking and Navigation, sec. 5.4. Every bound is
two-sided: a filter that believes too little of itself is as inconsistent as one that believes too much.
"""

import numpy as np
from scipy.special import chdtri


def nees_band(states: int, runs: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the band in which the mean over ``runs`` of a consistent filter's NEES lies.

    The sum over independent runs is chi-square with ``states`` x ``runs`` degrees of freedom.
    """
    tail = (1 - confidence) / 2
    low, high = chdtri(states * runs, [1 - tail, tail]) / runs
    return float(low), float(high)


def root_mean_square(errors: np.ndarray, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the root mean square of errors over runs, and its interval.

    Of errors over their predicted standard deviation it is 1 for a consistent filter. Only runs are independent: the
    members of one run are averaged first. The mean square over the runs is taken for chi-square with as many degrees of
    freedom as its scatter over the runs tells (Satterthwaite 1946).

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
