"""What happens on one axis: from the start model through the search to names, doubts and intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from types import MappingProxyType

import numpy as np
from scipy.fft import next_fast_len
from threadpoolctl import threadpool_limits

from imugap.discovery.checks import (
    MAX_LOG_P,
    MIN_EXTRA_VALUES,
    NOISE_REASONS,
    SLOPE_REASONS,
    Misfit,
    add_power_law,
    explained_by_bands,
    misfits,
    shape_log_p,
    tested,
)
from imugap.discovery.checks.motion import all_against_motion, motion_gain
from imugap.discovery.checks.noise_law import noise_law
from imugap.discovery.checks.withheld import Withheld, withheld
from imugap.discovery.finding import MIN_LOG_P, Discrepancy, Finding, Interval, Rival, Unnamed
from imugap.discovery.fit.axis_fit import AxisFit, fit, log_score, offset
from imugap.discovery.fit.start_model import described
from imugap.discovery.fit.telegraph_likelihood import compare
from imugap.discovery.posterior import posterior
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.intervals import axis_unit, intervals, intervals_beside_slow_noise, repeats
from imugap.discovery.search.search import Candidate, Search, coloured, log_p_of_gain, stepping, without
from imugap.discovery.search.simpler_form import simplified
from imugap.discovery.search.telegraph import hidden_telegraph, steady, told_apart, two_valued
from imugap.discovery.search.telegraph_in_noise import Switching
from imugap.discovery.unnamed import wandering_lines
from imugap.discovery.unnamed.chirps import find_chirps
from imugap.discovery.unnamed.tone_bursts import find_tone_bursts
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.model import with_offset

MAX_LOG_PLACES = 12.0
"""Logarithm of the maximum number of places at which an effect is tried."""
MAX_BANDS = 4
"""Maximum number of bands of unsteady lines; with more, the spectrum is not one of lines."""
MIN_ADDITIONS_FOR_UNNAMED = 4
"""Number of additions from which an unnamed effect is compared with all further proposals."""


@dataclass(frozen=True, eq=False)
class AxisSearch:
    """Search for the missing effects of one axis.

    Attributes
    ----------
    start_fit
        Fit of the start model to the training part.
    training_fit, training_search
        Fit with the added effects to the training part, and the search that added them.
    whole_fit, whole_search
        The same for the whole log.
    held_out
        The last part of the log, which the training fits have not seen.
    bands, switching
        Bands of unsteady lines, and telegraph noise that the samples show but not the spectrum. Both were removed
        before all fits but that of the start model.
    """

    start_fit: AxisFit
    training_fit: AxisFit
    training_search: Search
    whole_fit: AxisFit
    whole_search: Search
    held_out: AxisSequence
    bands: tuple[Band, ...] = ()
    switching: Switching | None = None


@dataclass(frozen=True, eq=False)
class AxisResult:
    """Result of discovery on one axis.

    Attributes
    ----------
    start_fit
        Fit of the start model to the training part.
    training_fit
        Fit of the named effects to the training part; slow noise without a name is a power law.
    whole_fit
        The same for the whole log.
    findings
        The named effects.
    withheld
        Effects that were added but whose name a check rejects.
    bands
        Bands of unsteady lines, which have no name.
    switching
        Telegraph noise that the samples show but not the spectrum; it was removed before both fits.
    power_law
        Slow noise without a name, as fitted to the whole log; it is not among the findings.
    """

    start_fit: AxisFit
    training_fit: AxisFit
    whole_fit: AxisFit
    findings: tuple[Finding, ...]
    withheld: tuple[Withheld, ...]
    bands: tuple[Band, ...] = ()
    switching: Effect | None = None
    power_law: Finding | None = None

    def unnamed(self, axis: str, proposals: int) -> tuple[Unnamed, ...]:
        """Return what has no name, withheld effects and unsteady lines, chosen among a number of proposals."""
        lines = (
            (band.name, f"it is not steady, {band.low:.4g} to {band.high:.4g} Hz", band.log_p, -np.inf)
            for band in self.bands
        )
        withheld = ((one.name, one.reason, one.log_p, one.misfit_log_p) for one in self.withheld)
        return tuple(
            Unnamed(axis, name, reason, posterior(name, log_p, misfit_log_p, (), proposals))
            for name, reason, log_p, misfit_log_p in (*withheld, *lines)
        )

    @property
    def changed(self) -> bool:
        """Return whether anything was added to the start model, or was withheld."""
        return _names(self.start_fit) != _names(self.whole_fit) or bool(self.withheld) or self.switching is not None

    @property
    def same_names(self) -> bool:
        """Return whether training part and whole log show the same named effects."""
        return _names(self.training_fit) == _names(self.whole_fit)


def _names(found: AxisFit) -> list[str]:
    return sorted(effect.name for effect in found.description.effects() if effect.named)


def part(sequence: AxisSequence, first: int, last: int) -> AxisSequence:
    """Return samples ``first`` to ``last`` - 1, fewer by a few so that transforms are fast."""
    while next_fast_len(last - first, real=True) != last - first:
        last -= 1
    conditions, span = sequence.conditions, slice(first, last)
    return AxisSequence(
        sequence.values[span],
        replace(
            conditions,
            time=conditions.time[span],
            temperature=None if conditions.temperature is None else conditions.temperature[span],
            ideal=None if conditions.ideal is None else conditions.ideal.iloc[span],
        ),
        sequence.flawed[span],
        sequence.share,
        step=sequence.step,
    )


def search_axis(
    sequence: AxisSequence, start: Sequence[Effect], catalogue: tuple[type[Effect], ...], log_alpha: float, split: int
) -> AxisSearch:
    """Search one axis for missing effects: first the training part, then the whole log.

    The search of the whole log starts from the fit of the training part, without its outliers and changes of the
    variance: no later fit moves these, so that they are found anew. Where an unnamed function of the motion explains
    more than all added effects, in both, the search ends. It uses one thread; axes run in parallel.

    Parameters
    ----------
    sequence
        Samples of the axis.
    start
        Effects of the start model.
    catalogue
        Kinds of effects that may be missing.
    log_alpha
        Logarithm of the false-alarm probability of one proposal.
    split
        First sample of the held-out part.
    """
    with threadpool_limits(1):
        training, held_out = part(sequence, 0, split), part(sequence, split, len(sequence.values))
        before, early = _search_training(training, start, catalogue, log_alpha)
        end = float(sequence.conditions.time[-1] + sequence.conditions.interval)
        whole = wandering_lines.without_bands(part(sequence, 0, len(sequence.values)), early.bands)
        changes = before.description.of(Role.VARIANCE)
        kept = early.found.description.exchanging(Role.OUTLIERS).exchanging(Role.VARIANCE, changes)
        again = early.search.for_new_samples()
        begun = again.without_known_outliers(fit(whole, kept if early.switching is None else again.start))
        unchanging = replace(again, catalogue=tuple(kind for kind in catalogue if kind.role is not Role.VARIANCE))
        late = (
            _odd_in_both(again, begun, early) or _search(again, unchanging.refined(begun), early.bands)
        ).without_cache()
        return AxisSearch(
            before,
            _extend_changes(early.found, late.found.description.changes, end),
            early.search,
            late.found,
            late.search,
            held_out,
            late.bands,
            late.switching,
        )


def _search_training(
    training: AxisSequence, start: Sequence[Effect], catalogue: tuple[type[Effect], ...], log_alpha: float
) -> tuple[AxisFit, "_SearchEnd"]:
    """Return the fit of the start model to the training part, and the end of the search from there."""
    begin = fit(training, described(start, training))
    search = Search(begin.description, catalogue, log_alpha)
    before = search.without_known_outliers(begin)
    return before.without_cache(), _search(search, before).without_cache()


def _extend_changes(found: AxisFit, whole: Sequence[Effect], end: float) -> AxisFit:
    """Extend the changes of the variance that last to the end of the samples until ``end`` [s].

    Where the ``whole`` log has a change of about the same begin, it tells the end, which the samples do not.
    """
    description, last = found.description, found.sequence.conditions.time[-1]
    for index, effect in enumerate(description.effects()):
        if effect.role is Role.VARIANCE and effect.stop > last:
            nearest = min(whole, key=lambda one, own=effect: abs(one.start - own.start), default=None)
            stop = end if nearest is None else max(effect.stop, nearest.stop)
            description = description.with_effect(index, replace(effect, stop=stop))
    return replace(found, description=description)


@dataclass(frozen=True, eq=False)
class _SearchEnd:
    """End of a search, and what it removed from the samples.

    Attributes
    ----------
    search, found
        The search and its last fit.
    bands, switching
        Removed bands of unsteady lines, and removed telegraph noise.
    odd
        Whether an unnamed function of the motion explains more than all added effects.
    """

    search: Search
    found: AxisFit
    bands: tuple[Band, ...]
    switching: Switching | None = None
    odd: bool = False

    def without_cache(self) -> "_SearchEnd":
        """Drop intermediate fits and derived arrays, which are large."""
        return replace(self, search=self.search.without_memory(), found=self.found.without_cache())


def _odd_in_both(search: Search, begun: AxisFit, early: _SearchEnd) -> _SearchEnd | None:
    """Return the effects of the training part fitted to the whole log, if it is odd in both; else None."""
    if not early.odd or early.switching is not None:
        return None
    wide = None if early.found.description.outliers is None else search.without_outliers(begun)
    found = begun if wide is None else wide.fit
    odd = search.added(found) and all_against_motion(search, found).log_p < MAX_LOG_P
    return _SearchEnd(search, found, early.bands, odd=True) if odd else None


def _search(
    search: Search, before: AxisFit, taken: tuple[Band, ...] = (), switched: Switching | None = None
) -> _SearchEnd:
    """Search, then search again without bands of unsteady lines, and without telegraph noise within other noise.

    The search ends where an unnamed function of the motion explains more than all added effects.
    """
    found = search.explore(before, partial(_unnamed_gain, search, len(taken) < MAX_BANDS))
    if all_against_motion(search, found).log_p < MAX_LOG_P:
        return _SearchEnd(search, found, taken, switched, odd=True)
    found = simplified(search, steady(search, told_apart(search, found)))
    bands = _wandering(found) if len(taken) < MAX_BANDS else ()
    again = search.for_new_samples()
    if bands:
        cleared = wandering_lines.without_bands(before.sequence, bands)
        return _search(again, again.without_known_outliers(fit(cleared, search.start)), (*taken, *bands), switched)
    switched_too = hidden_telegraph(search, found) if switched is None else None
    if switched_too is None:
        return _SearchEnd(search, found, taken, switched)
    cleared = switched_too.without(before.sequence)
    return _search(again, again.without_known_outliers(fit(cleared, search.start)), taken, switched_too)


def _unnamed_gain(search: Search, remove_lines: bool, fit: AxisFit) -> float:
    """Return the gain of log-likelihood by unnamed effects over a fit; infinite where an unsteady line is removed next.

    A fit of few added effects has none. ``remove_lines`` says whether unsteady lines are removed.
    """
    if len(search.added(fit)) < MIN_ADDITIONS_FOR_UNNAMED:
        return -np.inf
    return np.inf if remove_lines and _wandering(fit) else motion_gain(search, fit)


def _wandering(fit: AxisFit) -> tuple[Band, ...]:
    """Return the narrow bands in which several tones of a fit describe one wandering line."""
    return wandering_lines.find_bands(fit, lambda index: shape_log_p(fit, index) > MAX_LOG_P)


def conclude(searched: AxisSearch, withdrawn: Mapping[type[Effect], str] = MappingProxyType({})) -> AxisResult:
    """Check the names that a search found, and return them with intervals, and the withheld ones with reasons.

    Kinds of effects that are ``withdrawn``, each with the reason, are among the withheld.
    """
    with threadpool_limits(1):
        search, whole = searched.whole_search, two_valued(searched.whole_fit)
        added = search.added(searched.whole_fit)
        rejected = _rejected(search, searched.whole_fit, withdrawn)
        kept = without_unnamed(search, whole, rejected)
        sweeps = (*find_chirps(kept, search.log_alpha), *find_tone_bursts(whole))
        in_sweep = explained_by_bands([one for one in added if one not in rejected], sweeps)
        final = without_unnamed(search, whole, rejected | in_sweep) if in_sweep else kept
        rejected |= in_sweep
        final = two_valued(final) if rejected else final
        named = [replace(one, fit=whole) for one in added if one not in rejected]
        settled = search.added(final, lambda effect: effect.named)
        switching, odd = _telegraph_finding(searched, rejected)
        findings = (*(_finding(searched, *pair) for pair in zip(named, settled, strict=True)), *switching)
        early = searched.training_search, searched.training_fit
        after = without_unnamed(*early, _rejected(*early, withdrawn))
        laws = [kind for kind in search.catalogue if kind not in withdrawn and not sweeps]
        law = noise_law(final, laws, search.log_alpha)
        if law is not None:
            final, findings = law.fit, (*findings, law.finding())
            early_law = noise_law(after, [type(law.distribution.effect)], search.log_alpha)
            after = after if early_law is None else early_law.fit
        unexplained = [one for one in rejected if law is None or one.role is not Role.OUTLIERS]
        nameless = (*(withheld(one, rejected[one]) for one in unexplained), *odd)
        bands = (*searched.bands, *sweeps)
        switches = searched.switching.effect if switching else None
        slope = power_law_finding(search, final)
        return AxisResult(
            searched.start_fit, after.without_cache(), final.without_cache(), findings, nameless, bands, switches, slope
        )


def _rejected(search: Search, found: AxisFit, withdrawn: Mapping[type[Effect], str]) -> dict[Candidate, Misfit]:
    """Return the added effects whose names the checks reject or that are withdrawn, with the reason."""
    added = (one for one in search.added(found) if type(one.effect) in withdrawn)
    return {one: Misfit(withdrawn[type(one.effect)], -np.inf) for one in added} | misfits(search, found)


def without_unnamed(search: Search, found: AxisFit, rejected: Mapping[Candidate, Misfit]) -> AxisFit:
    """Refit without the effects whose names are rejected; slow noise among them is replaced by a power law.

    It is replaced only where nothing but slow noise, and nothing but its spectrum, is rejected, and where the power law
    is not as steep as a trend. Samples that were replaced as outliers are put back if the name is rejected.
    """
    if any(one.role is Role.OUTLIERS for one in rejected):
        raw = replace(found, sequence=search.raw[found.description.outliers])
        return without(raw, list(rejected))
    kept = without(found, list(rejected))
    of_noise = (coloured(one.effect) and misfit.reason in NOISE_REASONS for one, misfit in rejected.items())
    if not rejected or not all(of_noise) or any(not one.named for one in kept.description.noise.effects):
        return kept
    carried = add_power_law(search.for_new_samples(), kept)
    gain = carried.log_likelihood - kept.log_likelihood
    law = carried.description.noise.effects[-1]
    sure = log_p_of_gain(gain, len(fields(law))) < search.log_alpha
    return carried if sure and not law.is_trend else kept


def power_law_finding(search: Search, found: AxisFit) -> Finding | None:
    """Return the added power law of a fit with its intervals, or None."""
    laws = search.added(found, lambda effect: not effect.named)
    if not laws:
        return None
    return Finding({found.sequence.conditions.axis: laws[0].effect}, intervals(found, laws[0].index), MIN_LOG_P)


def _telegraph_finding(
    searched: AxisSearch, rejected: Mapping[Candidate, Misfit]
) -> tuple[tuple[Finding, ...], tuple[Withheld, ...]]:
    """Return the removed telegraph noise as a finding or as withheld, if there is any.

    It is named where the rest is noise of any slope.
    """
    if searched.switching is None:
        return (), ()
    effect, log_p, conditions = (
        searched.switching.effect,
        searched.switching.log_p,
        searched.whole_fit.sequence.conditions,
    )
    axis = conditions.axis
    of_noise = [misfit.reason for one, misfit in rejected.items() if one.role is Role.NOISE]
    odd = [reason for reason in of_noise if reason not in SLOPE_REASONS]
    if len(searched.whole_search.added(searched.whole_fit, stepping)) >= MIN_EXTRA_VALUES:
        odd.append("it has more than two values")
    if odd:
        ends = map(float, conditions.time[[0, -1]])
        return (), (
            Withheld(
                effect.name,
                odd[0],
                Discrepancy("change", axis, *ends, "s", float(np.exp(max(log_p, MIN_LOG_P)))),
                log_p,
                -np.inf,
            ),
        )
    units = effect.units(axis_unit(axis))
    parameters = {
        name: Interval(value, *searched.switching.intervals[name], units[name])
        for name, value in effect.parameters().items()
    }
    return (Finding({axis: effect}, parameters, max(log_p, MIN_LOG_P), searched.switching.gain),), ()


def _finding(searched: AxisSearch, candidate: Candidate, settled: Candidate) -> Finding:
    """Return one effect with its intervals, its gain on held-out data, and the alternatives that fit as well.

    Values and intervals are those of the final fit (``settled``), which the model of the device has; significance and
    alternatives are those of the fit at the end of the search (``candidate``).
    """
    search, found, effect, final = candidate.search, candidate.fit, settled.effect, settled.fit
    axis, without = found.sequence.conditions.axis, candidate.without
    near = found.log_likelihood + search.log_alpha / 2
    duration = found.sequence.conditions.interval * len(found.sequence.values)
    alternatives, rivals = {}, {}
    bar = min(log_p_of_gain(near - without.log_likelihood, 1) + MAX_LOG_PLACES, search.log_alpha)
    for rival in candidate.alternatives(bar):
        if _same_tone(rival.effect, effect, duration):
            continue
        factor = rival.worth - candidate.trial.worth
        if rival.name not in rivals or factor > rivals[rival.name].log_bayes_factor:
            rivals[rival.name] = Rival(rival.name, factor, rival.fit.description.effects())
        if rival.fit.log_likelihood > near:
            gain = rival.fit.log_likelihood - found.log_likelihood
            alternatives[rival.name] = max(gain, alternatives.get(rival.name, -np.inf))
    if effect.two_valued:
        alternatives.pop(effect.equivalent.name, None)
        comparison, units = compare(final, (effect,)), effect.units(axis_unit(axis))
        parameters = {
            name: Interval(value, *ends, units[name])
            for (name, value), ends in zip(effect.parameters().items(), comparison.intervals, strict=True)
        }
        gain = comparison.gain
        smooth = effect.equivalent
        exchanged = found.description.with_effect(candidate.index, smooth)
        rivals[smooth.name] = Rival(smooth.name, -gain, exchanged.effects())
    elif effect.role is Role.OUTLIERS:
        parameters, gain = _outlier_parameters(search, final), search.tails[effect].gain
    elif repeats(type(effect)):
        parameters = intervals_beside_slow_noise(final, settled.index, search.catalogue)
        gain = _gain(searched, candidate)
    else:
        parameters = intervals(final, settled.index)
        gain = _gain(searched, candidate)
    return Finding(
        {axis: effect},
        parameters,
        max(candidate.trial.log_p, MIN_LOG_P),
        float(gain),
        tuple(alternatives.items()),
        found.description.effects(),
        tuple(rivals.values()),
        tested(candidate).log_p,
    )


def _same_tone(one: Effect, other: Effect, duration: float) -> bool:
    """Return whether two tones are one: together they cover less than the width of a line, as a chirp of no drift."""
    if not (one.tonal and other.tonal):
        return False
    ends = (*one.reach(duration), *other.reach(duration))
    return max(ends) - min(ends) < 1 / duration


def _gain(searched: AxisSearch, candidate: Candidate) -> float:
    """Return the gain of log-density of the held-out part by an effect of the fit to the whole log.

    It is that of fits to the training part, or, where that part does not show the effect, of those to the whole log.
    """
    effect = candidate.effect
    same = searched.training_search.added(searched.training_fit, lambda one: type(one) is type(effect))
    nearest = min(same, key=lambda one: _relative_difference(one.effect, effect), default=candidate)
    full, without = (log_score(searched.held_out, one.description) for one in (nearest.fit, nearest.without))
    return full - without


def _relative_difference(one: Effect, other: Effect) -> float:
    """Return the sum of the relative differences of the parameters of two effects of a kind."""
    pairs = zip(one.parameters().values(), other.parameters().values(), strict=True)
    return sum(abs(a - b) / (abs(a) + abs(b) or 1.0) for a, b in pairs)


def white_noise_finding(found: AxisFit) -> tuple[Finding, ...]:
    """Return the white noise of an axis as a finding, where its interval excludes zero."""
    axis, effect = found.sequence.conditions.axis, found.description.noise.effects[0]
    parameters = intervals(found, len(found.description.terms))
    seen = parameters["density"].low > 0
    return (Finding({axis: effect}, parameters, MIN_LOG_P),) if seen else ()


def _outlier_parameters(search: Search, found: AxisFit) -> dict[str, Interval]:
    effect = found.description.outliers
    tails = search.tails[effect]
    share, excess = tails.intervals
    unit = effect.std / tails.excess
    ends = tuple(end * unit for end in excess)
    return {
        "probability": Interval(effect.probability, *share, "1"),
        "std": Interval(effect.std, *ends, axis_unit(found.sequence.conditions.axis)),
    }


def model_of(found: AxisFit) -> AxisModel:
    """Return the fitted description as a model of the axis, with its offset as a bias."""
    return with_offset(offset(found.sequence, found.description), found.description.effects())
