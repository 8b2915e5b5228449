"""Monte-Carlo tests of noise for Gaussianity (skewness, kurtosis) and stationarity (power over time).

Both use the whitened log, each frequency weighted by the share of the noise in it, so that an impulse that drives the
process remains an impulse. The null distribution is that of :data:`DRAWS` draws of Gaussian noise with these weights.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy.fft import idct

from imugap.discovery.checks.misfit import Misfit, divergence
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects.effect import TINY
from imugap.stream import stream

BURSTS, UNEVEN = "it comes in bursts or jumps", "it is stronger at some times than at others"
MIN_SHARE = 0.05
"""Minimum share of the noise in the variance of a coefficient for using it."""
DRAWS, BATCHES, MIN_COEFFICIENTS, MAX_COEFFICIENTS = 1999, 20, 40, 6000
"""Number of draws of Gaussian noise and of their batches; minimum and maximum number of coefficients in use."""
TOLERATED_MOMENTS = (-1.0, 1.0), (2.0, 6.0)
"""Tolerated ranges of skewness and kurtosis, as real noise has them; the kurtosis up to that of a Laplace law."""
FIRST_OCTAVE, MIN_PER_BLOCK, MAX_BLOCKS = 16, 8, 32
"""Coefficients in the lowest band, the others being octaves; minimum coefficients per block of time; maximum blocks."""
TOLERATED_DIVERGENCE = 0.01
"""Tolerated divergence of the power of blocks per coefficient, as of a relative deviation of up to a fifth."""


def sample_misfits(fit: AxisFit, share: np.ndarray) -> tuple[Misfit, ...]:
    """Test noise with a given share in the bins for Gaussianity and for stationarity; none for too few coefficients.

    Stationarity is not tested where the description has a change of variance, which no process can be assigned.
    """
    bins = fit.sequence.bins
    weight = bins.spread(np.maximum(share, TINY))[: min(bins.last, MAX_COEFFICIENTS)]
    weight = weight[: max(np.flatnonzero(weight > MIN_SHARE), default=0) + 1]
    if len(weight) < MIN_COEFFICIENTS:
        return ()
    own = weight * fit.coefficients[: len(weight)]
    jumps = Misfit(BURSTS, _gaussianity_log_p(own, weight))
    fading = 0.0 if fit.description.changes else _stationarity_log_p(own, weight)
    return jumps, Misfit(UNEVEN, fading)


def _simulated(statistic: Callable[[np.ndarray], np.ndarray], weight: np.ndarray) -> np.ndarray:
    """Return a statistic of Gaussian signals with weighted coefficients, shape (:data:`DRAWS`, ...)."""
    noise = weight * stream(0, "uncommon", len(weight)).standard_normal((DRAWS, len(weight)))
    return np.concatenate([statistic(part) for part in np.array_split(noise, BATCHES)])


def _gaussianity_log_p(own: np.ndarray, weight: np.ndarray) -> float:
    """Return the log-probability of skewness and kurtosis in Gaussian noise (two-sided, Bonferroni)."""
    found = _moments(own[None])[0]
    if all(low < value < high for value, (low, high) in zip(found, TOLERATED_MOMENTS, strict=True)):
        return 0.0
    rank = np.sum(_simulated(_moments, weight) >= found, axis=0) + 1
    two_sided = 2 * np.minimum(rank, DRAWS + 2 - rank) / (DRAWS + 1)
    return float(np.log(min(len(found) * two_sided.min(), 1.0)))


def _moments(coefficients: np.ndarray) -> np.ndarray:
    """Return skewness and kurtosis of signals, shape (signals, 2), from their cosine coefficients in rows."""
    values = _signals(coefficients)
    scaled = values / values.std(axis=1, keepdims=True)
    return np.column_stack([np.mean(scaled**3, axis=1), np.mean(scaled**4, axis=1)])


def _signals(coefficients: np.ndarray) -> np.ndarray:
    """Return signals, shape (signals, 2 m), from their cosine coefficients k = 1..m in rows."""
    return idct(np.pad(coefficients, ((0, 0), (1, coefficients.shape[1] - 1))), norm="ortho")


def _stationarity_log_p(own: np.ndarray, weight: np.ndarray) -> float:
    """Return the log-probability of the divergence of the power over time, summed over octaves, in stationary noise.

    Its mean is half the number of blocks less one per octave; below it no draws are made and 0 is returned.
    """
    found = float(_power_divergence(own[None], weight)[0]) - TOLERATED_DIVERGENCE * _effective_number(weight)
    if found < 0.5 * sum(blocks - 1 for _, _, blocks in _octaves(len(weight))):
        return 0.0
    drawn = _simulated(lambda noise: _power_divergence(noise, weight), weight)
    return float(np.log((np.sum(drawn >= found) + 1) / (DRAWS + 1)))


def _power_divergence(coefficients: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the divergence of the power of blocks of time from the mean, summed over octaves, shape (signals,)."""
    total = np.zeros(len(coefficients))
    for first, last, blocks in _octaves(len(weight)):
        energy = _signals(coefficients[:, first:last]) ** 2
        sums = np.add.reduceat(energy, np.linspace(0, energy.shape[1], blocks + 1).astype(int)[:-1], axis=1)
        number = _effective_number(weight[first:last]) / blocks
        total += divergence(number * blocks * sums / sums.sum(axis=1, keepdims=True), number).sum(axis=1)
    return total


def _octaves(count: int) -> list[tuple[int, int, int]]:
    """Return first coefficient, last one + 1, and number of time blocks of each octave with at least two blocks."""
    edges = [0, *(FIRST_OCTAVE << k for k in range(count.bit_length()) if FIRST_OCTAVE << (k + 1) <= count), count]
    octaves = ((first, last, min((last - first) // MIN_PER_BLOCK, MAX_BLOCKS)) for first, last in pairwise(edges))
    return [octave for octave in octaves if octave[2] > 1]


def _effective_number(weight: np.ndarray) -> float:
    """Return the effective number of weighted coefficients, (sum w)^2 / sum w^2."""
    return float(np.sum(weight) ** 2 / np.sum(weight**2))
