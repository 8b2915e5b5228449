"""All doubts of a fit, and what they mean for the names beside."""

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

MOST = 0.5
"""Share of the power at the frequency of a line or a filter above which noise in doubt leaves neither a name."""
JUMPS, MIN_EXTRA_VALUES = 3, 2
"""Number of steps from which on they are jumps beside slow noise, and further values beside telegraph noise."""
SEVERAL = 2
"""Means of time from which on they may be a process that wanders."""
WIDE = 5.0
"""Excess of outliers, in standard deviations, from which on no change of the variance makes them."""
EDGE = 1.1
"""Factor by which the band of a line that sweeps or wanders may reach farther."""
FAR = 2.0
"""Factor of the frequency of a line in doubt beyond which others have nothing to do with it."""


def misfits(search: Search, fit: AxisFit) -> dict[Key, Misfit]:
    """Return the added effects of a fit whose names are in doubt; with one in doubt, all of its part of the model.

    Beside lines in doubt a term keeps its name that is certain from other frequencies.
    """
    keys = search.added(fit.description)
    moved = _moved(search, fit, keys)
    if moved:
        return moved
    found = {key: misfit for key in keys if (misfit := _doubt(search, fit, key)) is not None}
    for key in keys:
        kind = type(at(fit.description, key))
        same = [one for one in keys if isinstance(at(fit.description, one), kind)]
        if kind.most is not None and len(same) > kind.most:
            found[key] = Misfit(f"{len(same)} of them", -np.inf)
    found |= _remembered(search, fit, keys) | steps_as_jump_process(fit, keys) | transient_misfits(search, fit, keys)
    found |= transition_misfits(search, fit, keys) | means_as_power_law(search, fit, keys)
    found |= ambiguous_variance(search, fit, keys, found)
    found |= _after_clusters(search, fit, found) | _beside_a_mean(search, fit, keys, found)
    found |= ambiguous_means(search, fit, keys, found) | ambiguous_spectrum(fit, keys, found)
    clear = _clear_of_lines(search, fit, keys, found)
    for part in {key.part for key in found}:
        worst = min((found[key] for key in found if key.part == part), key=lambda misfit: misfit.log_p)
        found |= {key: worst for key in keys if key.part == part and key not in found and key not in clear}
    return found


def explained_by_bands(search: Search, fit: AxisFit, keys: Sequence[Key], bands: Sequence[Band]) -> dict[Key, Misfit]:
    """Return the random effects and the filter among ``keys`` that are uncertain but for the band of such a line."""
    return {
        key: Misfit("a line that sweeps or wanders explains it", band.log_p)
        for band in bands
        for key in keys
        if key.part in ("noise", "filter") and not _certain_outside(search, fit, key, band.low / EDGE, band.high * EDGE)
    }


def _remembered(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return the means that a memory of the temperature explains better."""
    misfit = means_against_hysteresis(search, fit)
    means = [key for key in keys if key.part == "term" and may_be_hysteresis(at(fit.description, key))]
    return {key: misfit for key in means if misfit.log_p < LEVEL}


def _moved(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return everything that was added, where a function of the motion without a name explains more by itself."""
    if not keys:
        return {}
    misfit = all_against_motion(search, fit)
    return dict.fromkeys(keys, misfit) if misfit.log_p < LEVEL else {}


def steps_as_jump_process(fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return steps and slow noise, where the steps are too many to be anything but jumps of a process without a name.

    Beside telegraph noise two are, which make it one of more values than two.
    """
    effects = {key: at(fit.description, key) for key in keys}
    steps = [key for key in keys if effects[key].event]
    slow = [key for key in keys if effects[key].slow]
    switches = [key for key in keys if effects[key].two_valued]
    jumps = (slow and len(steps) >= JUMPS) or (switches and len(steps) >= MIN_EXTRA_VALUES)
    return dict.fromkeys([*steps, *slow, *switches], Misfit("it jumps", -np.inf)) if jumps else {}


def means_as_power_law(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return means of time, two or more, and slow noise, where one power law is worth more than all of them."""
    means = [key for key in keys if at(fit.description, key).of_time]
    slow = [key for key in keys if at(fit.description, key).slow]
    both = [*means, *slow]
    more = power_law_advantage(search, fit, both) if len(means) >= SEVERAL else 0.0
    return dict.fromkeys(both, Misfit("one power law explains all of it better", -np.inf)) if more > 0 else {}


def ambiguous_variance(
    search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]
) -> dict[Key, Misfit]:
    """Return what of the variance may be made by what has no name: changes beside bursts, or outliers in doubt.

    And outliers that are not far out where a change is in doubt.
    """
    changes = [key for key in keys if key.part == "change"]
    outliers = [key for key in keys if key.part == "outliers"]
    near = [key for key in outliers if search.tails[fit.description.outliers].excess <= WIDE]
    bursts = [misfit for key, misfit in found.items() if key in outliers or misfit.reason in BURST_REASONS]
    doubtful = dict.fromkeys(changes, min(bursts, key=lambda misfit: misfit.log_p)) if bursts else {}
    odd = [found[key] for key in changes if key in found]
    return doubtful | (dict.fromkeys(near, min(odd, key=lambda misfit: misfit.log_p)) if odd else {})


def _clear_of_lines(search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]) -> set[Key]:
    """Return the terms that, lines alone being in doubt, are certain from frequencies far from these."""
    doubtful = [at(fit.description, key) for key in found if key.part == "term"]
    if not doubtful or not all(effect.line for effect in doubtful):
        return set()
    lines = [line.frequency for line in doubtful]
    others = [key for key in keys if key.part == "term" and key not in found]
    return {key for key in others if _certain_outside(search, fit, key, min(lines) / FAR, max(lines) * FAR)}


