"""Tests of noise: slope and shape of its spectrum, distribution of its samples, and unnamed alternatives."""

from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np
from scipy.optimize import minimize
from scipy.stats import ncx2

from imugap.discovery.checks.gaussianity import BURSTS, MIN_SHARE, UNEVEN, sample_misfits
from imugap.discovery.checks.hysteresis import noise_against_temperature
from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, divergence, log_p_against
from imugap.discovery.checks.periodic import effect_against_periodic
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.telegraph_likelihood import compare
from imugap.discovery.fit.whittle import DIFFERENCE_STEP, Noise, limits, log_likelihood
from imugap.discovery.search.search import PARAMETER_COST, Candidate, Search, coloured, log_p_of_gain, without
from imugap.discovery.views.spectral import of_spectrum
from imugap.effects.effect import TINY, Effect, Role, StochasticEffect
from imugap.effects.power_law import PowerLaw
from imugap.numerics.samples.white_samples import two_sided_log_p

SLOPE, POWER_LAW = "its spectrum has another slope", "a power law of another slope explains it better"
POWER_LAW_AS_WELL = "a power law explains it as well"
SLOPE_REASONS = (SLOPE, POWER_LAW, POWER_LAW_AS_WELL)
"""Reasons after which slow noise is still one process, of a slope without a name."""
SAMPLES_DISAGREE = "its samples and its spectrum disagree"
SHAPE = "its spectrum has another shape"
NEIGHBOURHOOD = "the spectrum around it is farther off"
BURST_REASONS = (SAMPLES_DISAGREE, BURSTS, UNEVEN)
"""Reasons after which slow noise is intermittent, and may change the variance."""
ONE_POWER_LAW = "one power law explains all slow noise better"
NOISE_REASONS = (*SLOPE_REASONS, SAMPLES_DISAGREE, ONE_POWER_LAW)
"""Reasons after which slow noise is still noise, of any spectrum."""
MAX_SLOPE_LOG_P = np.log(1e-2)
"""Maximum log p-value of a free slope for a misfit of slow noise of one parameter."""
MIN_GAIN = 2.0
"""Minimum log-likelihood gain of a process of two parameters over a power law, which has two as well.

The gain of a Gauss-Markov process in fractional noise between flicker noise and random walk is seldom larger.
"""
START_SLOPES = 1.5, 2.5, 3.5
"""Start values of the slope of a power law: the first in place of noise, all in place of terms and noise."""
NEIGHBOURHOOD_RATIO = 10.0
"""Ratio to the frequencies of an effect within which the spectrum is its neighbourhood."""
MAX_RIPPLE_SHARE = 0.1
"""Maximum log p-value of a ripple that is left, over that of a filter whose gain has ripples."""
BANDS = 24
TOLERATED_DEVIATION = 0.05
"""Tolerated relative deviation of the power in a band, as real spectra have it."""


def noise_misfit(candidate: Candidate) -> Misfit:
    """Test slope and shape of the spectrum, the samples, and unnamed alternatives of a noise process."""
    search, fit, effect = candidate.search, candidate.fit, candidate.effect
    bins = fit.sequence.bins
    share = power_share(fit, effect)
    slope = _score_log_p(fit, share * np.log(bins.frequency / bins.frequency[0]))
    mine = np.flatnonzero(share > MIN_SHARE)
    near = _neighbourhood_log_p(fit, mine)
    misfits = [
        Misfit(SLOPE, slope),
        Misfit(SHAPE, band_log_p(fit, mine)),
        Misfit(NEIGHBOURHOOD, log_p_against(candidate.trial.log_p, near, search.log_alpha)),
    ]
    if effect.two_valued:
        misfits += _two_valued_misfits(candidate)
    else:
        misfits += sample_misfits(fit, share)
    if coloured(effect):
        misfits += [effect_against_periodic(candidate), noise_against_temperature(candidate)]
    return min([*misfits, *_against_power_law(search, fit)], key=lambda misfit: misfit.log_p)


def filter_misfit(candidate: Candidate) -> Misfit:
    """Test whether the filter is more significant than the deviation of the spectrum that remains where it acts.

    Its shape is tested where its gain has ripples: the other filters of the catalogue represent all low-pass filters.
    """
    fit, bins = candidate.fit, candidate.fit.sequence.bins
    acts = np.flatnonzero(np.abs(candidate.effect.gain(bins.frequency, bins.interval) - 1) > MIN_SHARE)
    named, log_alpha = candidate.trial.log_p, candidate.search.log_alpha
    near = Misfit(NEIGHBOURHOOD, log_p_against(named, _neighbourhood_log_p(fit, acts), log_alpha))
    if not candidate.effect.rippled:
        return near
    left = log_p_against(MAX_RIPPLE_SHARE * named, ripple_log_p(fit), log_alpha)
    return min(near, Misfit(SHAPE, min(left, band_log_p(fit, acts))), key=lambda misfit: misfit.log_p)


