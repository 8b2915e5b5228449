"""All misfits of a fit, and the effects whose names they make ambiguous."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from imugap.discovery.checks.hysteresis import HYSTERESIS, may_be_hysteresis, means_against_hysteresis
from imugap.discovery.checks.mean import mean_misfit
from imugap.discovery.checks.misfit import LEVEL, Misfit
from imugap.discovery.checks.motion import all_against_motion
from imugap.discovery.checks.outliers import outliers_misfit
from imugap.discovery.checks.spectrum import (
    BURST_REASONS,
    filter_misfit,
    noise_misfit,
    power_law_advantage,
    power_share,
    replaced_by_power_law,
)
from imugap.discovery.checks.transient import transient_misfits
from imugap.discovery.checks.transition import transition_misfits
from imugap.discovery.checks.variance import variance_misfit
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.whittle import log_likelihood
from imugap.discovery.search.search import Key, Search, at, coloured, removed, stepping
from imugap.discovery.unnamed.wandering_lines import Band

MAX_POWER_SHARE = 0.5
"""Maximum share of misfitting noise in the power at the frequency of a line or filter that keeps its name."""
MIN_JUMPS, MIN_EXTRA_VALUES = 3, 2
"""Minimum number of steps for a jump process with slow noise, and for further values of telegraph noise."""
MIN_MEANS = 2
"""Minimum number of means over time for the comparison with one power law."""
MAX_AMBIGUOUS_EXCESS = 5.0
"""Maximum excess of outliers [standard deviations] that a change of variance can imitate."""
BAND_MARGIN = 1.1
"""Factor by which the band of a chirp or wandering line is widened."""
LINE_MARGIN = 2.0
"""Ratio to the frequency of a misfitting line beyond which effects are independent of it."""


def misfits(search: Search, fit: AxisFit) -> dict[Key, Misfit]:
    """Return the misfits of the added effects of a fit, by their keys.

    One misfit applies to all added effects of the same part of the description; next to misfitting lines, a term that
    is significant at other frequencies keeps its name.
    """
    keys = search.added(fit.description)
    from_motion = _all_from_motion(search, fit, keys)
    if from_motion:
        return from_motion
    found = {key: misfit for key in keys if (misfit := _misfit(search, fit, key)) is not None}
    for key in keys:
        kind = type(at(fit.description, key))
        same = [one for one in keys if isinstance(at(fit.description, one), kind)]
        if kind.most is not None and len(same) > kind.most:
            found[key] = Misfit(f"{len(same)} of them", -np.inf)
    found |= (
        _means_from_hysteresis(search, fit, keys)
        | steps_as_jump_process(fit, keys)
        | transient_misfits(search, fit, keys)
    )
    found |= transition_misfits(search, fit, keys) | means_as_power_law(search, fit, keys)
    found |= ambiguous_variance(search, fit, keys, found)
    found |= _dependent_on_outliers(search, fit, found) | _ambiguous_slow_noise(search, fit, keys, found)
    found |= ambiguous_means(search, fit, keys, found) | ambiguous_spectrum(fit, keys, found)
    clear = _certain_off_lines(search, fit, keys, found)
    for part in {key.part for key in found}:
        worst = min((found[key] for key in found if key.part == part), key=lambda misfit: misfit.log_p)
        found |= {key: worst for key in keys if key.part == part and key not in found and key not in clear}
    return found


def explained_by_bands(search: Search, fit: AxisFit, keys: Sequence[Key], bands: Sequence[Band]) -> dict[Key, Misfit]:
    """Return the noise and the filter among ``keys`` that are not significant outside the bands of unnamed lines."""
    return {
        key: Misfit("a line that sweeps or wanders explains it", band.log_p)
        for band in bands
        for key in keys
        if key.part in ("noise", "filter")
        and not _certain_outside_band(search, fit, key, band.low / BAND_MARGIN, band.high * BAND_MARGIN)
    }


def _means_from_hysteresis(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return the added means if hysteresis over the temperature explains them better."""
    misfit = means_against_hysteresis(search, fit)
    means = [key for key in keys if key.part == "term" and may_be_hysteresis(at(fit.description, key))]
    return {key: misfit for key in means if misfit.log_p < LEVEL}