def _certain_outside(search: Search, fit: AxisFit, key: Key, low: float, high: float) -> bool:
    """Return whether chance does not explain what an effect gains outside of a band of frequencies [Hz].

    What is within the band may have lifted the level of all: with and without the effect it is that of the others.
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


def _after_clusters(search: Search, fit: AxisFit, found: Mapping[Key, Misfit]) -> dict[Key, Misfit]:
    """Return the random effects that only the samples without outliers show, where those are in doubt."""
    misfit = next((found[key] for key in found if key.part == "outliers"), None)
    if misfit is None:
        return {}
    raw = search.fitted(search.raw[fit.description.outliers], replace(fit.description, outliers=None))
    random = [key for key in search.added(raw.description) if key.part != "term"]
    return {key: misfit for key in random if search.likelihood_ratio(raw, key)[0].log_p > search.log_alpha}


def _beside_a_mean(search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]) -> dict[Key, Misfit]:
    """Return the slow random effects that may stand for what a mean of no known shape leaves.

    A line leaves nothing below itself: an effect that is certain from the frequencies there keeps its name.
    """
    bent = {key: found[key].log_p for key in found if key.part == "term"}
    if not bent:
        return {}
    lowest = min(getattr(at(fit.description, key), "frequency", 0.0) for key in bent)
    slow = [key for key in keys if key.part == "noise" and at(fit.description, key).slow]
    doubtful = [key for key in slow if _evidence_below(fit, key, 0.5 * lowest) < -search.log_alpha]
    return {key: Misfit("the mean beside it has no known shape", min(bent.values())) for key in doubtful}


def ambiguous_means(
    search: Search, fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]
) -> dict[Key, Misfit]:
    """Return what stands beside slow noise in doubt and may be made by the same thing without a name.

    Any may have made steps, a memory of the temperature whatever else goes with the temperature or with time. Other
    means keep their names if they are certain beside a power law too.
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
        if made(at(fit.description, key)) or (law is not None and not _certain_in(search, law, fit, key))
    }


def _certain_in(search: Search, other: AxisFit, fit: AxisFit, key: Key) -> bool:
    """Return whether chance does not explain a term of a fit in another fit with the same terms either."""
    without = search.fitted(fit.sequence, removed(other.description, key))
    gain = other.log_likelihood - without.log_likelihood
    return replace(search.likelihood_ratio(fit, key)[0], gain=gain).log_p < search.log_alpha


def ambiguous_spectrum(fit: AxisFit, keys: Sequence[Key], found: Mapping[Key, Misfit]) -> dict[Key, Misfit]:
    """Return the lines and the filter where noise in doubt is most of the power: the spectrum there has no name."""
    doubtful = [key for key in found if key.part == "noise"]
    if not doubtful:
        return {}
    share = sum(power_share(fit, at(fit.description, key)) for key in doubtful)
    worst = min((found[key] for key in doubtful), key=lambda misfit: misfit.log_p)
    return {
        key: worst
        for key in keys
        if key not in found
        and (centre := at(fit.description, key).centre) is not None
        and np.interp(centre, fit.sequence.bins.frequency, share) > MOST
    }


def _evidence_below(fit: AxisFit, key: Key, frequency: float) -> float:
    """Return the gain of log-likelihood that a random effect makes below a frequency [Hz], all else as it is."""
    bins = fit.sequence.bins
    below = bins.frequency < frequency
    power = (bins.sums(fit.coefficients**2) * fit.description.noise.variance(bins))[below]
    parts = [noise.variance(bins)[below] for noise in (fit.description.noise, removed(fit.description, key).noise)]
    full, without = (log_likelihood(part, power, bins.number[below]) for part in parts)
    return full - without


def _doubt(search: Search, fit: AxisFit, key: Key) -> Misfit | None:
    if key.part == "outliers":
        misfit = outliers_misfit(search, fit)
    else:
        tests = {"term": mean_misfit, "noise": noise_misfit, "change": variance_misfit, "filter": filter_misfit}
        misfit = tests[key.part](search, fit, key)
    return misfit if misfit is not None and misfit.log_p < LEVEL else None
