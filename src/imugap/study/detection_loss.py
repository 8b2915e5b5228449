"""Loss of a search against the test that knows what it looks for.

Size 1 is the detection limit: the most powerful test of a known effect on a known axis, of known shape, at a
false-alarm probability of 1 %, has a power of one half there (Neyman & Pearson 1933, Phil. Trans. R. Soc. A 231;
:mod:`imu_benchmark.sealing.detection_limits`).
A search knows neither; its loss is the size at which it finds one half, less one.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm

ALPHA = 0.01
"""False-alarm probability of the test and of the search, over all that either looks at."""
Z = float(norm.isf(ALPHA))
LEVEL = 0.95
SLOPES = np.geomspace(1.0, 30.0, 40)
"""Slopes of the power over the logarithm of the size, in standard deviations of the test, that are tried."""
GRID = 400


@dataclass(frozen=True)
class HalfSize:
    """Size at which one half is found, with its 95 % interval; infinite where the sizes do not bound it."""

    value: float
    low: float
    high: float


def oracle_power(size: np.ndarray, order: int = 1) -> np.ndarray:
    """Return the power of the test that knows the effect, over the size in detection limits.

    ``order`` is the power of the size with which the signal-to-noise ratio grows: one for a known waveform in Gaussian
    noise, two for a random process, whose variance it is that shows.
    """
    return norm.cdf(Z * (np.asarray(size, float) ** order - 1))


def bonferroni_half_size(choices: float, order: int = 1) -> float:
    """Return the size at which the same test finds one half where it has to choose among a number of alternatives.

    That many tests at the false-alarm probability :data:`ALPHA` together, the union bound of which is nearly reached by
    independent ones.
    """
    return float((norm.isf(ALPHA / choices) / Z) ** (1 / order))


def half_size(size: np.ndarray, found: np.ndarray) -> HalfSize:
    """Estimate the size at which one half is found, from single trials.

    Probit regression on the logarithm of the size by maximum likelihood, with the interval of the likelihood ratio
    (Wilks 1938); the slope is free within :data:`SLOPES`, which keeps it finite where all smaller ones are missed and
    all larger ones found.

    Parameters
    ----------
    size, found
        Size of each trial, and whether it was found, shape (n,) each.
    """
    at, hit = np.log(np.asarray(size, float)), np.asarray(found, bool)
    reach = np.ptp(at) or 1.0
    places = np.linspace(at.min() - reach, at.max() + reach, GRID)
    argument = SLOPES[:, None, None] * (at - places[None, :, None])
    profile = norm.logcdf(np.where(hit, argument, -argument)).sum(axis=2).max(axis=0)
    inside = np.flatnonzero(profile >= profile.max() - chi2.isf(1 - LEVEL, 1) / 2)
    low = 0.0 if inside[0] == 0 else float(np.exp(places[inside[0]]))
    high = np.inf if inside[-1] == GRID - 1 else float(np.exp(places[inside[-1]]))
    best = float(np.exp(np.mean(places[profile >= profile.max() - 1e-9])))
    return HalfSize(best if hit.any() else np.inf, low, high)
