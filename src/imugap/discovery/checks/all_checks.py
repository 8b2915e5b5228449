"""All misfits of a fit, and the effects whose names they make ambiguous."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from imugap.discovery.checks.hysteresis import HYSTERESIS, may_be_hysteresis, terms_against_hysteresis
from imugap.discovery.checks.mean import mean_misfit
from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, log_p_against
from imugap.discovery.checks.motion import all_against_motion
from imugap.discovery.checks.outliers import outliers_misfit
from imugap.discovery.checks.spectrum import (
    BURST_REASONS,
    NEIGHBOURHOOD,
    filter_misfit,
    noise_misfit,
    power_law_advantage,
    power_share,
    replaced_by_power_law,
    ripple_log_p,
)
from imugap.discovery.checks.transient import transient_misfits
from imugap.discovery.checks.transition import transition_misfits
from imugap.discovery.checks.variance import variance_misfit
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.whittle import log_likelihood
from imugap.discovery.search.search import Candidate, Search, coloured, stepping
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.effects.effect import Effect, Role

MAX_POWER_SHARE = 0.5
"""Maximum share of misfitting noise in the power at the frequency of a line or filter that keeps its name."""
MIN_JUMPS, MIN_EXTRA_VALUES = 3, 2
"""Minimum number of steps for a jump process with slow noise, and for further values of telegraph noise."""
MIN_TERMS = 2
"""Minimum number of terms over time for the comparison with one power law."""
MAX_AMBIGUOUS_EXCESS = 5.0
"""Maximum excess of outliers [standard deviations] that a change of variance can imitate."""
BAND_MARGIN = 1.1
"""Factor by which the band of a chirp or wandering line is widened."""
LINE_MARGIN = 2.0
"""Ratio to the frequency of a misfitting line beyond which effects are independent of it."""


TESTS = {
    Role.MEAN: mean_misfit,
    Role.NOISE: noise_misfit,
    Role.FILTER: filter_misfit,
    Role.OUTLIERS: outliers_misfit,
    Role.VARIANCE: variance_misfit,
}
"""Test of an added effect by its role."""
Found = Mapping[Candidate, Misfit]
"""Misfits found so far, of the added effects that have one."""


def misfits(search: Search, fit: AxisFit) -> dict[Candidate, Misfit]:
    """Return the misfits of the added effects of a fit.

    One misfit applies to all added effects of the same role; next to misfitting lines, a term that is significant at
    other frequencies keeps its name.
    """
    added = search.added(fit)
    from_motion = _all_from_motion(search, fit, added)
    if from_motion:
        return from_motion
    found = {one: misfit for one in added if (misfit := _misfit(one)) is not None} | _too_many(added)
    found |= _means_from_hysteresis(search, fit, added) | steps_as_jump_process(added) | transient_misfits(added)
    found |= transition_misfits(added) | terms_as_power_law(added) | tones_beside_ripple(added)
    found |= ambiguous_variance(added, found)
    found |= _dependent_on_outliers(found) | _ambiguous_slow_noise(added, found)
    found |= ambiguous_terms(added, found) | ambiguous_spectrum(added, found)
    clear = _certain_off_lines(added, found)
    for role in {one.role for one in found}:
        worst = _worst(found, [one for one in found if one.role is role])
        found |= {one: worst for one in added if one.role is role and one not in found and one not in clear}
    return found


def _worst(found: Found, some: Iterable[Candidate]) -> Misfit:
    """Return the misfit of the lowest probability among those of some effects."""
    return min((found[one] for one in some), key=lambda misfit: misfit.log_p)


def _too_many(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return the effects of which there are more of a kind than may have its name."""
    count = Counter(type(one.effect) for one in added)
    return {
        one: Misfit(f"{count[type(one.effect)]} of them", -np.inf)
        for one in added
        if one.effect.most is not None and count[type(one.effect)] > one.effect.most
    }


def explained_by_bands(some: Sequence[Candidate], bands: Sequence[Band]) -> dict[Candidate, Misfit]:
    """Return the noise and the filter among some effects that are not significant outside bands of unnamed lines."""
    return {
        one: Misfit("a line that sweeps or wanders explains it", band.log_p)
        for band in bands
        for one in some
        if one.role in (Role.NOISE, Role.FILTER)
        and not _certain_outside_band(one, band.low / BAND_MARGIN, band.high * BAND_MARGIN)
    }