def ripple_log_p(fit: AxisFit) -> float:
    """Return the log p-value of the highest ripple in the spectrum of the residual (Bonferroni)."""
    _, gains = fit.ripples
    return min(log_p_of_gain(float(gains.max()), 1) + float(np.log(len(gains))), 0.0)


def _two_valued_misfits(candidate: Candidate) -> list[Misfit]:
    """Test whether both values are equally frequent, and, without other noise, whether samples and spectrum agree."""
    comparison = compare(candidate.fit, (candidate.effect,))
    uneven = Misfit("it is at one of its values more often than at the other", log_p_of_gain(comparison.uneven, 1))
    if len(candidate.search.added(candidate.fit, lambda effect: effect.role is Role.NOISE)) > 1:
        return [uneven]
    return [uneven, Misfit(SAMPLES_DISAGREE, substitution_log_p(candidate, comparison.effect))]


def power_share(fit: AxisFit, effect: StochasticEffect) -> np.ndarray:
    """Return the share of a process in the variance of each bin, shape (bins,)."""
    bins, noise = fit.sequence.bins, fit.description.noise
    own = Noise((effect,), noise.output_filter).passed(bins)
    return own / noise.variance(bins)


def substitution_log_p(candidate: Candidate, other: StochasticEffect) -> float:
    """Return the log-probability of the loss of likelihood with another process in the place of one, held as it is.

    All other parameters of the noise and the filter are refitted.
    """
    fit = candidate.fit
    bins, noise = fit.sequence.bins, fit.description.noise
    power = bins.sums(fit.coefficients**2) * noise.variance(bins)
    moved = fit.description.with_effect(candidate.index, other).noise
    own = candidate.index - len(fit.description.terms)
    free = np.array([index != own for index, _ in moved.parameters])

    def loss(theta: np.ndarray) -> float:
        placed = moved.theta()
        placed[free] = theta
        return -log_likelihood(moved.at(placed).variance(bins), power, bins.number)

    bounds = np.transpose(limits(moved, bins, power))[free]
    here = minimize(loss, np.clip(moved.theta()[free], *bounds.T), method="L-BFGS-B", bounds=bounds)
    best = log_likelihood(noise.variance(bins), power, bins.number)
    return log_p_of_gain(best + here.fun, len(other.parameters()))


def _score_log_p(fit: AxisFit, direction: np.ndarray) -> float:
    """Return the log-probability of the score of the log-spectrum in a direction, the parameters profiled out."""
    bins = fit.sequence.bins
    weighted = np.sqrt(bins.number / 2)
    basis = np.linalg.qr(_sensitivities(fit).T)[0]
    rest = direction * weighted - basis @ (basis.T @ (direction * weighted))
    excess = (bins.sums(fit.coefficients**2) / bins.number - 1) * weighted
    norm = rest @ rest
    return log_p_of_gain(0.5 * float(rest @ excess) ** 2 / norm, 1) if norm > 1e-6 else 0.0


def _sensitivities(fit: AxisFit) -> np.ndarray:
    """Return the derivatives of the log-spectrum by the parameters, in standard errors, shape (parameters, bins)."""
    bins, noise = fit.sequence.bins, fit.description.noise
    theta, variance = noise.theta(), noise.variance(bins)
    slopes = [
        (noise.at(theta + step).variance(bins) / variance - 1) / DIFFERENCE_STEP
        for step in DIFFERENCE_STEP * np.eye(len(theta))
    ]
    return np.array(slopes) * np.sqrt(bins.number / 2)


def _effective_parameters(fit: AxisFit, some: np.ndarray) -> float:
    """Return the effective number of parameters that some bins determine, by the trace of their information."""
    directions = _sensitivities(fit)
    whole, part = directions @ directions.T, directions[:, some] @ directions[:, some].T
    return float(np.trace(np.linalg.pinv(whole, hermitian=True) @ part))


