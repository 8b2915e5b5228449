"""What happens on one axis: from the start model through the search to names, doubts and intervals."""

from collections.abc import Sequence as Several
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import next_fast_len
from threadpoolctl import threadpool_limits

from imugap.discovery import unsteady
from imugap.discovery.axis import AxisFit, fit, log_score, offset
from imugap.discovery.doubt import beside_a_sweep, doubts
from imugap.discovery.finding import CERTAIN, Finding, Interval
from imugap.discovery.parameters import axis_unit, intervals
from imugap.discovery.search import MANY, SLOW, Key, Search, at, log_chance, removed
from imugap.discovery.sequence import Sequence
from imugap.discovery.start import described
from imugap.discovery.sweeps import swept
from imugap.discovery.switching import Switching, switching
from imugap.discovery.telegraph import Blocks, compare, weighed
from imugap.discovery.unsteady import Band
from imugap.discovery.withheld import Withheld, withheld
from imugap.effects import (
    Bias,
    BiasStep,
    RandomTelegraph,
    Sinusoid,
    VarianceChange,
)
from imugap.effects.effect import Effect, StochasticEffect
from imugap.model import AxisModel

SWITCHES, ALIKE = 3, 0.4
"""Steps to and fro at least, and largest difference of their sizes over the largest, that are telegraph noise."""
TWICE = 2.0
"""Size of a step, in those of telegraph noise beside it, below which it is one of its switches."""
PLACES = 12.0
"""Logarithm of the largest number of places of which an effect is tried at the best."""
MOST_BANDS = 4
"""Bands of lines that are not steady at most; with more the spectrum is another than that of lines."""


@dataclass(frozen=True, eq=False)
class Tale:
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
    held_out: Sequence
    bands: tuple[Band, ...] = ()
    switching: Switching | None = None


@dataclass(frozen=True, eq=False)
class Story:
    """The discovery on one axis.

    Attributes
    ----------
    before
        Fit of the start model to the held-in part.
    after
        Fit of the named effects to the held-in part.
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
    """

    before: AxisFit
    after: AxisFit
    whole: AxisFit
    findings: tuple[Finding, ...]
    withheld: tuple[Withheld, ...]
    bands: tuple[Band, ...] = ()
    switching: RandomTelegraph | None = None

    def unnamed(self) -> tuple[tuple[str, str], ...]:
        """Return the nearest name, and the reason why it is not given, of what was seen."""
        lines = ((Sinusoid.name, f"it is not steady, {band.low:.4g} to {band.high:.4g} Hz") for band in self.bands)
        return (*((one.name, one.reason) for one in self.withheld), *lines)

    @property
    def seen(self) -> bool:
        """Return whether anything was added to the start model, or was seen and has no name."""
        return _names(self.before) != _names(self.whole) or bool(self.withheld) or self.switching is not None

    @property
    def settled(self) -> bool:
        """Return whether the held-in part shows every effect that the whole log shows."""
        return _names(self.after) == _names(self.whole)


def _names(found: AxisFit) -> list[str]:
    return sorted(effect.name for effect in found.description.effects())


def part(sequence: Sequence, first: int, last: int) -> Sequence:
    """Return samples ``first`` to ``last``, a few less where that makes transforms fast."""
    while next_fast_len(last - first, real=True) != last - first:
        last -= 1
    conditions, span = sequence.conditions, slice(first, last)
    return Sequence(
        sequence.values[span],
        replace(
            conditions,
            time=conditions.time[span],
            temperature=None if conditions.temperature is None else conditions.temperature[span],
            ideal=None if conditions.ideal is None else conditions.ideal.iloc[span],
        ),
        sequence.flawed[span],
        sequence.share,
    )


def told(
    sequence: Sequence, start: Several[Effect], catalogue: tuple[type[Effect], ...], log_alpha: float, split: int
) -> Tale:
    """Search one axis; the samples from ``split`` on are held out.

    Outliers and changes of the variance, which no later fit moves, are found in the whole log anew. One thread is
    enough for vectors of this length, and axes are worked on side by side.
    """
    with threadpool_limits(1):
        held_in, held_out = part(sequence, 0, split), part(sequence, split, len(sequence.values))
        begin = fit(held_in, described(start, held_in))
        search = Search(begin.description, catalogue, log_alpha)
        before = search.cleared(begin)
        early = _searched(search, before)
        whole = unsteady.without(part(sequence, 0, len(sequence.values)), early.bands)
        kept = replace(early.found.description, outliers=None, changes=before.description.changes)
        again = search.afresh()
        begun = again.cleared(fit(whole, kept if early.switching is None else search.start))
        late = _searched(again, again.settled(begun), early.bands)
        return Tale(
            before.bare(),
            early.found.bare(),
            early.search.forgetful(),
            late.found.bare(),
            late.search.forgetful(),
            held_out,
            late.bands,
            late.switching,
        )


