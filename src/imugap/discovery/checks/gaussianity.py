"""Is noise Gaussian, and as strong at one time as at another? What its samples say that its spectrum does not.

Both are asked of the whitened log, each frequency weighed by the share that the noise has in it: an impulse in what
drives a process stays one there. Gaussian noise so weighed is drawn :data:`DRAWN` times.
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
"""Share of the variance of a coefficient above which it says something of the noise."""
DRAWN, PARTS, FEWEST, MOST = 1999, 20, 40, 6000
"""Draws of Gaussian noise, how many parts they are handled in; the fewest coefficients that tell its shape, the most
that are asked."""
USUAL = (-1.0, 1.0), (2.0, 6.0)
"""Skewness and kurtosis that leave a name as it is: no real noise is quite Gaussian; up to that of Laplace's law."""
OCTAVE, EACH, BLOCKS = 16, 8, 32
"""Coefficients in the lowest band, the others being octaves; in each block of time at least; blocks at most."""
TOLERATED_DIVERGENCE = 0.01
"""Divergence of the power of blocks, over their coefficients, that leaves a name as it is: up to a fifth of it."""


def sample_misfits(fit: AxisFit, share: np.ndarray) -> tuple[Misfit, ...]:
    """Return the doubts whether noise with such a share in the bins is Gaussian, and whether it is stationary.

    Where the variance changes it is not known of which noise, so that none is asked whether it is stationary.
    """
    bins = fit.sequence.bins
    weight = bins.spread(np.maximum(share, TINY))[: min(bins.last, MOST)]
    weight = weight[: max(np.flatnonzero(weight > MIN_SHARE), default=0) + 1]
    if len(weight) < FEWEST:
        return ()
    own = weight * fit.coefficients[: len(weight)]
    jumps = Misfit(BURSTS, _uncommon(own, weight))
    fading = 0.0 if fit.description.changes else _fading(own, weight)
    return jumps, Misfit(UNEVEN, fading)


def _drawn(statistic: Callable[[np.ndarray], np.ndarray], weight: np.ndarray) -> np.ndarray:
    """Return a statistic of Gaussian signals with weighed coefficients, shape (:data:`DRAWN`, ...)."""
    noise = weight * stream(0, "uncommon", len(weight)).standard_normal((DRAWN, len(weight)))
    return np.concatenate([statistic(part) for part in np.array_split(noise, PARTS)])


def _uncommon(own: np.ndarray, weight: np.ndarray) -> float:
    """Return the log-probability that Gaussian noise is as skewed, or of as high or low a kurtosis."""
    found = _shape(own[None])[0]
    if all(low < value < high for value, (low, high) in zip(found, USUAL, strict=True)):
        return 0.0
    rank = np.sum(_drawn(_shape, weight) >= found, axis=0) + 1
    two_sided = 2 * np.minimum(rank, DRAWN + 2 - rank) / (DRAWN + 1)
    return float(np.log(min(len(found) * two_sided.min(), 1.0)))


def _shape(coefficients: np.ndarray) -> np.ndarray:
    """Return skewness and kurtosis of signals, shape (signals, 2), from their cosine coefficients in rows."""
    values = _signals(coefficients)
    scaled = values / values.std(axis=1, keepdims=True)
    return np.column_stack([np.mean(scaled**3, axis=1), np.mean(scaled**4, axis=1)])


def _signals(coefficients: np.ndarray) -> np.ndarray:
    """Return signals, shape (signals, 2 m), from their cosine coefficients k = 1..m in rows."""
    return idct(np.pad(coefficients, ((0, 0), (1, coefficients.shape[1] - 1))), norm="ortho")


def _fading(own: np.ndarray, weight: np.ndarray) -> float:
    """Return the log-probability that the power of stationary noise is as uneven over time, in octaves.

    On average a block diverges by half, less one half for each octave; noise that does by less is even: none is drawn.
    """
    found = float(_unevenness(own[None], weight)[0]) - TOLERATED_DIVERGENCE * _number(weight)
    if found < 0.5 * sum(blocks - 1 for _, _, blocks in _octaves(len(weight))):
        return 0.0
    drawn = _drawn(lambda noise: _unevenness(noise, weight), weight)
    return float(np.log((np.sum(drawn >= found) + 1) / (DRAWN + 1)))


def _unevenness(coefficients: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Return the divergence of the power of blocks of time from that of all, of each signal, summed over octaves."""
    total = np.zeros(len(coefficients))
    for first, last, blocks in _octaves(len(weight)):
        energy = _signals(coefficients[:, first:last]) ** 2
        sums = np.add.reduceat(energy, np.linspace(0, energy.shape[1], blocks + 1).astype(int)[:-1], axis=1)
        number = _number(weight[first:last]) / blocks
        total += divergence(number * blocks * sums / sums.sum(axis=1, keepdims=True), number).sum(axis=1)
    return total


def _octaves(count: int) -> list[tuple[int, int, int]]:
    """Return first coefficient, last one + 1, and number of blocks of time of each octave that has two at least."""
    edges = [0, *(OCTAVE << k for k in range(count.bit_length()) if OCTAVE << (k + 1) <= count), count]
    octaves = ((first, last, min((last - first) // EACH, BLOCKS)) for first, last in pairwise(edges))
    return [octave for octave in octaves if octave[2] > 1]


def _number(weight: np.ndarray) -> float:
    """Return how many coefficients of equal weight say as much as weighed ones."""
    return float(np.sum(weight) ** 2 / np.sum(weight**2))
