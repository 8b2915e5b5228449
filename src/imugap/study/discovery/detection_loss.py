"""Loss of a search against the test that knows what it looks for.

Size 1 is the detection limit: the most powerful test of a known effect on a known axis, of known shape, at a
false-alarm probability of 1 %, has a power of one half there (Neyman & Pearson 1933, Phil. Trans. R. Soc. A 231;
:mod:`imu_benchmark.sealing.detection_limits`).
A search knows none of these; its loss is the size at which it finds one half, less one.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm

from imu_benchmark.sealing.detection_limits import Z

ALPHA = float(norm.sf(Z))
"""False-alarm probability of the test and of the search, over all that either looks at."""
LEVEL = 0.95
"""Probability of an interval."""
SLOPES = np.geomspace(1.0, 30.0, 40)
"""Slopes of the power over the logarithm of the size, in standard deviations of the test, that are tried."""
GRID = 400
"""Half sizes that are tried."""


@dataclass(frozen=True)
class HalfSize:
    """Size [limits] at which one half is found, with its 95 % interval; infinite where the trials do not bound it."""

    value: float
    low: float
    high: float


def oracle_power(size: np.ndarray) -> np.ndarray:
    """Return the power of the test that knows the effect, a waveform in Gaussian noise, over the size [limits]."""
    return norm.cdf(Z * (np.asarray(size, float) - 1))


def bonferroni_half_size(choices: float) -> float:
    """Return the size [limits] at which the same test finds one half where it chooses among a number of waveforms.

    Each is tested at a part of the false-alarm probability :data:`ALPHA`; independent tests nearly reach this bound.
    """
    return float(norm.isf(ALPHA / choices) / Z)


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
