"""Telegraph noise in the place of what a search by spectra makes of its switches."""

from dataclasses import replace

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.discovery.fit.telegraph_likelihood import Blocks, compare, likeliest
from imugap.discovery.search.search import Search, changing, coloured, little, log_p_of_gain, stepping, without
from imugap.discovery.search.telegraph_in_noise import Switching, switching
from imugap.effects import RandomTelegraph
from imugap.effects.effect import Effect, StochasticEffect

MIN_SWITCHES, MAX_SIZE_SPREAD = 3, 0.4
"""Steps to and fro at least, and largest difference of their sizes over the largest, that are telegraph noise."""
MAX_SWITCH_RATIO = 2.0
"""Size of a step, in those of telegraph noise beside it, below which it is one of its switches."""


def told_apart(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of what the samples show to have two values."""
    found = _one_telegraph(search, _switching(search, _many_steps(search, found)))
    slow = _slow_part(search, found)
    if not slow or found.has(RandomTelegraph):
        return found
    comparison = compare(found, slow)
    if comparison.gain < -search.log_alpha / 2:
        return found
    kept = found.description.keeping(lambda entry: entry.known or entry.effect not in slow)
    for index, entry in enumerate(kept.entries):
        if entry.effect in slow:
            kept = kept.with_effect(index, little(entry.effect))
    exchanged = _without_switches(search, fit(found.sequence, kept.adding(comparison.effect)))
    beside = _stepless(search).explore(exchanged, _end_without_telegraph)
    return _one_telegraph(search, beside) if beside.has(RandomTelegraph) else exchanged


def steady(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit without the added changes of variance that are clusters of switches of telegraph noise."""
    changes = search.added(found, changing)
    if not changes or not search.added(found, _is_two_valued):
        return found
    blocks = Blocks.of(found, _slow(search, found))
    likelihood = likeliest(blocks).log_likelihood
    for change in changes:
        others = found.description.without([change.index]).changes
        gain = likelihood - likeliest(blocks.changed(found.sequence, others)).log_likelihood
        if log_p_of_gain(gain, 1) > search.log_alpha:
            return steady(search, without(found, [change]))
    return found


def hidden_telegraph(search: Search, found: AxisFit) -> Switching | None:
    """Return the telegraph noise of a fit beside another process, in the place of steps and slow noise too."""
    if not search.added(found, _is_two_valued):
        return None
    stepless = without(found, search.added(found, stepping))
    return switching(stepless, _slow(search, stepless), search.log_alpha)


def two_valued(found: AxisFit) -> AxisFit:
    """Return the fit with the telegraph noise that the samples, not their spectrum alone, make most likely."""
    description = found.description
    for index, effect in enumerate(description.effects()):
        if isinstance(effect, RandomTelegraph):
            description = description.with_effect(index, compare(found, (effect,)).effect)
    return replace(found, description=description)


def _many_steps(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of more steps than can have their name, if it is that."""
    steps = search.added(found, stepping)
    if not steps or len(steps) <= steps[0].effect.most:
        return found
    stepless = _stepless(search)
    other = told_apart(stepless, stepless.explore(without(found, steps)))
    return other if other.has(RandomTelegraph) else found


def _switching(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with telegraph noise in the place of steps to and fro of one size."""
    steps = sorted(search.added(found, stepping), key=lambda candidate: candidate.effect.time)
    jumps = np.array([candidate.effect.step for candidate in steps])
    if (
        len(jumps) < MIN_SWITCHES
        or np.any(np.diff(np.sign(jumps)) == 0)
        or np.ptp(np.abs(jumps)) > MAX_SIZE_SPREAD * np.abs(jumps).max()
    ):
        return found
    rest = without(found, steps).description
    duration = found.sequence.conditions.interval * len(found.sequence.values)
    effect = RandomTelegraph(float(np.abs(jumps).mean()), len(jumps) / duration)
    return fit(found.sequence, rest.adding(effect))


def _without_switches(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit without the added steps that are switches of its telegraph noise, for their size."""
    most = MAX_SWITCH_RATIO * max(
        one.step for one in found.description.noise.effects if isinstance(one, RandomTelegraph)
    )
    return without(found, [one for one in search.added(found, stepping) if abs(one.effect.step) < most])


def _one_telegraph(search: Search, found: AxisFit) -> AxisFit:
    """Return the fit with one telegraph noise in the place of several that were added, which no log tells apart."""
    added = search.added(found, _is_two_valued)
    if len(added) < 2:
        return found
    one = compare(found, tuple(candidate.effect for candidate in added)).effect
    return fit(found.sequence, without(found, added).description.adding(one))


def _end_without_telegraph(found: AxisFit) -> float:
    """Return the gain that ends a search: any where the fit has no telegraph noise any more."""
    return -np.inf if found.has(RandomTelegraph) else np.inf


def _stepless(search: Search) -> Search:
    """Return the search that looks for no steps of the mean."""
    return replace(search, catalogue=tuple(kind for kind in search.catalogue if not kind.event))


def _slow_part(search: Search, found: AxisFit) -> tuple[StochasticEffect, ...]:
    """Return the slow noise that was added; where changes of the variance stand for its switches, what stands for it.

    That may be slow noise of the start model, which is free.
    """
    added = tuple(candidate.effect for candidate in search.added(found, lambda effect: effect.slow))
    if added or not search.too_many_changes(found):
        return added
    return tuple(one for one in found.description.noise.effects if one.slow)


def _slow(search: Search, found: AxisFit) -> tuple[StochasticEffect, ...]:
    """Return the slow processes of a fit that were added."""
    return tuple(candidate.effect for candidate in search.added(found, coloured))


def _is_two_valued(effect: Effect) -> bool:
    return effect.two_valued
