"""Is noise what its name says? Its spectrum, its samples, and means that wander as it does."""

from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np
from scipy.optimize import minimize
from scipy.special import log_ndtr
from scipy.stats import ncx2

from imugap.discovery.checks.gaussianity import BURSTS, MIN_SHARE, UNEVEN, sample_misfits
from imugap.discovery.checks.hysteresis import noise_against_temperature
from imugap.discovery.checks.misfit import LEVEL, Misfit, divergence, log_p_against
from imugap.discovery.checks.periodic import effect_against_periodic
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.telegraph_likelihood import compare
from imugap.discovery.fit.whittle import STEP, Noise, limits, log_likelihood
from imugap.discovery.search.search import PARAMETER, Key, Search, at, coloured, log_chance, without
from imugap.discovery.views.spectral import of_spectrum
from imugap.effects.effect import TINY, Effect, StochasticEffect
from imugap.effects.power_law import PowerLaw

SLOPE, POWER_LAW = "its spectrum has another slope", "a power law of another slope explains it better"
POWER_LAW_AS_WELL = "a power law explains it as well"
SLOPE_REASONS = (SLOPE, POWER_LAW, POWER_LAW_AS_WELL)
"""Doubts that leave slow noise a process, of a slope that has no name."""
AT_ODDS = "its samples and its spectrum disagree"
AROUND_IT = "the spectrum around it is farther off"
BURST_REASONS = (AT_ODDS, BURSTS, UNEVEN)
"""Doubts that leave slow noise something that comes and goes, and changes the variance as it does."""
ALL_SLOW = "one power law explains all slow noise better"
NOISE_REASONS = (*SLOPE_REASONS, AT_ODDS, ALL_SLOW)
"""Doubts that leave slow noise, of whatever spectrum, noise."""
OTHER_SLOPE = np.log(1e-2)
"""Log-probability of chance below which a free slope of slow noise makes a doubt: no other test answers it as well."""
LIKELIER = 2.0
"""Log-likelihood by which a process of two parameters has to be likelier than a power law, which has as many.

Of fractional noise between flicker and walk a Gauss-Markov process is seldom likelier by more.
"""
STEEP = 1.5, 2.5, 3.5
"""Slopes from which a power law is fitted: from the first if it stands for noise, from all if for means too."""
AROUND = 10.0
"""Factor of the frequencies that an effect answers for within which the spectrum is around it."""
BANDS = 24
SLIGHT = 0.05
"""Relative deviation of the power in a band that leaves a name as it is: no real spectrum is one of a catalogue."""