def _neighbourhood_log_p(fit: AxisFit, mine: np.ndarray) -> float:
    """Return the log-probability of the largest deviation of power in bands within or around some bins (Bonferroni)."""
    if not len(mine):
        return 0.0
    low, high = fit.sequence.bins.frequency[mine[[0, -1]]]
    curve = of_spectrum(fit)
    near = (curve.high > low / NEIGHBOURHOOD_RATIO) & (curve.low < high * NEIGHBOURHOOD_RATIO)
    log_p = np.log(near.sum()) + two_sided_log_p(np.abs(curve.statistic[near]).max(initial=0.0))
    return min(float(log_p), 0.0)


def band_log_p(fit: AxisFit, mine: np.ndarray) -> float:
    """Return the log-probability of the power in bands of some bins (noncentral chi-square, tolerated deviation)."""
    bins = fit.sequence.bins
    if len(mine) < 2:
        return 0.0
    edges = np.unique(np.geomspace(bins.frequency[mine[0]], bins.frequency[mine[-1]] * 1.001, BANDS + 1))
    band = np.digitize(bins.frequency[mine], edges)
    number = np.bincount(band, bins.number[mine])
    power = np.bincount(band, bins.sums(fit.coefficients**2)[mine])
    used = number >= 8
    deviation = (power[used] / number[used] - 1) * np.sqrt(number[used] / 2)
    normal = np.sign(deviation) * np.sqrt(2 * divergence(power[used], number[used]))
    free = max(used.sum() - _effective_parameters(fit, mine[used[band]]), 1.0)
    slight = 0.5 * TOLERATED_DEVIATION**2 * float(number[used].sum())
    p_value = float(ncx2.sf(np.sum(normal**2), free, slight))
    return float(np.log(max(p_value, TINY)))


def replaced_by_power_law(search: Search, fit: AxisFit, which: Callable[[Effect], bool]) -> AxisFit | None:
    """Return the fit with one power law in place of the added processes for which ``which`` holds, or None."""
    slow = _added_noise(search, fit, which)
    return add_power_law(search, _without_noise(slow)) if slow else None


def _is_slow(effect: Effect) -> bool:
    return effect.slow


def power_law_advantage(some: Sequence[Candidate]) -> float:
    """Return the advantage of one power law over several terms and slow noise, in penalised log-likelihood.

    The penalty includes the choice of each effect from the catalogue.
    """
    search, fit = some[0].search, some[0].fit
    bare = search.fitted(fit.sequence, without(fit, some).description)
    laws = [add_power_law(search, bare, slope).log_likelihood for slope in START_SLOPES]
    costs = sum(one.trial.cost + np.log(len(search.catalogue)) for one in some)
    law = max(laws) - PARAMETER_COST * len(fields(PowerLaw)) - np.log(len(search.catalogue))
    return float(law - fit.log_likelihood + costs)


def add_power_law(search: Search, bare: AxisFit, slope: float = START_SLOPES[0]) -> AxisFit:
    """Return a fit with a power law added, from a start value of its slope."""
    size = max(bare.room(PowerLaw(1.0, slope)), 1e-12 * float(np.sqrt(bare.variance.mean())))
    return search.fitted(bare.sequence, bare.description.adding(PowerLaw(size, slope)))


def _added_noise(search: Search, fit: AxisFit, which: Callable[[Effect], bool]) -> list[Candidate]:
    return search.added(fit, lambda effect: effect.role is Role.NOISE and which(effect))


def _without_noise(some: Sequence[Candidate]) -> AxisFit:
    """Return the fit without some added effects, from the search that added them."""
    search, fit = some[0].search, some[0].fit
    return search.fitted(fit.sequence, fit.description.without(one.index for one in some))


def _against_power_law(search: Search, fit: AxisFit) -> list[Misfit]:
    """Test the added slow processes against one power law of free slope."""
    other, slow = replaced_by_power_law(search, fit, _is_slow), _added_noise(search, fit, _is_slow)
    if other is None:
        return []
    more = other.log_likelihood - fit.log_likelihood
    parameters = sum(len(one.effect.parameters()) for one in slow)
    if parameters == 1:
        log_p = log_p_of_gain(more, 1)
        return [Misfit(POWER_LAW, MAX_LOG_P - MAX_SLOPE_LOG_P + log_p)]
    if len(slow) == 1:
        return [Misfit(POWER_LAW_AS_WELL, MAX_LOG_P - MIN_GAIN - more)]
    bare = _without_noise(slow)
    named = log_p_of_gain(fit.log_likelihood - bare.log_likelihood, parameters)
    unnamed = log_p_of_gain(other.log_likelihood - bare.log_likelihood, 2)
    return [Misfit(ONE_POWER_LAW, MAX_LOG_P + unnamed - named)]
