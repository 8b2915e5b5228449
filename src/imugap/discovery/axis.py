"""What happens on one axis: from the start model through the search to names, doubts and intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from scipy.fft import next_fast_len
from threadpoolctl import threadpool_limits

from imugap.discovery.checks import (
    LEVEL,
    OF_NOISE,
    OF_SLOPE,
    VALUES,
    Doubt,
    beside_a_sweep,
    beside_power_law,
    doubts,
)
from imugap.discovery.checks.motion import in_place_of_all, without_a_name
from imugap.discovery.checks.withheld import Withheld, withheld
from imugap.discovery.finding import CERTAIN, Finding, Gap, Interval
from imugap.discovery.fit.axis_fit import AxisFit, fit, log_score, offset
from imugap.discovery.fit.start_model import described
from imugap.discovery.fit.telegraph_likelihood import compare
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.intervals import axis_unit, intervals
from imugap.discovery.search.search import Key, Search, at, coloured, log_chance, stepping, without
from imugap.discovery.search.telegraph import hidden_telegraph, steady, told_apart, two_valued
from imugap.discovery.search.telegraph_in_noise import Switching
from imugap.discovery.unnamed import wandering_lines as unsteady
from imugap.discovery.unnamed.chirps import swept
from imugap.discovery.unnamed.tone_bursts import glints
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.model import with_offset

PLACES = 12.0
"""Logarithm of the largest number of places of which an effect is tried at the best."""
MOST_BANDS = 4
"""Bands of lines that are not steady at most; with more the spectrum is another than that of lines."""


@dataclass(frozen=True, eq=False)
class AxisSearch:
    """The search on one axis.

    Attributes
    ----------
    before
        Fit of the start model to the held-in part.
    after, early
        Fit to the held-in part with what was added, and the search that added it.
    whole, late
        The same of the whole log, with what only its last part shows.
    held_out
        The last part.
    bands, switching
        Lines that are not steady, and telegraph noise that only the samples tell; the fits, but for that of the start
        model, are without them.
    """

    before: AxisFit
    after: AxisFit
    early: Search
    whole: AxisFit
    late: Search
    held_out: AxisSequence
    bands: tuple[Band, ...] = ()
    switching: Switching | None = None


@dataclass(frozen=True, eq=False)
class AxisResult:
    """The discovery on one axis.

    Attributes
    ----------
    before
        Fit of the start model to the held-in part.
    after
        Fit of the named effects to the held-in part, and of noise of any slope for such noise without a name.
    whole
        The same to the whole log, with what only its last part shows.
    findings
        The effects that were named.
    withheld
        What was seen but fits no name.
    bands
        Of lines that are not steady; no name fits them.
    switching
        Telegraph noise that only the samples tell, which both fits after the start model are without.
    of_any_slope
        Noise that fits no name, as the fit to the whole log has it; it is not among the findings.
    """

    before: AxisFit
    after: AxisFit
    whole: AxisFit
    findings: tuple[Finding, ...]
    withheld: tuple[Withheld, ...]
    bands: tuple[Band, ...] = ()
    switching: Effect | None = None
    of_any_slope: Finding | None = None

    def unnamed(self) -> tuple[tuple[str, str], ...]:
        """Return the nearest name, and the reason why it is not given, of what was seen."""
        lines = ((band.name, f"it is not steady, {band.low:.4g} to {band.high:.4g} Hz") for band in self.bands)
        return (*((one.name, one.reason) for one in self.withheld), *lines)

    @property
    def seen(self) -> bool:
        """Return whether anything was added to the start model, or was seen and has no name."""
        return _names(self.before) != _names(self.whole) or bool(self.withheld) or self.switching is not None

    @property
    def settled(self) -> bool:
        """Return whether the held-in part shows every effect with a name that the whole log shows."""
        return _names(self.after) == _names(self.whole)


def _names(found: AxisFit) -> list[str]:
    return sorted(effect.name for effect in found.description.effects() if effect.named)


def part(sequence: AxisSequence, first: int, last: int) -> AxisSequence:
    """Return samples ``first`` to ``last``, a few less where that makes transforms fast."""
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
    """Search one axis; the samples from ``split`` on are held out.

    Outliers and changes of the variance, which no later fit moves, are found in the whole log anew; nothing is
    exchanged for a change before the outliers are out. Where a function of the motion without a name says more than all
    that the first part shows, in the whole log too, no more is looked for. One thread is enough for vectors of this
    length, and axes are worked on side by side.
    """
    with threadpool_limits(1):
        held_in, held_out = part(sequence, 0, split), part(sequence, split, len(sequence.values))
        before, early = _early(held_in, start, catalogue, log_alpha)
        end = float(sequence.conditions.time[-1] + sequence.conditions.interval)
        whole = unsteady.without(part(sequence, 0, len(sequence.values)), early.bands)
        kept = replace(early.found.description, outliers=None, changes=before.description.changes)
        again = early.search.afresh()
        begun = again.cleared(fit(whole, kept if early.switching is None else again.start))
        unchanging = replace(again, catalogue=tuple(kind for kind in catalogue if kind.role is not Role.VARIANCE))
        late = (_odd_again(again, begun, early) or _searched(again, unchanging.settled(begun), early.bands)).bare()
        return AxisSearch(
            before,
            _lasting(early.found, end),
            early.search,
            late.found,
            late.search,
            held_out,
            late.bands,
            late.switching,
        )


def _early(
    held_in: AxisSequence, start: Sequence[Effect], catalogue: tuple[type[Effect], ...], log_alpha: float
) -> tuple[AxisFit, "_Searched"]:
    """Return the fit of the start model, and the end of the search that begins with it."""
    begin = fit(held_in, described(start, held_in))
    search = Search(begin.description, catalogue, log_alpha)
    before = search.cleared(begin)
    return before.bare(), _searched(search, before).bare()


def _lasting(found: AxisFit, end: float) -> AxisFit:
    """Return a fit whose changes of the variance go on until ``end`` [s] if they last as long as its samples do."""
    description, last = found.description, found.sequence.conditions.time[-1]
    changes = tuple(replace(one, stop=max(one.stop, end)) if one.stop > last else one for one in description.changes)
    return replace(found, description=replace(description, changes=changes))


@dataclass(frozen=True, eq=False)
class _Searched:
    """The end of a search, and what was taken out on the way.

    It is ``odd`` where a function of the motion without a name says more than all that was found.
    """

    search: Search
    found: AxisFit
    bands: tuple[Band, ...]
    switching: Switching | None = None
    odd: bool = False

    def bare(self) -> "_Searched":
        """Return the same without the fits on the way, and without what was derived from the last one."""
        return replace(self, search=self.search.forgetful(), found=self.found.bare())


def _odd_again(search: Search, begun: AxisFit, early: _Searched) -> _Searched | None:
    """Return what was found in the first part, outliers too, fitted to the whole log, if it is odd there as well."""
    if not early.odd or early.switching is not None:
        return None
    wide = None if early.found.description.outliers is None else search.cleaned(begun)
    found = begun if wide is None else wide.fit
    odd = search.added(found.description) and in_place_of_all(search, found).log_p < LEVEL
    return _Searched(search, found, early.bands, odd=True) if odd else None


def _searched(
    search: Search, before: AxisFit, taken: tuple[Band, ...] = (), switched: Switching | None = None
) -> _Searched:
    """Search, and again without the bands of lines that are not steady, or telegraph noise that another hides.

    Of what goes with the motion in a way that has no name no more is to be told.
    """
    found = search.explore(before, partial(_nameless, search, len(taken) < MOST_BANDS))
    if in_place_of_all(search, found).log_p < LEVEL:
        return _Searched(search, found, taken, switched, odd=True)
    found = steady(search, told_apart(search, found))
    bands = unsteady.bands(found) if len(taken) < MOST_BANDS else ()
    again = search.afresh()
    if bands:
        cleared = unsteady.without(before.sequence, bands)
        return _searched(again, again.cleared(fit(cleared, search.start)), (*taken, *bands), switched)
    switched_too = hidden_telegraph(search, found) if switched is None else None
    if switched_too is None:
        return _Searched(search, found, taken, switched)
    cleared = switched_too.without(before.sequence)
    return _searched(again, again.cleared(fit(cleared, search.start)), taken, switched_too)


def _nameless(search: Search, taken_out: bool, fit: AxisFit) -> float:
    """Return how much log-likelihood what has no name gains over a fit; no end of lines where one is not steady.

    ``taken_out`` is whether such lines are, before anything else is looked for.
    """
    return np.inf if taken_out and unsteady.bands(fit) else without_a_name(search, fit)


def conclude(searched: AxisSearch) -> AxisResult:
    """Return what a search says: names with intervals, and what is withheld."""
    with threadpool_limits(1):
        search, whole = searched.late, two_valued(searched.whole)
        doubtful = doubts(search, searched.whole)
        kept = without_unnamed(search, whole, doubtful)
        sweeps = (*swept(kept, search.log_alpha), *glints(whole))
        sure = [key for key in search.added(whole.description) if key not in doubtful]
        swept_up = beside_a_sweep(search, searched.whole, sure, sweeps)
        final = without_unnamed(search, whole, doubtful | swept_up) if swept_up else kept
        doubtful |= swept_up
        named = [key for key in search.added(whole.description) if key not in doubtful]
        switching, odd = _of_samples(searched, doubtful)
        findings = (*(_finding(searched, whole, key) for key in named), *switching)
        nameless = (*(withheld(search, searched.whole, key, doubt) for key, doubt in doubtful.items()), *odd)
        after = without_unnamed(searched.early, searched.after, doubts(searched.early, searched.after))
        bands = (*searched.bands, *sweeps)
        switches = searched.switching.effect if switching else None
        slope = power_law_finding(search, final)
        return AxisResult(searched.before, after.bare(), final.bare(), findings, nameless, bands, switches, slope)


def without_unnamed(search: Search, found: AxisFit, doubtful: Mapping[Key, Doubt]) -> AxisFit:
    """Return the fit without what is in doubt; if that is slow noise, with noise of the slope that it has.

    Only where nothing but slow noise is in doubt, and nothing but its spectrum: what is no noise has no place there,
    nor has a slope as steep as that of a trend. Outliers in doubt are samples again.
    """
    if any(key.part == "outliers" for key in doubtful):
        raw = replace(found, sequence=search.raw[found.description.outliers])
        return without(raw, list(doubtful))
    kept = without(found, list(doubtful))
    of_noise = (coloured(at(found.description, key)) and doubt.reason in OF_NOISE for key, doubt in doubtful.items())
    if not doubtful or not all(of_noise) or any(not one.named for one in kept.description.noise.effects):
        return kept
    carried = beside_power_law(search.afresh(), kept)
    gain = carried.log_likelihood - kept.log_likelihood
    law = carried.description.noise.effects[-1]
    sure = log_chance(gain, len(fields(law))) < search.log_alpha
    return carried if sure and not law.is_trend else kept


def power_law_finding(search: Search, found: AxisFit) -> Finding | None:
    """Return the power law that a fit has more than the start model, with its intervals."""
    laws = search.added(found.description, lambda effect: not effect.named)
    if not laws:
        return None
    law = at(found.description, laws[0])
    return Finding({found.sequence.conditions.axis: law}, intervals(found, found, laws[0]), CERTAIN)


def _of_samples(
    searched: AxisSearch, doubtful: Mapping[Key, Doubt]
) -> tuple[tuple[Finding, ...], tuple[Withheld, ...]]:
    """Return the telegraph noise that only the samples tell, if there is one, as a finding or as withheld.

    They tell it where what is left is noise, of whatever slope.
    """
    if searched.switching is None:
        return (), ()
    effect, log_p, conditions = searched.switching.effect, searched.switching.log_p, searched.whole.sequence.conditions
    axis = conditions.axis
    odd = [one.reason for key, one in doubtful.items() if key.part == "noise" and one.reason not in OF_SLOPE]
    if len(searched.late.added(searched.whole.description, stepping)) >= VALUES:
        odd.append("it has more than two values")
    if odd:
        ends = map(float, conditions.time[[0, -1]])
        return (), (Withheld(effect.name, odd[0], Gap("change", axis, *ends, "s", float(np.exp(max(log_p, CERTAIN))))),)
    units = effect.units(axis_unit(axis))
    parameters = {
        name: Interval(value, *searched.switching.intervals[name], units[name])
        for name, value in effect.parameters().items()
    }
    return (Finding({axis: effect}, parameters, max(log_p, CERTAIN), searched.switching.gain),), ()


def _finding(searched: AxisSearch, found: AxisFit, key: Key) -> Finding:
    """Return one effect with its intervals, its gain on held-out data, and what cannot be told from it."""
    search, axis = searched.late, found.sequence.conditions.axis
    effect = at(found.description, key)
    own, without = search.weighed(found, key)
    near = found.log_likelihood + search.log_alpha / 2
    alternatives = {}
    bar = min(log_chance(near - without.log_likelihood, 1) + PLACES, search.log_alpha)
    for rival in search.rivals(found, key, without, bar):
        if rival.fit.log_likelihood > near:
            gain = rival.fit.log_likelihood - found.log_likelihood
            alternatives[rival.name] = max(gain, alternatives.get(rival.name, -np.inf))
    if effect.two_valued:
        alternatives.pop("gauss_markov", None)
        verdict, units = compare(found, (effect,)), effect.units(axis_unit(axis))
        parameters = {
            name: Interval(value, *ends, units[name])
            for (name, value), ends in zip(effect.parameters().items(), verdict.intervals, strict=True)
        }
        gain = verdict.gain
    elif key.part == "outliers":
        parameters, gain = _of_outliers(search, found), search.tails[effect].gain
    else:
        parameters = intervals(found, without, key)
        gain = _gain(searched, effect, found, without)
    return Finding({axis: effect}, parameters, max(own.log_p, CERTAIN), float(gain), tuple(alternatives.items()))


def _gain(searched: AxisSearch, effect: Effect, found: AxisFit, without: AxisFit) -> float:
    """Return the gain of log-density of the held-out part by an effect, by fits to the held-in part.

    Where that does not show it, by those to the whole log, ``found`` and ``without``.
    """
    added = [(key, at(searched.after.description, key)) for key in searched.early.added(searched.after.description)]
    same = [(_apart(one, effect), key) for key, one in added if type(one) is type(effect)]
    if same:
        key = min(same, key=lambda one: one[0])[1]
        found, without = searched.after, searched.early.weighed(searched.after, key)[1]
    return log_score(searched.held_out, found.description) - log_score(searched.held_out, without.description)


def _apart(one: Effect, other: Effect) -> float:
    """Return how far the parameters of two effects of a kind are apart, each relative to its size."""
    pairs = zip(one.parameters().values(), other.parameters().values(), strict=True)
    return sum(abs(a - b) / (abs(a) + abs(b) or 1.0) for a, b in pairs)


def noise_of(found: AxisFit) -> tuple[Finding, ...]:
    """Return the white noise of an axis whose start model has no noise at all as a finding, where there is some."""
    axis, effect = found.sequence.conditions.axis, found.description.noise.effects[0]
    parameters = intervals(found, found, Key("noise", 0))
    seen = parameters["density"].low > 0
    return (Finding({axis: effect}, parameters, CERTAIN),) if seen else ()


def _of_outliers(search: Search, found: AxisFit) -> dict[str, Interval]:
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
    """Return the fitted description as a model of the axis, its offset as a bias."""
    return with_offset(offset(found.sequence, found.description), found.description.effects())