def noise_misfit(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Test the spectrum where the process answers for it, the samples, and what else wanders as it does."""
    effect = at(fit.description, key)
    bins = fit.sequence.bins
    share = power_share(fit, effect)
    slope = _score(fit, share * np.log(bins.frequency / bins.frequency[0]))
    mine = np.flatnonzero(share > MIN_SHARE)
    named = search.likelihood_ratio(fit, key)[0].log_p
    misfits = [
        Misfit(SLOPE, slope),
        Misfit("its spectrum has another shape", band_log_p(fit, mine)),
        Misfit(AROUND_IT, log_p_against(named, _off_around(fit, mine), search.log_alpha)),
    ]
    if effect.two_valued:
        misfits += _two_valued(search, fit, key)
    else:
        misfits += sample_misfits(fit, share)
    if coloured(effect):
        misfits += [effect_against_periodic(search, fit, key), noise_against_temperature(search, fit, key)]
    return min([*misfits, *_power_law(search, fit)], key=lambda misfit: misfit.log_p)


def filter_misfit(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Ask whether the filter is surer than what it leaves of the spectrum where it acts.

    Its shape is no matter: the filters of the catalogue stand for all low-pass filters.
    """
    bins = fit.sequence.bins
    acts = np.flatnonzero(at(fit.description, key).gain(bins.frequency, bins.interval) < 1 - MIN_SHARE)
    named = search.likelihood_ratio(fit, key)[0].log_p
    return Misfit(AROUND_IT, log_p_against(named, _off_around(fit, acts), search.log_alpha))


def _two_valued(search: Search, fit: AxisFit, key: Key) -> list[Misfit]:
    """Ask whether both values are as frequent, and, of telegraph noise alone, whether samples and spectrum agree."""
    verdict = compare(fit, (at(fit.description, key),))
    uneven = Misfit("it is at one of its values more often than at the other", log_chance(verdict.uneven, 1))
    if sum(key.part == "noise" for key in search.added(fit.description)) > 1:
        return [uneven]
    return [uneven, Misfit(AT_ODDS, substitution_log_p(fit, key, verdict.effect))]


def power_share(fit: AxisFit, effect: StochasticEffect) -> np.ndarray:
    """Return the share of an effect in the variance of each bin."""
    bins, noise = fit.sequence.bins, fit.description.noise
    own = Noise((effect,), noise.output_filter).passed(bins)
    return own / noise.variance(bins)


def substitution_log_p(fit: AxisFit, key: Key, other: StochasticEffect) -> float:
    """Return the log-probability that the spectrum is as unlikely as it is with another effect at ``key``.

    All else of the noise, and the filter, are free to follow it.
    """
    bins, noise = fit.sequence.bins, fit.description.noise
    power = bins.sums(fit.coefficients**2) * noise.variance(bins)
    moved = replace(noise, effects=tuple(other if i == key.index else one for i, one in enumerate(noise.effects)))
    free = np.array([index != key.index for index, _ in moved.parameters()])

    def loss(theta: np.ndarray) -> float:
        placed = moved.theta()
        placed[free] = theta
        return -log_likelihood(moved.at(placed).variance(bins), power, bins.number)

    bounds = np.transpose(limits(moved, bins, power))[free]
    here = minimize(loss, np.clip(moved.theta()[free], *bounds.T), method="L-BFGS-B", bounds=bounds)
    best = log_likelihood(noise.variance(bins), power, bins.number)
    return log_chance(best + here.fun, len(other.parameters()))


def _score(fit: AxisFit, direction: np.ndarray) -> float:
    """Return the log-probability of the score of the log-spectrum in a direction, the parameters free to follow."""
    bins = fit.sequence.bins
    weighted = np.sqrt(bins.number / 2)
    basis = np.linalg.qr(_directions(fit).T)[0]
    rest = direction * weighted - basis @ (basis.T @ (direction * weighted))
    excess = (bins.sums(fit.coefficients**2) / bins.number - 1) * weighted
    norm = rest @ rest
    return log_chance(0.5 * float(rest @ excess) ** 2 / norm, 1) if norm > 1e-6 else 0.0


def _directions(fit: AxisFit) -> np.ndarray:
    """Return how the log-spectrum answers each parameter of the noise, over its standard error, (parameters, bins)."""
    bins, noise = fit.sequence.bins, fit.description.noise
    theta, variance = noise.theta(), noise.variance(bins)
    slopes = [(noise.at(theta + step).variance(bins) / variance - 1) / STEP for step in STEP * np.eye(len(theta))]
    return np.array(slopes) * np.sqrt(bins.number / 2)


def _spent(fit: AxisFit, some: np.ndarray) -> float:
    """Return how many of the parameters of the noise some of the bins tell: the trace of their share in what all do."""
    directions = _directions(fit)
    whole, part = directions @ directions.T, directions[:, some] @ directions[:, some].T
    return float(np.trace(np.linalg.pinv(whole, hermitian=True) @ part))


def _off_around(fit: AxisFit, mine: np.ndarray) -> float:
    """Return the log-probability of the band of power that is farthest from the fit, within or around some bins."""
    if not len(mine):
        return 0.0
    low, high = fit.sequence.bins.frequency[mine[[0, -1]]]
    curve = of_spectrum(fit)
    near = (curve.high > low / AROUND) & (curve.low < high * AROUND)
    chance = np.log(2 * near.sum()) + log_ndtr(-np.abs(curve.statistic[near]).max(initial=0.0))
    return min(float(chance), 0.0)


def band_log_p(fit: AxisFit, mine: np.ndarray) -> float:
    """Return the log-probability that power is as far from the fit in bands of some bins, slight deviations aside."""
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
    free = max(used.sum() - _spent(fit, mine[used[band]]), 1.0)
    slight = 0.5 * SLIGHT**2 * float(number[used].sum())
    chance = float(ncx2.sf(np.sum(normal**2), free, slight))
    return float(np.log(max(chance, TINY)))


def replaced_by_power_law(search: Search, fit: AxisFit, which: Callable[[Effect], bool]) -> AxisFit | None:
    """Return the fit with one power law in the place of the added processes for which ``which`` holds, if any."""
    slow = _added(search, fit, which)
    if not slow:
        return None
    return add_power_law(search, _without(search, fit, slow))


def _slow(effect: Effect) -> bool:
    return effect.slow


def power_law_advantage(search: Search, fit: AxisFit, keys: Sequence[Key]) -> float:
    """Return by how much one power law, however steep, is worth more than several means and slow noise together.

    Each of these is one of the catalogue, and costs that too.
    """
    own = [search.likelihood_ratio(fit, key)[0] for key in keys]
    bare = search.fitted(fit.sequence, without(fit, keys).description)
    laws = [add_power_law(search, bare, slope).log_likelihood for slope in STEEP]
    costs = sum(one.cost + np.log(len(search.catalogue)) for one in own)
    law = max(laws) - PARAMETER * len(fields(PowerLaw)) - np.log(len(search.catalogue))
    return float(law - fit.log_likelihood + costs)


def add_power_law(search: Search, bare: AxisFit, slope: float = STEEP[0]) -> AxisFit:
    """Return a fit with a power law more, from a slope."""
    size = max(bare.room(PowerLaw(1.0, slope)), 1e-12 * float(np.sqrt(bare.variance.mean())))
    noise = bare.description.noise
    law = replace(noise, effects=(*noise.effects, PowerLaw(size, slope)))
    return search.fitted(bare.sequence, replace(bare.description, noise=law))


def _added(search: Search, fit: AxisFit, which: Callable[[Effect], bool]) -> list[StochasticEffect]:
    added = fit.description.noise.effects[len(search.start.noise.effects) :]
    return [effect for effect in added if which(effect)]


def _without(search: Search, fit: AxisFit, effects: list[StochasticEffect]) -> AxisFit:
    """Return the fit without some of its random processes."""
    noise = fit.description.noise
    kept = tuple(effect for effect in noise.effects if not any(effect is one for one in effects))
    return search.fitted(fit.sequence, replace(fit.description, noise=replace(noise, effects=kept)))


def _power_law(search: Search, fit: AxisFit) -> list[Misfit]:
    """Weigh one power law against the added slow processes: its slope may be another, or it says more than two do."""
    other, slow = replaced_by_power_law(search, fit, _slow), _added(search, fit, _slow)
    if other is None:
        return []
    more = other.log_likelihood - fit.log_likelihood
    parameters = sum(len(one.parameters()) for one in slow)
    if parameters == 1:
        chance = log_chance(more, 1)
        return [Misfit(POWER_LAW, LEVEL - OTHER_SLOPE + chance)]
    if len(slow) == 1:
        return [Misfit(POWER_LAW_AS_WELL, LEVEL - LIKELIER - more)]
    bare = _without(search, fit, slow)
    named = log_chance(fit.log_likelihood - bare.log_likelihood, parameters)
    unnamed = log_chance(other.log_likelihood - bare.log_likelihood, 2)
    return [Misfit(ALL_SLOW, LEVEL + unnamed - named)]
