"""Maximal-overlap wavelet variance: plain, robust, with intervals, and its expectation under a model.

Level j of the transform (MODWT) with Daubechies' extremal-phase filter of width L has filters of
``(2^j - 1)(L - 1) + 1`` samples and passes 2^-(j+1) to 2^-j cycles per sample. It compares means over 2^(j-1) samples:
the Haar (width 2) wavelet variance of level j is half the overlapping Allan variance at n = 2^(j-1). Coefficients are
zero-mean and stationary where L/2 differences of the sequence are (Percival & Walden 2000, section 8.2). Only those
free of boundary effects are used. Arrays over levels start at level 1.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
import pandas as pd
from numba import njit
from numpy.polynomial.legendre import leggauss
from scipy.fft import fft, next_fast_len
from scipy.optimize import brentq
from scipy.special import chdtri, stdtr

from imugap.effects import RateRamp
from imugap.effects.effect import AxisModel, StochasticEffect
from imugap.estimation.variances import modwt_transfer
from imugap.estimation.variances.allan import sum_second_differences
from imugap.numerics.spectra.daubechies import check, depth, filters, free, length

EFFICIENCY = 0.6
"""Efficiency of the robust estimate for Gaussian samples, as in gmwm and wv."""
STEP = np.log(1.5)
"""Step of log s^2 in the search for the robust estimate; for Gaussian samples the two roots are seven steps apart."""
BLOCK = 8192
"""Samples of a block that fits into the cache of the processor."""


def modwt(sequence: np.ndarray, levels: int, width: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients W_j, shape (levels, n), and the smooth V_J, shape (n,), of the periodic sequence.

    Their energies add up to that of the sequence (Percival & Walden 2000, section 5.4); coefficient t of level j, for t
    from ``length(j) - 1``, depends on samples t - length(j) + 1 to t.
    """
    pairs = list(_pyramid(sequence, levels, width))
    return np.array([wavelet for wavelet, _ in pairs]), pairs[-1][1]


def variance(sequence: np.ndarray, levels: int | None = None, width: int = 2) -> np.ndarray:
    """Return the unbiased wavelet variance [unit^2] of each level, shape (levels,) (Percival & Walden 2000, eq. 306b).

    ``levels`` is the largest possible number by default.
    """
    levels = _levels(len(sequence), levels, width)
    if width == 2:
        return _haar(np.asarray(sequence, float), levels)
    return np.array([_mean_square(coefficients) for coefficients in _free(sequence, levels, width)])


def robust_variance(
    sequence: np.ndarray, levels: int | None = None, width: int = 2, efficiency: float = EFFICIENCY
) -> np.ndarray:
    """Return the robust wavelet variance of each level [unit^2], shape (levels,): outliers have a bounded effect.

    It is the square of the scale s of the coefficients at which the mean of r^2 (1 - (r/c)^2)^4, r = W/s, |r| < c,
    equals that of Gaussian coefficients (Tukey's biweight; Mondal & Percival 2012, Guerrier & Molinari 2016). c is set
    by the ``efficiency`` for independent Gaussian coefficients relative to their mean square. Where no scale does (few
    coefficients, or most of them zero), the nearest is taken. With few degrees of freedom it is biased upwards: 2 % at
    30, a third at 4.
    """
    levels = _levels(len(sequence), levels, width)
    return np.array([biweight_scale(coefficients, efficiency) for coefficients in _free(sequence, levels, width)])


def estimated(sequence: np.ndarray, levels: int, width: int = 2, efficiency: float = 1.0) -> np.ndarray:
    """Return the wavelet variance [unit^2] of each level, shape (levels,); robust for an ``efficiency`` below 1."""
    robust = efficiency < 1
    return robust_variance(sequence, levels, width, efficiency) if robust else variance(sequence, levels, width)


