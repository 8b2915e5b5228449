"""Tests of outliers: rare single samples at independent times, in noise that is otherwise Gaussian."""

import numpy as np
from scipy.special import ndtr
from scipy.stats import binom, ncx2

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit
from imugap.discovery.checks.motion import outliers_against_motion
from imugap.discovery.checks.noise_law import noise_law
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Candidate
from imugap.effects.effect import TINY
from imugap.stream import stream

CORE_WIDTH, CORE_VARIANCE = 2.0, 0.7737413
"""Half-width of the core [standard deviations], and variance of a standard normal truncated to it."""
ITERATIONS, BINS = 40, 12
"""Iterations for mean and standard deviation of the core, and bins of equal probability in it."""
MAX_PROBABILITY = 0.1
"""Maximum fraction of the samples for outliers; above it they are the tails of another distribution."""
OTHER_LAW = "all samples are of another distribution"
ONE_SIDED = "most of them go to one side"
TOLERATED_SIDE = 2 / 3
"""Tolerated share of the outliers on one side, as real ones have it."""
TOLERATED_DEVIATION = 0.005
"""Tolerated squared relative deviation of the density of the core from the normal one, as real noise has it."""


def outliers_misfit(candidate: Candidate) -> Misfit:
    """Test whether outliers are rare, independent, even in time and side, unrelated to the motion, and the core normal.

    Uniformity in time is not tested where the variance changes.
    """
    fit, found = candidate.fit, candidate.search.tails[candidate.effect]
    misfits = [
        Misfit("they are not rare", MAX_LOG_P - 1.0 if found.probability > MAX_PROBABILITY else 0.0),
        Misfit("they come in clusters", found.clustered),
        Misfit("they come with the motion", outliers_against_motion(fit, found.flagged)),
        Misfit("they come at a beat", found.beating),
        Misfit(ONE_SIDED, _one_sided_log_p(candidate, found.flagged)),
        Misfit(OTHER_LAW, _core_normality_log_p(fit)),
        Misfit(OTHER_LAW, -np.inf if _law_explains(candidate) else 0.0),
    ]
    if not fit.description.changes:
        misfits.append(Misfit("they come at some times more often than at others", found.uneven))
    return min(misfits, key=lambda misfit: misfit.log_p)


def _one_sided_log_p(candidate: Candidate, flagged: np.ndarray) -> float:
    """Return the log-probability of so many outliers on one side (binomial, two-sided, tolerated)."""
    fit = candidate.fit
    raw = candidate.search.raw.get(candidate.effect, fit.sequence)
    above = raw.values[flagged] > fit.sequence.values[flagged]
    most = max(above.sum(), len(above) - above.sum())
    return min(float(np.log(2) + binom.logsf(most - 1, len(above), TOLERATED_SIDE)), 0.0)


def _law_explains(candidate: Candidate) -> bool:
    """Return whether the samples with the outliers have a law of the catalogue."""
    search = candidate.search
    return noise_law(search.with_outlier_samples(candidate.fit), search.catalogue, search.log_alpha) is not None


def _core_normality_log_p(fit: AxisFit) -> float:
    """Return the log-probability of the chi-square of the core against a normal distribution (noncentral, tolerated).

    Outliers have been replaced before; values on a fine lattice are dithered over its step.
    """
    axis, step = fit.sequence.conditions.axis, 0.0 if fit.sequence.coarse else fit.sequence.step
    width = step / fit.unit
    values = fit.unrounded + width * (stream(0, "core", axis).random(len(fit.unrounded)) - 0.5)
    middle, scale = np.median(values), values.std()
    for _ in range(ITERATIONS):
        core = (values[np.abs(values - middle) < CORE_WIDTH * scale] - middle) / scale
        middle, scale = middle + 2 * core.mean() * scale, scale * np.mean(core**2) / CORE_VARIANCE
    place = (ndtr(core) - ndtr(-CORE_WIDTH)) / (ndtr(CORE_WIDTH) - ndtr(-CORE_WIDTH))
    counts = np.bincount((place * BINS).astype(int).clip(0, BINS - 1), minlength=BINS)
    expected = len(core) / BINS
    p_value = ncx2.sf(np.sum((counts - expected) ** 2) / expected, BINS - 3, TOLERATED_DEVIATION * len(core))
    return float(np.log(max(p_value, TINY)))