def _means_from_hysteresis(search: Search, fit: AxisFit, added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return the added terms if hysteresis over the temperature explains them better."""
    misfit = terms_against_hysteresis(search, fit)
    terms = [one for one in added if one.role is Role.MEAN and may_be_hysteresis(one.effect)]
    return dict.fromkeys(terms, misfit) if misfit.log_p < MAX_LOG_P else {}


def _all_from_motion(search: Search, fit: AxisFit, added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return all added effects if an unnamed function of the motion explains more than they do."""
    if not added:
        return {}
    misfit = all_against_motion(search, fit)
    return dict.fromkeys(added, misfit) if misfit.log_p < MAX_LOG_P else {}


def steps_as_jump_process(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return steps and slow noise where the number of steps indicates an unnamed jump process.

    With telegraph noise two steps indicate a process of more than two values.
    """
    steps = [one for one in added if one.effect.event]
    slow = [one for one in added if one.effect.slow]
    switches = [one for one in added if one.effect.two_valued]
    jumps = (slow and len(steps) >= MIN_JUMPS) or (switches and len(steps) >= MIN_EXTRA_VALUES)
    return dict.fromkeys([*steps, *slow, *switches], Misfit("it jumps", -np.inf)) if jumps else {}


def terms_as_power_law(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return two or more terms over time, and slow noise, if one power law is likelier than all of them."""
    terms = [one for one in added if one.effect.of_time]
    both = [*terms, *(one for one in added if one.effect.slow)]
    more = power_law_advantage(both) if len(terms) >= MIN_TERMS else 0.0
    return dict.fromkeys(both, Misfit("one power law explains all of it better", -np.inf)) if more > 0 else {}


def tones_beside_ripple(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Return the tones that are less significant than a ripple of the spectrum that is left: they may be its crests."""
    tones = [one for one in added if one.effect.tonal]
    left = ripple_log_p(tones[0].fit) if tones else 0.0
    against = (log_p_against(one.trial.log_p, left, one.search.log_alpha) for one in tones)
    return {one: Misfit(NEIGHBOURHOOD, log_p) for one, log_p in zip(tones, against, strict=True) if log_p < MAX_LOG_P}


def ambiguous_variance(added: Sequence[Candidate], found: Found) -> dict[Candidate, Misfit]:
    """Return changes of variance that bursts or misfitting outliers can imitate.

    Also outliers of small excess where a change of variance has a misfit.
    """
    changes = [one for one in added if one.role is Role.VARIANCE]
    outliers = [one for one in added if one.role is Role.OUTLIERS]
    near = [one for one in outliers if one.search.tails[one.effect].excess <= MAX_AMBIGUOUS_EXCESS]
    bursts = [one for one, misfit in found.items() if one in outliers or misfit.reason in BURST_REASONS]
    misfitting = [one for one in changes if one in found]
    ambiguous = dict.fromkeys(changes, _worst(found, bursts)) if bursts else {}
    return ambiguous | (dict.fromkeys(near, _worst(found, misfitting)) if misfitting else {})


def _certain_off_lines(added: Sequence[Candidate], found: Found) -> set[Candidate]:
    """Return the terms that are significant far from misfitting lines, if no other term has a misfit."""
    ambiguous = [one.effect for one in found if one.role is Role.MEAN]
    if not ambiguous or not all(effect.line for effect in ambiguous):
        return set()
    lines = [line.frequency for line in ambiguous]
    others = [one for one in added if one.role is Role.MEAN and one not in found]
    return {one for one in others if _certain_outside_band(one, min(lines) / LINE_MARGIN, max(lines) * LINE_MARGIN)}


def _certain_outside_band(candidate: Candidate, low: float, high: float) -> bool:
    """Return whether an effect is significant outside of a band of frequencies [Hz].

    The noise level is profiled outside of the band, with and without the effect, as the band may have raised it.
    """
    fit, without = candidate.fit, candidate.without
    frequency = np.arange(1, fit.sequence.bins.last + 1) / (
        2 * len(fit.sequence.values) * fit.sequence.conditions.interval
    )
    outside = (frequency < low) | (frequency > high)
    if not outside.any():
        return False
    full, less = (
        outside.sum() * np.log(np.mean(one.coefficients[: len(frequency)][outside] ** 2))
        + np.sum(np.log(one.variance[: len(frequency)][outside]))
        for one in (fit, without)
    )
    return replace(candidate.trial, gain=0.5 * float(less - full)).log_p < candidate.search.log_alpha


def _dependent_on_outliers(found: Found) -> dict[Candidate, Misfit]:
    """Return the noise that is not significant in the samples with outliers, if the outliers have a misfit."""
    outliers = next((one for one in found if one.role is Role.OUTLIERS), None)
    if outliers is None:
        return {}
    search, fit = outliers.search, outliers.fit
    raw = search.with_outlier_samples(fit)
    random = [one for one in search.added(raw) if one.role is not Role.MEAN and not one.significant]
    behind = len(fit.description.entries) - len(raw.description.entries)
    return {Candidate(search, fit, one.index + behind * (one.role > Role.OUTLIERS)): found[outliers] for one in random}


def _ambiguous_slow_noise(added: Sequence[Candidate], found: Found) -> dict[Candidate, Misfit]:
    """Return the slow noise that may describe the residual of a misfitting mean.

    A line leaves no residual below its frequency: noise that is significant there keeps its name.
    """
    terms = [one for one in found if one.role is Role.MEAN]
    if not terms:
        return {}
    lowest = min(getattr(one.effect, "frequency", 0.0) for one in terms)
    slow = [one for one in added if one.role is Role.NOISE and one.effect.slow]
    ambiguous = [one for one in slow if _gain_below(one, 0.5 * lowest) < -one.search.log_alpha]
    return dict.fromkeys(ambiguous, Misfit("the mean beside it has no known shape", _worst(found, terms).log_p))


def ambiguous_terms(added: Sequence[Candidate], found: Found) -> dict[Candidate, Misfit]:
    """Return the terms that the unnamed cause of misfitting slow noise can imitate.

    Any cause can imitate steps; hysteresis can imitate all terms over temperature or time. Other terms keep their names
    if they are significant next to a power law as well.
    """
    slow = [one for one in found if coloured(one.effect)]
    if not slow:
        return {}
    worst = _worst(found, slow)
    made = may_be_hysteresis if worst.reason == HYSTERESIS else stepping
    terms = [one for one in added if one not in found and may_be_hysteresis(one.effect)]
    law = replaced_by_power_law(slow[0].search, slow[0].fit, coloured)
    return {
        one: worst for one in terms if made(one.effect) or (law is not None and not _certain_beside_power_law(one, law))
    }


def _certain_beside_power_law(candidate: Candidate, other: AxisFit) -> bool:
    """Return whether a term of a fit is significant in another fit with the same terms as well."""
    gain = other.log_likelihood - replace(candidate, fit=other).without.log_likelihood
    return replace(candidate.trial, gain=gain).log_p < candidate.search.log_alpha


def ambiguous_spectrum(added: Sequence[Candidate], found: Found) -> dict[Candidate, Misfit]:
    """Return the lines and the filter where misfitting noise is most of the power; in total, for ripples."""
    ambiguous = [one for one in found if one.role is Role.NOISE]
    if not ambiguous:
        return {}
    share = sum(power_share(one.fit, one.effect) for one in ambiguous)
    bins, worst = ambiguous[0].fit.sequence.bins, _worst(found, ambiguous)

    def hidden(effect: Effect) -> bool:
        if effect.centre is None:
            return effect.role is Role.FILTER and np.average(share, weights=bins.number) > MAX_POWER_SHARE
        return np.interp(effect.centre, bins.frequency, share) > MAX_POWER_SHARE

    return {one: worst for one in added if one not in found and hidden(one.effect)}


def _gain_below(candidate: Candidate, frequency: float) -> float:
    """Return the log-likelihood gain of a noise process below a frequency [Hz], all other parameters held."""
    fit, bins = candidate.fit, candidate.fit.sequence.bins
    below = bins.frequency < frequency
    power = (bins.sums(fit.coefficients**2) * fit.description.noise.variance(bins))[below]
    both = fit.description, fit.description.without([candidate.index])
    parts = [description.noise.variance(bins)[below] for description in both]
    full, without = (log_likelihood(part, power, bins.number[below]) for part in parts)
    return full - without


def tested(candidate: Candidate) -> Misfit:
    """Test an added effect against departures from its form; return the worst one, significant or not."""
    return TESTS[candidate.role](candidate)


def _misfit(candidate: Candidate) -> Misfit | None:
    misfit = tested(candidate)
    return misfit if misfit.log_p < MAX_LOG_P else None