def limits(variance: np.ndarray, edf: np.ndarray, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits [unit^2] of the chi-square interval (Percival & Walden 2000, section 8.4)."""
    low, high = (edf * variance / chdtri(edf, 1 - p) for p in ((1 + level) / 2, (1 - level) / 2))
    return low, high


def edf_octave(count: int, levels: int, width: int = 2) -> np.ndarray:
    """Return equivalent degrees of freedom M_j/2^j, at least 1, of each level (Percival & Walden 2000, eta_3).

    Exact for a spectrum that is flat over the octave of the level; used by gmwm and wv.
    """
    return np.maximum(free(count, levels, width) / 2.0 ** np.arange(1, levels + 1), 1.0)


def edf_sample(sequence: np.ndarray, levels: int, width: int = 2) -> np.ndarray:
    """Return equivalent degrees of freedom of each level from its own coefficients (Percival & Walden 2000, eta_1).

    M nu^4 over half the sum of the squared autocovariances. Reliable for 128 coefficients or more.
    """
    edf = []
    for coefficients in _free(sequence, levels, width):
        count = len(coefficients)
        power = np.abs(fft(coefficients, next_fast_len(2 * count))) ** 2 / count
        edf.append(2 * count * _mean_square(coefficients) ** 2 / np.mean(power**2))
    return np.array(edf)


def edf_model(model: AxisModel | StochasticEffect, interval: float, count: int, levels: int, width: int = 2):
    """Return equivalent degrees of freedom 2 nu^4/var, shape (levels,), under a model sampled every interval [s]."""
    return 2 * implied(model, interval, levels, width) ** 2 / np.diag(covariance(model, interval, count, levels, width))


def curve(
    sequence: np.ndarray, interval: float, width: int = 2, efficiency: float = 1.0, level: float = 0.95
) -> pd.DataFrame:
    """Return the wavelet variance of all levels with chi-square intervals on eta_3 degrees of freedom, as gmwm does.

    An ``efficiency`` below 1 gives the robust variance, with degrees of freedom multiplied by it. eta_3 is
    conservative: the coverage of the intervals exceeds ``level``; :func:`edf_model` gives the degrees of freedom under
    a model.

    Returns
    -------
    pandas.DataFrame
        Index ``level``; columns ``tau`` [s] (averaging time 2^(j-1) intervals, as of the Allan deviation),
        ``variance``, ``low``, ``high`` [unit^2], ``edf``.
    """
    levels = depth(len(sequence), width)
    estimate = estimated(sequence, levels, width, efficiency)
    edf = efficiency * edf_octave(len(sequence), levels, width)
    low, high = limits(estimate, edf, level)
    index = pd.RangeIndex(1, levels + 1, name="level")
    columns = {"tau": 2.0 ** (index - 1) * interval, "variance": estimate, "low": low, "high": high, "edf": edf}
    return pd.DataFrame(columns, index=index)


def level_means(sequence: np.ndarray, width: int = 2) -> pd.DataFrame:
    """Test whether the coefficients of each level with two or more of them have mean zero.

    Every 2^j-th coefficient is used: these are the coefficients of the orthogonal transform, nearly uncorrelated for
    white noise, random walks and flicker noise, whereas the mean of all coefficients telescopes to the ends of the
    sequence. Their mean over its standard error follows Student's law.

    Returns
    -------
    pandas.DataFrame
        Index ``level``; columns ``mean``, ``error`` [unit], ``p`` (two-sided).
    """
    rows = []
    for level, coefficients in enumerate(_free(sequence, depth(len(sequence), width), width), 1):
        apart = coefficients[:: 2**level]
        if len(apart) < 2:
            break
        mean, error = apart.mean(), apart.std(ddof=1) / np.sqrt(len(apart))
        rows.append((level, mean, error, 2 * stdtr(len(apart) - 1, -abs(mean) / error)))
    return pd.DataFrame(rows, columns=["level", "mean", "error", "p"]).set_index("level")


def deepest(sequence: np.ndarray, width: int = 2, size: float = 0.05) -> int:
    """Return the deepest level to use: the last before a level whose coefficients have a significant mean.

    ``size`` is the probability (Bonferroni over the levels) that a sequence without trend loses a level.
    """
    p = level_means(sequence, width)["p"]
    trend = p.index[p < size / len(p)]
    return int(trend[0]) - 1 if len(trend) else len(p)


def implied(model: AxisModel | StochasticEffect, interval: float, levels: int, width: int = 2) -> np.ndarray:
    """Return the wavelet variance [unit^2] of each level, shape (levels,), that a model [interval s] implies.

    Haar: half the sampled Allan variance. Wider filters: the integral of |H_j|^2 and the sampled PSD, to rounding; a
    ramp adds nothing, since they remove a straight line.
    """
    check(width)
    if width == 2:
        return model.sampled_allan_variance(2 ** np.arange(levels), interval) / 2
    return modwt_transfer.passed(_per_sample(model, interval), levels, width)


def covariance(model: AxisModel | StochasticEffect, interval: float, count: int, levels: int, width: int = 2):
    """Return the covariance of the wavelet variances, shape (levels, levels), of ``count`` Gaussian samples.

    With s_ij the cross-covariance of the coefficients of levels i and j, it is 2/(M_i M_j) times the sum of s_ij^2 over
    all pairs of coefficients (Isserlis). For deep levels the lags that do not fit into the sequence are excluded; for
    more than :data:`EXACT` samples this is computed on a smoothed sequence. For shallower levels the excluded share is
    half that of the next deeper one (error 0.05 % of the variance, 0.2 % between levels). A ramp gives the
    coefficients a mean m_j and adds 4 m_i m_j times the covariance of their means, at the deep levels. Rounding errors
    are not Gaussian: their wavelet variances scatter less than this.
    """
    psd, number = _per_sample(model, interval), free(count, levels, width)
    result = 2 * modwt_transfer.overlap(psd, levels, width) / np.maximum.outer(number, number)
    halvings = max(0, int(np.ceil(np.log2(count / EXACT))))
    first = halvings + modwt_transfer.APART if halvings else 0
    if levels <= first:
        return result
    share, means = modwt_transfer.counted(psd, count, levels, width, halvings)
    lost = np.zeros((levels, levels))
    lost[first:, first:] = 1 - share
    for level in range(first - 1, -1, -1):
        lost[level, :-1] = lost[:-1, level] = lost[level + 1, 1:] / 2
    trend = np.sqrt(_ramp(model, interval, levels, width)[first:])
    result *= 1 - lost
    result[first:, first:] += 4 * np.outer(trend, trend) * means
    return result


EXACT = 2**11
"""Largest number of samples for which all pairs of coefficients are counted."""


def _ramp(model: AxisModel | StochasticEffect, interval: float, levels: int, width: int) -> np.ndarray:
    """Return the contribution of a ramp to the wavelet variances."""
    slope = sum(effect.slope for effect in getattr(model, "effects", ()) if isinstance(effect, RateRamp))
    return implied(RateRamp(float(slope)), interval, levels) if width == 2 else np.zeros(levels)


def _levels(count: int, levels: int | None, width: int) -> int:
    limit = depth(count, width)
    if not 1 <= (limit if levels is None else levels) <= limit:
        raise ValueError(f"wavelet: expected 1 to {limit} levels of {count} samples; found {levels}")
    return limit if levels is None else levels


def _pyramid(sequence: np.ndarray, levels: int, width: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Return wavelet and scaling coefficients of level after level (Percival & Walden 2000, section 5.5)."""
    high, low = filters(width)
    smooth = np.asarray(sequence, float)
    for level in range(_levels(len(smooth), levels, width)):
        reach = (width - 1) * 2**level
        wavelet, following = np.empty_like(smooth), np.empty_like(smooth)
        _filter_pair(np.concatenate([smooth[-reach:], smooth]), 2**level, high, low, wavelet, following)
        smooth = following
        yield wavelet, smooth


def _free(sequence: np.ndarray, levels: int, width: int) -> Iterator[np.ndarray]:
    for level, (wavelet, _) in enumerate(_pyramid(sequence, levels, width), 1):
        yield wavelet[length(level, width) - 1 :]


@njit(cache=True, fastmath=True)
def _filter_pair(padded, step, high, low, wavelet, scaling):
    for start in range(0, len(wavelet), BLOCK):
        w, v = wavelet[start : start + BLOCK], scaling[start : start + BLOCK]
        w[:] = 0.0
        v[:] = 0.0
        for tap in range(len(high)):
            first = start + (len(high) - 1 - tap) * step
            part = padded[first : first + len(w)]
            for k in range(len(w)):
                w[k] += high[tap] * part[k]
                v[k] += low[tap] * part[k]


@njit(cache=True, fastmath=True)
def _mean_square(values):
    total = 0.0
    for value in values:
        total += value * value
    return total / len(values)


@njit(cache=True, fastmath=True)
def _haar(sequence, levels):
    """Return the mean squares of the Haar coefficients, which are second differences of the cumulative sum.

    Each block of the sum is used for all levels while it is in the cache; slices let the compiler vectorise.
    """
    mean = sequence.mean()
    angle = np.zeros(len(sequence) + 1)
    for k in range(len(sequence)):
        angle[k + 1] = angle[k] + (sequence[k] - mean)
    total = np.zeros(levels)
    for start in range(0, len(angle), BLOCK):
        stop = min(start + BLOCK, len(angle))
        for level in range(levels):
            n = 1 << level
            first = max(start, 2 * n)
            if first < stop:
                total[level] += sum_second_differences(angle[first:stop], angle[first - n :], angle[first - 2 * n :])
    for level in range(levels):
        n = 1 << level
        total[level] /= 4.0 * n * n * (len(angle) - 2 * n)
    return total


def biweight_scale(coefficients: np.ndarray, efficiency: float) -> float:
    """Return the largest root s^2, searched downwards from a scale at which all coefficients have weight."""
    if not coefficients.any():
        return 0.0
    cut, target = _tuning(efficiency)
    squares = coefficients**2

    def excess(log_scale: float) -> float:
        return _biweight_mean(squares, np.exp(-log_scale), cut**-2) - target

    grid = np.log(3 * squares.mean()) - STEP * np.arange(100)  # at the first the excess is negative
    values = []
    for log_scale in grid:
        values.append(excess(log_scale))
        if values[-1] > 0:
            return float(np.exp(brentq(excess, log_scale, log_scale + STEP, xtol=1e-11)))
    return float(np.exp(grid[np.argmax(values)]))


@njit(cache=True, fastmath=True)
def _biweight_mean(squares, per_scale, per_cut):
    total = 0.0
    for square in squares:
        ratio = square * per_scale
        weight = max(1.0 - ratio * per_cut, 0.0)
        total += ratio * weight * weight * weight * weight
    return total / len(squares)


@lru_cache
def _tuning(efficiency: float) -> tuple[float, float]:
    """Return the cut c [standard deviations] of this efficiency, and the mean of psi for Gaussian samples."""
    if not 0.3 <= efficiency <= 0.99:
        raise ValueError(f"robust wavelet variance: expected an efficiency in [0.3, 0.99]; found {efficiency}")
    cut = float(brentq(lambda cut: _biweight_moments(cut)[1] - efficiency, 2.0, 20.0))
    return cut, _biweight_moments(cut)[0]


def _biweight_moments(cut: float) -> tuple[float, float]:
    """Return, for a Gaussian r, the mean of psi = r^2 (1 - (r/c)^2)^4 and the efficiency (E r psi')^2/(2 var psi).

    By parts, E r psi' = E (r^2 - 1) psi.
    """
    node, weight = leggauss(200)
    r = cut * (node + 1) / 2
    weight = cut * weight * np.exp(-(r**2) / 2) / np.sqrt(2 * np.pi)  # both sides
    psi = r**2 * (1 - (r / cut) ** 2) ** 4
    mean = weight @ psi
    return float(mean), float((weight @ ((r**2 - 1) * psi)) ** 2 / (2 * (weight @ psi**2 - mean**2)))


def _per_sample(model, interval: float):
    """Return the sampled PSD as a function of cycles per sample: its integral over one cycle is the variance."""
    return lambda cycles: model.sampled_psd(cycles / interval, interval) / interval
