"""Likelihood-ratio tests of slow noise and of terms against unnamed functions of the temperature.

Hysteresis over the temperature, or a curve with a bend, can imitate slow noise and terms over time.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.description import Description
from imugap.discovery.search.search import Candidate, Search, Trial, coloured, log_p_of_gain
from imugap.discovery.unnamed.hysteresis import Hysteresis
from imugap.effects.effect import Effect, Role

HYSTERESIS = "a memory of the temperature explains it better"
CURVE = "a curve over the temperature or its rate explains it better"
QUANTILES = np.linspace(0.05, 0.95, 8)
"""Quantiles of the temperature at which a curve may bend, and of its rate at which it may step."""
NO_MISFIT = Misfit(HYSTERESIS, 0.0)


def may_be_hysteresis(effect: Effect) -> bool:
    """Return whether hysteresis over the temperature can imitate a mean: one over time or over temperature."""
    return effect.of_time or effect.of_temperature


def noise_against_temperature(candidate: Candidate) -> Misfit:
    """Test slow noise, one process or all of it, against a curve and a hysteresis over the temperature."""
    search, fit = candidate.search, candidate.fit
    temperature = fit.sequence.conditions.temperature
    if temperature is None or np.ptp(temperature) == 0:
        return NO_MISFIT
    bases = candidate.without, search.fitted(fit.sequence, _without_slow_noise(fit.description))
    curves = _temperature_curve(temperature), _rate_steps(np.gradient(temperature, fit.sequence.conditions.interval))
    bent = max(likelihood_with(base, curve) for base in bases for curve in curves)
    return min(
        Misfit(CURVE, min(MAX_LOG_P + UNNAMED_MARGIN + fit.log_likelihood - bent, 0.0)),
        _against_hysteresis(candidate, bases),
        key=lambda misfit: misfit.log_p,
    )


def _against_hysteresis(candidate: Candidate, bases: tuple[AxisFit, AxisFit]) -> Misfit:
    """Test a process against hysteresis in ``bases``: the fits without it, and without all slow noise."""
    without, search = bases[0], candidate.search
    trials = list(_hysteresis_trials(search, bases))
    best = max(trials, key=lambda trial: trial.fit.log_likelihood)
    loop = replace(best, gain=best.fit.log_likelihood - without.log_likelihood)
    return Misfit(HYSTERESIS, log_p_against(candidate.trial.log_p, loop.log_p, search.log_alpha))


def terms_against_hysteresis(search: Search, fit: AxisFit) -> Misfit:
    """Test the added terms of a fit against hysteresis, in addition to them and in their place.

    Hysteresis contains the linear temperature term, so that only the addition is tested where that alone was added.
    """
    added = search.added(fit, lambda effect: effect.role is Role.MEAN and may_be_hysteresis(effect))
    if not added or fit.sequence.conditions.temperature is None:
        return NO_MISFIT
    both = list(_hysteresis_trials(search, (fit,)))
    if not both:
        return NO_MISFIT
    more = both[0].log_p
    if all(one.effect.of_temperature and one.entry.free == ("coefficient",) for one in added):
        return Misfit(HYSTERESIS, more)
    without = search.fitted(fit.sequence, fit.description.without(one.index for one in added))
    (instead,) = _hysteresis_trials(search, (without,))
    named = log_p_of_gain(fit.log_likelihood - without.log_likelihood, sum(len(one.entry.free) for one in added))
    return Misfit(HYSTERESIS, min(more, log_p_against(named, instead.log_p, search.log_alpha)))


def _hysteresis_trials(search: Search, fits: Iterable[AxisFit]) -> Iterable[Trial]:
    """Yield each fit with hysteresis added, where the temperature is known and varies."""
    return (search.trial_of(start, fit) for fit in fits for start in Hysteresis.starts(fit))


def _temperature_curve(temperature: np.ndarray) -> np.ndarray:
    """Return the temperature and its excess over each quantile, shape (n, 1 + quantiles)."""
    return np.column_stack(
        [temperature, *(np.maximum(temperature - level, 0) for level in np.quantile(temperature, QUANTILES))]
    )


def _rate_steps(rate: np.ndarray) -> np.ndarray:
    """Return the temperature rate and indicators of rates above zero and each quantile, shape (n, 1 + levels)."""
    return np.column_stack([rate, *(rate > level for level in np.unique([0.0, *np.quantile(rate, QUANTILES)]))])


def _without_slow_noise(description: Description) -> Description:
    first = description.of(Role.NOISE)[0]
    kept = description.keeping(lambda entry: not coloured(entry.effect))
    return kept if kept.of(Role.NOISE) else kept.exchanging(Role.NOISE, [first])
