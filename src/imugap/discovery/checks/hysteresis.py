"""Does it go with the temperature in a way that has no name?

A loop over the temperature, which is a memory of it, wanders as slow noise does, and as means of time do; so does a
curve with a bend.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from imugap.discovery.checks.misfit import LEVEL, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit, Description
from imugap.discovery.search.search import Key, Search, Trial, coloured, log_chance
from imugap.discovery.unnamed.hysteresis import Hysteresis
from imugap.effects.effect import Effect

HYSTERESIS = "a memory of the temperature explains it better"
CURVE = "a curve over the temperature or its rate explains it better"
LEVELS = np.linspace(0.05, 0.95, 8)
"""Quantiles of the temperature at which a curve over it may bend, and of its rate at which one may jump."""
NONE = Misfit(HYSTERESIS, 0.0)


def may_be_hysteresis(effect: Effect) -> bool:
    """Return whether a mean is one that a loop over the temperature may look like."""
    return effect.of_time or effect.of_temperature


def noise_against_temperature(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Weigh a curve and a loop over the temperature in the place of slow noise: of this, or of all."""
    temperature = fit.sequence.conditions.temperature
    if temperature is None or np.ptp(temperature) == 0:
        return NONE
    own, without = search.likelihood_ratio(fit, key)
    bases = without, search.fitted(fit.sequence, _without_slow_noise(fit.description))
    curves = _bends(temperature), _steps(np.gradient(temperature, fit.sequence.conditions.interval))
    bent = max(likelihood_with(base, curve) for base in bases for curve in curves)
    return min(
        Misfit(CURVE, min(LEVEL + UNNAMED_MARGIN + fit.log_likelihood - bent, 0.0)),
        _of_a_loop(search, fit, own, bases),
        key=lambda misfit: misfit.log_p,
    )


def _of_a_loop(search: Search, fit: AxisFit, own: Trial, bases: tuple[AxisFit, AxisFit]) -> Misfit:
    """Weigh a loop in the ``bases``: the fits without the one process, and without any slow one, of the start too."""
    without, _ = bases
    trials = list(_looped(search, bases))
    best = max(trials, key=lambda trial: trial.fit.log_likelihood)
    loop = replace(best, gain=best.fit.log_likelihood - without.log_likelihood)
    return Misfit(HYSTERESIS, log_p_against(own.log_p, loop.log_p, search.log_alpha))


def means_against_hysteresis(search: Search, fit: AxisFit) -> Misfit:
    """Weigh a loop beside the means of a fit, and in the place of those of them that were added.

    A loop holds a straight line: in the place of one it says no more than beside it.
    """
    first = len(search.start.terms)
    added = [term for term in fit.description.terms[first:] if may_be_hysteresis(term.effect)]
    if not added or fit.sequence.conditions.temperature is None:
        return NONE
    beside = list(_looped(search, (fit,)))
    if not beside:
        return NONE
    more = beside[0].log_p
    if all(term.effect.of_temperature and term.free == ("coefficient",) for term in added):
        return Misfit(HYSTERESIS, more)
    kept = tuple(term for term in fit.description.terms if not any(term is one for one in added))
    without = search.fitted(fit.sequence, replace(fit.description, terms=kept))
    (instead,) = _looped(search, (without,))
    named = log_chance(fit.log_likelihood - without.log_likelihood, sum(len(term.free) for term in added))
    return Misfit(HYSTERESIS, min(more, log_p_against(named, instead.log_p, search.log_alpha)))


def _looped(search: Search, fits: Iterable[AxisFit]) -> Iterable[Trial]:
    """Yield the fits with a loop over the temperature more, where it is known and varies."""
    return (search.trial_of(start, fit) for fit in fits for start in Hysteresis.starts(fit))


def _bends(temperature: np.ndarray) -> np.ndarray:
    """Return the temperature, and what is of it above each of a few levels, shape (n, 1 + levels)."""
    return np.column_stack(
        [temperature, *(np.maximum(temperature - level, 0) for level in np.quantile(temperature, LEVELS))]
    )


def _steps(rate: np.ndarray) -> np.ndarray:
    """Return the rate of the temperature, and where it is above zero and a few levels, shape (n, 1 + levels)."""
    return np.column_stack([rate, *(rate > level for level in np.unique([0.0, *np.quantile(rate, LEVELS)]))])


def _without_slow_noise(description: Description) -> Description:
    noise = description.noise
    kept = tuple(effect for effect in noise.effects if not coloured(effect))
    return replace(description, noise=replace(noise, effects=kept or noise.effects[:1]))