def _all_from_motion(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return all added effects if an unnamed function of the motion explains more than they do."""
    if not keys:
        return {}
    misfit = all_against_motion(search, fit)
    return dict.fromkeys(keys, misfit) if misfit.log_p < LEVEL else {}


def steps_as_jump_process(fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return steps and slow noise where the number of steps indicates an unnamed jump process.

    With telegraph noise two steps indicate a process of more than two values.
    """
    effects = {key: at(fit.description, key) for key in keys}
    steps = [key for key in keys if effects[key].event]
    slow = [key for key in keys if effects[key].slow]
    switches = [key for key in keys if effects[key].two_valued]
    jumps = (slow and len(steps) >= MIN_JUMPS) or (switches and len(steps) >= MIN_EXTRA_VALUES)
    return dict.fromkeys([*steps, *slow, *switches], Misfit("it jumps", -np.inf)) if jumps else {}


def means_as_power_law(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return two or more means over time, and slow noise, if one power law is likelier than all of them."""
    means = [key for key in keys if at(fit.description, key).of_time]
    slow = [key for key in keys if at(fit.description, key).slow]
    both = [*means, *slow]
    more = power_law_advantage(search, fit, both) if len(means) >= MIN_MEANS else 0.0
    return dict.fromkeys(both, Misfit("one power law explains all of it better", -np.inf)) if more > 0 else {}


def ambiguous_variance(
    search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]
) -> dict[Key, Misfit]:
    """Return changes of variance that bursts or misfitting outliers can imitate.

    Also outliers of small excess where a change of variance has a misfit.
    """
    changes = [key for key in keys if key.part == "change"]
    outliers = [key for key in keys if key.part == "outliers"]
    near = [key for key in outliers if search.tails[fit.description.outliers].excess <= MAX_AMBIGUOUS_EXCESS]
    bursts = [misfit for key, misfit in found.items() if key in outliers or misfit.reason in BURST_REASONS]
    ambiguous = dict.fromkeys(changes, min(bursts, key=lambda misfit: misfit.log_p)) if bursts else {}
    odd = [found[key] for key in changes if key in found]
    return ambiguous | (dict.fromkeys(near, min(odd, key=lambda misfit: misfit.log_p)) if odd else {})


def _certain_off_lines(search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]) -> set[Key]:
    """Return the terms that are significant far from misfitting lines, if no other term has a misfit."""
    ambiguous = [at(fit.description, key) for key in found if key.part == "term"]
    if not ambiguous or not all(effect.line for effect in ambiguous):
        return set()
    lines = [line.frequency for line in ambiguous]
    others = [key for key in keys if key.part == "term" and key not in found]
    return {
        key
        for key in others
        if _certain_outside_band(search, fit, key, min(lines) / LINE_MARGIN, max(lines) * LINE_MARGIN)
    }


def _certain_outside_band(search: Search, fit: AxisFit, key: Key, low: float, high: float) -> bool:
    """Return whether an effect is significant outside of a band of frequencies [Hz].

    The noise level is profiled outside of the band, with and without the effect, as the band may have raised it.
    """
    own, without = search.likelihood_ratio(fit, key)
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
    return replace(own, gain=0.5 * float(less - full)).log_p < search.log_alpha


def _dependent_on_outliers(search: Search, fit: AxisFit, found: Mapping[Key, Misfit]) -> dict[Key, Misfit]:
    """Return the noise that is not significant in the samples with outliers, if the outliers have a misfit."""
    misfit = next((found[key] for key in found if key.part == "outliers"), None)
    if misfit is None:
        return {}
    raw = search.fitted(search.raw[fit.description.outliers], replace(fit.description, outliers=None))
    random = [key for key in search.added(raw.description) if key.part != "term"]
    return {key: misfit for key in random if search.likelihood_ratio(raw, key)[0].log_p > search.log_alpha}


def _ambiguous_slow_noise(
    search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]
) -> dict[Key, Misfit]:
    """Return the slow noise that may describe the residual of a misfitting mean.

    A line leaves no residual below its frequency: noise that is significant there keeps its name.
    """
    mean_log_p = {key: found[key].log_p for key in found if key.part == "term"}
    if not mean_log_p:
        return {}
    lowest = min(getattr(at(fit.description, key), "frequency", 0.0) for key in mean_log_p)
    slow = [key for key in keys if key.part == "noise" and at(fit.description, key).slow]
    ambiguous = [key for key in slow if _gain_below(fit, key, 0.5 * lowest) < -search.log_alpha]
    return {key: Misfit("the mean beside it has no known shape", min(mean_log_p.values())) for key in ambiguous}


def ambiguous_means(
    search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]
) -> dict[Key, Misfit]:
    """Return the means that the unnamed cause of misfitting slow noise can imitate.

    Any cause can imitate steps; hysteresis can imitate all means over temperature or time. Other means keep their names
    if they are significant next to a power law as well.
    """
    slow = [key for key in found if coloured(at(fit.description, key))]
    if not slow:
        return {}
    worst = min((found[key] for key in slow), key=lambda misfit: misfit.log_p)
    made = may_be_hysteresis if worst.reason == HYSTERESIS else stepping
    means = [key for key in keys if key not in found and may_be_hysteresis(at(fit.description, key))]
    law = replaced_by_power_law(search, fit, coloured)
    return {
        key: worst
        for key in means
        if made(at(fit.description, key)) or (law is not None and not _certain_beside_power_law(search, law, fit, key))
    }


def _certain_beside_power_law(search: Search, other: AxisFit, fit: AxisFit, key: Key) -> bool:
    """Return whether a term of a fit is significant in another fit with the same terms as well."""
    without = search.fitted(fit.sequence, removed(other.description, key))
    gain = other.log_likelihood - without.log_likelihood
    return replace(search.likelihood_ratio(fit, key)[0], gain=gain).log_p < search.log_alpha


def ambiguous_spectrum(fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]) -> dict[Key, Misfit]:
    """Return the lines and the filter at frequencies where misfitting noise is most of the power."""
    ambiguous = [key for key in found if key.part == "noise"]
    if not ambiguous:
        return {}
    share = sum(power_share(fit, at(fit.description, key)) for key in ambiguous)
    worst = min((found[key] for key in ambiguous), key=lambda misfit: misfit.log_p)
    return {
        key: worst
        for key in keys
        if key not in found
        and (centre := at(fit.description, key).centre) is not None
        and np.interp(centre, fit.sequence.bins.frequency, share) > MAX_POWER_SHARE
    }


def _gain_below(fit: AxisFit, key: Key, frequency: float) -> float:
    """Return the log-likelihood gain of a noise process below a frequency [Hz], all other parameters held."""
    bins = fit.sequence.bins
    below = bins.frequency < frequency
    power = (bins.sums(fit.coefficients**2) * fit.description.noise.variance(bins))[below]
    parts = [noise.variance(bins)[below] for noise in (fit.description.noise, removed(fit.description, key).noise)]
    full, without = (log_likelihood(part, power, bins.number[below]) for part in parts)
    return full - without


def _misfit(search: Search, fit: AxisFit, key: Key) -> Misfit | None:
    if key.part == "outliers":
        misfit = outliers_misfit(search, fit)
    else:
        tests = {"term": mean_misfit, "noise": noise_misfit, "change": variance_misfit, "filter": filter_misfit}
        misfit = tests[key.part](search, fit, key)
    return misfit if misfit is not None and misfit.log_p < LEVEL else None
