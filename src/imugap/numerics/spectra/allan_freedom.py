"""Degrees of freedom of the overlapping Allan variance (Greenhall and Riley 2003, simplified version)."""

from functools import cache

import numpy as np

TERMS = 100
"""Largest number of terms of a sum; beyond, an approximation takes its place."""
FITTED = {0: (2 / 3, 1 / 3), -1: (0.852, 0.375), -2: (1.079, 0.368)}
"""Coefficients a0, a1 by exponent of the spectrum, where the log is much longer than the averaging time (table 2)."""
DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
"""Weights of the autocovariance of a second difference at lags -2 to 2 (eq. 9)."""


@cache
def degrees_of_freedom(exponent: int, averaging: int, count: int) -> float:
    """Return the equivalent degrees of freedom of an Allan variance.

    Parameters
    ----------
    exponent
        Exponent of the spectrum f^exponent of the rate: 0 white noise, -1 flicker, -2 random walk.
    averaging
        Averaging factor.
    count
        Number of samples of the rate, more than twice the averaging factor.
    """
    number = count + 1 - 2 * averaging
    terms = min(number, 3 * averaging)
    if terms <= TERMS:
        filtered = averaging if 3 * averaging <= TERMS else np.inf
        return number / _relative_sum(terms, number, averaging, filtered, exponent)
    ratio = number / averaging
    if ratio > 3:
        first, second = FITTED[exponent]
        return ratio / (first - second / ratio)
    return TERMS / _relative_sum(TERMS, TERMS, TERMS / ratio, np.inf, exponent)


def _relative_sum(terms: int, number: int, stride: float, averaging: float, exponent: int) -> float:
    """Return the sum over lags of the squared autocorrelation of a second difference (eq. 10)."""
    lags = np.arange(terms + 1)
    squares = (_autocovariance(lags / stride, averaging, exponent) / _autocovariance(0.0, averaging, exponent)) ** 2
    weights = 2 * (1 - lags / number)
    weights[0], weights[-1] = 1.0, weights[-1] / 2
    return float(weights @ squares)


def _autocovariance(lag: float | np.ndarray, averaging: float, exponent: int) -> np.ndarray:
    """Return the autocovariance of a second difference of means at a lag [averaging times], up to a factor (eq. 9)."""
    lags = np.asarray(lag, float)[..., None] + np.arange(-2, 3)
    return _of_means(lags, averaging, exponent) @ DIFFERENCE


def _of_means(lag: np.ndarray, averaging: float, exponent: int) -> np.ndarray:
    """Return the generalised autocovariance of the phase, filtered by the sampling (eq. 8)."""
    if averaging == np.inf:
        return _of_phase(lag, exponent + 2)
    step = 1 / averaging
    covariance = 2 * _of_phase(lag, exponent) - _of_phase(lag - step, exponent) - _of_phase(lag + step, exponent)
    return averaging**2 * covariance


def _of_phase(lag: np.ndarray, exponent: int) -> np.ndarray:
    """Return the generalised autocovariance of the phase with spectrum f^(exponent - 2), up to a factor (eq. 7)."""
    size = np.abs(lag)
    logarithm = np.log(np.where(size > 0, size, 1.0)) if exponent % 2 else 1.0
    return size ** (3 - exponent) * logarithm
