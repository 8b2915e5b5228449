"""Views over time: mean, variance, largest values, change points."""

import numpy as np
from scipy.stats import norm

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.views.curve import (
    Curve,
    block_maxima,
    block_starts,
    chi_score,
    window_ranges,
    window_sums,
    windows,
)

MAX_BLOCKS, MIN_BLOCK_SAMPLES = 128, 16
"""Maximum number of blocks of a log, and minimum number of samples of a block."""


def _range(fit: AxisFit, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return begin and end [s] of blocks."""
    time = fit.sequence.conditions.time
    return time[first], time[np.r_[first[1:], len(time)] - 1]


def _sums(fit: AxisFit, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the first sample of each block, and over windows of blocks sum and number of the values without flaws."""
    first = block_starts(len(values), MAX_BLOCKS, MIN_BLOCK_SAMPLES)
    kept = ~fit.sequence.flawed
    number = window_sums(np.add.reduceat(kept.astype(float), first))
    return first, window_sums(np.add.reduceat(values * kept, first)), np.maximum(number, 1.0)


def _windowed(view: str, fit: AxisFit, first: np.ndarray, statistic: np.ndarray) -> Curve:
    low, high = window_ranges(*_range(fit, first))
    axis = fit.sequence.conditions.axis
    return Curve(view, axis, low, high, "s", statistic, windows=windows(len(first)))


def of_mean(fit: AxisFit) -> Curve:
    """Return the means of blocks of the whitened residual over time [s]."""
    first, total, number = _sums(fit, fit.whitened)
    return _windowed("mean", fit, first, total / np.sqrt(number))


def of_variance(fit: AxisFit) -> Curve:
    """Return the mean squares of blocks of the whitened residual over time [s]."""
    first, total, number = _sums(fit, fit.whitened**2)
    return _windowed("variance", fit, first, chi_score(total / number, number))


def of_extremes(fit: AxisFit) -> Curve:
    """Return the largest whitened residual of each block over time [s], as a Gumbel variable."""
    first = block_starts(len(fit.whitened), MAX_BLOCKS, MIN_BLOCK_SAMPLES)
    peaks, at = block_maxima(np.abs(fit.whitened) * ~fit.sequence.flawed, first)
    usual = norm.isf(0.5 / np.diff(np.r_[first, len(fit.whitened)]))
    time = fit.sequence.conditions.time[at]
    statistic = usual * (peaks - usual)
    return Curve("extremes", fit.sequence.conditions.axis, time, time, "s", statistic, signed=False)


def of_change(fit: AxisFit) -> Curve:
    """Return the gain of log-likelihood of the best step of the mean in each block, over time [s]."""
    first = block_starts(len(fit.steps.gains), MAX_BLOCKS, MIN_BLOCK_SAMPLES)
    peaks, at = block_maxima(fit.steps.gains, first)
    time = fit.sequence.conditions.time[at]
    return Curve("change", fit.sequence.conditions.axis, time, time, "s", peaks, signed=False, point=True)
