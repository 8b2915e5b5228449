"""Detection limits: the least size of an effect that the best test can detect.

The measure is the expected log-likelihood ratio of the samples with the effect against the samples without it, the
Kullback-Leibler divergence, and the limit is where it is :data:`GAIN`. For a known waveform in Gaussian noise this is
the amplitude at which the matched test with 1 % false alarms has a power of 50 %, 2.33 Cramer-Rao standard deviations;
for a weak spectrum it is the same multiple of the Cramer-Rao standard deviation of its power. The bias and the level of
the noise count as unknown: the mean is excluded, and the level is the one of least divergence.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.fft import dct
from scipy.optimize import brentq
from scipy.stats import norm

Z = float(norm.ppf(0.99))
GAIN = Z**2 / 2


def matched_test(waveforms: Sequence[np.ndarray], variances: Sequence[np.ndarray]) -> float:
    """Return Z/sqrt(sum |c_k|^2/v_k), the detection limit of the amplitude of known ``waveforms``, shape (n,) each.

    ``variances``, shape (n - 1,) each, are the v_k of the cosine coefficients of the noise (:mod:`.noise`); the c_k
    are the coefficients of the waveforms of amplitude one. Axes add up.
    """
    energy = sum(np.sum(dct(w, norm="ortho")[1:] ** 2 / v) for w, v in zip(waveforms, variances, strict=True))
    return float(Z / np.sqrt(energy))


def divergence(ratio: np.ndarray) -> float:
    """Return n/2 (log mean r - mean log r) for the ratios r of n variances with and without the effect.

    It is the divergence of independent Gaussian values (over time or frequency) from the nearest ones whose variances
    are a common multiple of those without the effect.
    """
    return float(len(ratio) / 2 * (np.log(np.mean(ratio)) - np.mean(np.log(ratio))))


def spectral_test(extra: np.ndarray, variance: np.ndarray) -> float:
    """Return the least amplitude a at which n variances ``variance`` + a^2 ``extra`` differ from ``variance``."""
    ratio = extra / variance
    return solve(lambda a: divergence(1 + a**2 * ratio), 1e-6 / np.sqrt(ratio.max()), 1e6 / np.sqrt(ratio.max()))


def solve(gain: Callable[[float], float], low: float, high: float, goal: float = GAIN) -> float:
    """Return the size within (``low``, ``high``), both positive, at which the growing function ``gain`` is ``goal``."""
    return float(np.exp(brentq(lambda x: gain(np.exp(x)) - goal, np.log(low), np.log(high), xtol=1e-6)))