@dataclass(frozen=True, eq=False)
class _Searched:
    """The end of a search, and what was taken out on the way."""

    search: Search
    found: AxisFit
    bands: tuple[Band, ...]
    switching: Switching | None


def _searched(
    search: Search, before: AxisFit, taken: tuple[Band, ...] = (), switched: Switching | None = None
) -> _Searched:
    """Search, and again without the bands of lines that are not steady, or telegraph noise that another hides."""
    found = _steady(search, _told_apart(search, search.explore(before)))
    bands = unsteady.bands(found) if len(taken) < MOST_BANDS else ()
    again = search.afresh()
    if bands:
        cleared = unsteady.without(before.sequence, bands)
        return _searched(again, again.cleared(fit(cleared, search.start)), (*taken, *bands), switched)
    switched_too = _hidden_telegraph(search, found) if switched is None else None
    if switched_too is None:
        return _Searched(search, found, taken, switched)
    cleared = switched_too.without(before.sequence)
    return _searched(again, again.cleared(fit(cleared, search.start)), taken, switched_too)


def _steady(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit without the added changes of variance that are clusters of switches of telegraph noise."""
    if not _added(search, found, RandomTelegraph):
        return found
    blocks = Blocks.of(found, _slow(search, found))
    likelihood = weighed(blocks).log_likelihood
    for key in _added(search, found, VarianceChange):
        others = removed(found.description, key).changes
        gain = likelihood - weighed(blocks.changed(found.sequence, others)).log_likelihood
        if log_chance(gain, 1) > search.log_alpha:
            return _steady(search, _without(found, [key]))
    return found


def _hidden_telegraph(search: Search, found: AxisFit) -> Switching | None:
    """Return the telegraph noise of a fit beside another process, in the place of steps and slow noise too."""
    if not _added(search, found, RandomTelegraph):
        return None
    stepless = _without(found, _added(search, found, BiasStep))
    return switching(stepless, _slow(search, stepless), search.log_alpha)


def _slow(search: Search, found: AxisFit) -> tuple[StochasticEffect, ...]:
    """Return the slow processes of a fit that were added."""
    return tuple(at(found.description, key) for key in _added(search, found, (*SLOW, RandomTelegraph)))


def _added(search: Search, found: AxisFit, kinds: type[Effect] | tuple[type[Effect], ...]) -> list[Key]:
    """Return where the effects of some kinds are that the start model does not have."""
    return [key for key in search.added(found.description) if isinstance(at(found.description, key), kinds)]


def concluded(tale: Tale) -> Story:
    """Return what a search says: names with intervals, and what is withheld."""
    with threadpool_limits(1):
        search, whole = tale.late, _two_valued(tale.whole)
        doubtful = doubts(search, tale.whole)
        sweeps = swept(_without(whole, list(doubtful)), search.log_alpha)
        sure = [key for key in search.added(whole.description) if key not in doubtful]
        doubtful |= beside_a_sweep(search, tale.whole, sure, sweeps)
        named = [key for key in search.added(whole.description) if key not in doubtful]
        findings = (*(_finding(tale, whole, key) for key in named), *_of_samples(tale))
        nameless = tuple(withheld(search, tale.whole, key, doubt) for key, doubt in doubtful.items())
        after = _without(tale.after, list(doubts(tale.early, tale.after)))
        final = _without(whole, list(doubtful))
        bands = (*tale.bands, *sweeps)
        switches = None if tale.switching is None else tale.switching.effect
        return Story(tale.before, after.bare(), final.bare(), findings, nameless, bands, switches)


def _of_samples(tale: Tale) -> tuple[Finding, ...]:
    """Return the telegraph noise that only the samples tell as a finding, if there is one."""
    if tale.switching is None:
        return ()
    effect, axis = tale.switching.effect, tale.whole.sequence.conditions.axis
    units = effect.units(axis_unit(axis))
    parameters = {
        name: Interval(value, *tale.switching.intervals[name], units[name])
        for name, value in effect.parameters().items()
    }
    return (Finding({axis: effect}, parameters, max(tale.switching.log_p, CERTAIN), tale.switching.gain),)


def _two_valued(found: AxisFit) -> AxisFit:
    """Return the fit with the telegraph noise that the samples, not their spectrum alone, make most likely."""
    noise = found.description.noise
    effects = tuple(compare(found, (one,)).effect if isinstance(one, RandomTelegraph) else one for one in noise.effects)
    return replace(found, description=replace(found.description, noise=replace(noise, effects=effects)))


def _told_apart(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of what the samples show to have two values."""
    found = _one_telegraph(search, _switching(search, _many_steps(search, found)))
    keys = _added(search, found, SLOW)
    if not keys or found.has(RandomTelegraph):
        return found
    verdict = compare(found, tuple(at(found.description, key) for key in keys))
    if verdict.gain < -search.log_alpha / 2:
        return found
    noise = _without(found, keys).description.noise
    effects = replace(noise, effects=(*noise.effects, verdict.effect))
    switching = _without_switches(search, fit(found.sequence, replace(found.description, noise=effects)))
    beside = _stepless(search).explore(switching)
    return _one_telegraph(search, beside) if beside.has(RandomTelegraph) else switching


def _one_telegraph(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with one telegraph noise in the place of several that were added, which no log tells apart."""
    added = _added(search, found, RandomTelegraph)
    if len(added) < 2:
        return found
    one = compare(found, tuple(at(found.description, key) for key in added)).effect
    rest = _without(found, added).description
    return fit(found.sequence, replace(rest, noise=replace(rest.noise, effects=(*rest.noise.effects, one))))


def _stepless(search: Search) -> Search:
    """Return the search that looks for no steps of the mean."""
    return replace(search, catalogue=tuple(kind for kind in search.catalogue if kind is not BiasStep))


def _without_switches(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit without the added steps that are switches of its telegraph noise, for their size."""
    most = TWICE * max(one.step for one in found.description.noise.effects if isinstance(one, RandomTelegraph))
    steps = _added(search, found, BiasStep)
    return _without(found, [key for key in steps if abs(at(found.description, key).step) < most])


def _many_steps(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of more steps than can have their name, if it is that."""
    steps = _added(search, found, BiasStep)
    if len(steps) <= MANY[BiasStep]:
        return found
    stepless = _stepless(search)
    other = _told_apart(stepless, stepless.explore(_without(found, steps)))
    return other if other.has(RandomTelegraph) else found


def _switching(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of steps to and fro of one size."""
    steps = _added(search, found, BiasStep)
    sizes = [at(found.description, key) for key in steps]
    jumps = np.array([effect.step for effect in sorted(sizes, key=lambda effect: effect.time)])
    if (
        len(jumps) < SWITCHES
        or np.any(np.diff(np.sign(jumps)) == 0)
        or np.ptp(np.abs(jumps)) > ALIKE * np.abs(jumps).max()
    ):
        return found
    rest = _without(found, steps).description
    duration = found.sequence.conditions.interval * len(found.sequence.values)
    effect = RandomTelegraph(float(np.abs(jumps).mean()), len(jumps) / duration)
    noise = replace(rest.noise, effects=(*rest.noise.effects, effect))
    return fit(found.sequence, replace(rest, noise=noise))


def _without(found: AxisFit, keys: list[Key]) -> AxisFit:
    """Return the fit without some of its effects."""
    description = found.description
    for key in sorted(keys, key=lambda key: -key.index):
        description = replace(description, outliers=None) if key.part == "outliers" else removed(description, key)
    return fit(found.sequence, description) if keys else found


def _finding(tale: Tale, found: AxisFit, key: Key) -> Finding:
    """Return one effect with its intervals, its gain on held-out data, and what cannot be told from it."""
    search, axis = tale.late, found.sequence.conditions.axis
    effect = at(found.description, key)
    own, without = search.weighed(found, key)
    near = found.log_likelihood + search.log_alpha / 2
    alternatives = {}
    bar = min(log_chance(near - without.log_likelihood, 1) + PLACES, search.log_alpha)
    for rival in search.rivals(found, key, without, bar):
        if rival.fit.log_likelihood > near:
            gain = rival.fit.log_likelihood - found.log_likelihood
            alternatives[rival.name] = max(gain, alternatives.get(rival.name, -np.inf))
    if isinstance(effect, RandomTelegraph):
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
        gain = _gain(tale, effect, found, without)
    return Finding({axis: effect}, parameters, max(own.log_p, CERTAIN), float(gain), tuple(alternatives.items()))


def _gain(tale: Tale, effect: Effect, found: AxisFit, without: AxisFit) -> float:
    """Return the gain of log-density of the held-out part by an effect, by fits to the held-in part.

    Where that does not show it, by those to the whole log, ``found`` and ``without``.
    """
    added = [(key, at(tale.after.description, key)) for key in tale.early.added(tale.after.description)]
    same = [(_apart(one, effect), key) for key, one in added if type(one) is type(effect)]
    if same:
        key = min(same, key=lambda one: one[0])[1]
        found, without = tale.after, tale.early.weighed(tale.after, key)[1]
    return log_score(tale.held_out, found.description) - log_score(tale.held_out, without.description)


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
    return AxisModel((Bias(offset(found.sequence, found.description)), *found.description.effects()))
