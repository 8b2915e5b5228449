"""Views over averaging time and frequency: Allan variance, bands of power, lines, coherence of two axes."""

from functools import lru_cache

import numpy as np
from scipy.fft import dct

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.views.curve import (
    Curve,
    block_maxima,
    block_starts,
    chi_score,
    correlation_score,
    window_ranges,
    window_sums,
    windows,
)
from imugap.estimation.variances import allan

PER_DECADE = 6
"""Averaging times per decade."""
BAND_WIDTH = 0.08
"""Relative width of the bands of power."""
MIN_COEFFICIENTS = 24
"""Number of coefficients in the lowest band of coherence."""
COHERENCE = "coherence"
"""Name of the only view that is symmetric in its two axes; other pairs are residual and input."""
LINE_CELLS = 512
"""Number of cells of frequency; the highest line of each is reported."""


def of_allan(fit: AxisFit) -> Curve:
    """Return the Allan variance of the residual over the one implied by the fitted spectrum, over tau [s]."""
    interval = fit.sequence.conditions.interval
    averaging = allan.factors(len(fit.sequence.values), PER_DECADE)
    ratio = allan.variance(fit.residual, averaging) / implied_allan_variance(fit.variance, averaging)
    degrees = np.maximum(0.75 * len(fit.sequence.values) / averaging - 1, 1.0)
    tau = averaging * interval
    return Curve("allan", fit.sequence.conditions.axis, tau, tau, "s", chi_score(ratio, degrees))


def implied_allan_variance(variance: np.ndarray, averaging: np.ndarray) -> np.ndarray:
    """Return the Allan variance at averaging factors of a process with the given variances of cosine coefficients.

    With the autocovariance c_j, the cosine transform of the spectrum, the sum of n samples has the variance
    V_n = sum over |j| < n of (n - |j|) c_j, and the Allan variance is (4 V_n - V_2n)/(2 n^2). Power below the first
    coefficient is neglected: of a random walk a share 3 n/(4 count), of white noise next to nothing.
    """
    count = len(variance) + 1
    covariance = dct(np.r_[0.0, variance, variance[-1]], type=1)[:count] / (2 * count)
    increments = 2 * np.cumsum(covariance) - covariance[0]
    of_sum = np.r_[0.0, np.cumsum(increments)]
    return (4 * of_sum[averaging] - of_sum[2 * averaging]) / (2.0 * averaging**2)


@lru_cache(maxsize=16)
def bands(last: int, width: float, fewest: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the first coefficient (0 for k = 1) of each band up to ``last``, and the number in each."""
    steps = np.geomspace(fewest, last, max(int(np.log(last / fewest) / width), 1) + 1)
    first = np.unique(np.r_[0, np.rint(steps)[:-1].astype(int)])
    return first, np.diff(np.r_[first, last])


def _range(fit: AxisFit, first: np.ndarray, number: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and highest frequency [Hz] of bands."""
    resolution = 1 / (2 * len(fit.sequence.values) * fit.sequence.conditions.interval)
    return (first + 1) * resolution, (first + number) * resolution


def of_spectrum(fit: AxisFit) -> Curve:
    """Return the ratio of power to the model in windows of bands, over frequency [Hz]."""
    first, number = bands(fit.sequence.bins.last, BAND_WIDTH, 1)
    power = np.add.reduceat(fit.coefficients[: fit.sequence.bins.last] ** 2, first)
    low, high = window_ranges(*_range(fit, first, number))
    total, number = window_sums(power), window_sums(number)
    axis, cells = fit.sequence.conditions.axis, windows(len(first))
    return Curve("spectrum", axis, low, high, "Hz", chi_score(total / number, number), windows=cells)


def of_line(fit: AxisFit) -> Curve:
    """Return the highest line of each cell of frequency [Hz]: gain of log-likelihood minus the log of their number."""
    frequency, gains, _ = fit.lines
    first = block_starts(len(gains), LINE_CELLS, 16)
    peaks, at = block_maxima(gains, first)
    log_number = np.log(np.diff(np.r_[first, len(gains)]))
    half = 0.5 / (len(fit.sequence.values) * fit.sequence.conditions.interval)
    where = frequency[at]
    return Curve(
        "line",
        fit.sequence.conditions.axis,
        where - half,
        where + half,
        "Hz",
        peaks - log_number,
        signed=False,
        point=True,
    )


def shared_last(one: AxisFit, other: AxisFit) -> int:
    """Return the number of coefficients that two axes both use."""
    return min(one.sequence.bins.last, other.sequence.bins.last)


def of_coherence(one: AxisFit, other: AxisFit, last: int | None = None) -> Curve:
    """Return the correlation of two axes' whitened residuals in bands, over frequency [Hz], as a normal score.

    It uses the coefficients up to ``last``, by default those used in both axes.
    """
    last = shared_last(one, other) if last is None else last
    first, number = bands(last, BAND_WIDTH, MIN_COEFFICIENTS)
    a, b = one.coefficients[:last], other.coefficients[:last]
    product, square, other_square = (window_sums(np.add.reduceat(part, first)) for part in (a * b, a**2, b**2))
    norm = np.sqrt(square * other_square)
    correlation = np.divide(product, norm, out=np.zeros_like(norm), where=norm > 0)
    score = correlation_score(correlation, window_sums(number))
    low, high = window_ranges(*_range(one, first, number))
    names = f"{one.sequence.conditions.axis},{other.sequence.conditions.axis}"
    return Curve(COHERENCE, names, low, high, "Hz", score, windows=windows(len(first)))
