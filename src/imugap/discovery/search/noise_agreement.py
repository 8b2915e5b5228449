"""The axes of a sensor have slow noise of one kind, unless their samples say otherwise.

They are built alike. An axis whose slow noise is too faint to tell kinds apart, or a step or trend from noise, is taken
to have the kind that all axes of its sensor together speak for, if it explains that axis nearly as well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Candidate, Search, Trial, expected, without
from imugap.effects.effect import Effect
from imugap.log import ACCEL, GYRO

MIN_LEAD = 3.0
"""Log-likelihood, parameters and places paid for, by which axes together have to speak for one kind."""
PRIOR_LOG_ODDS = 4.0
"""Logarithm of how much likelier the kind of the sensor is than any other on one axis, before its samples.

With no more does an axis speak against a kind: what it has may be its own.
"""
MAX_EFFECTS = 2
"""Number of effects that it may be taken for on one axis."""
MAX_TIME_RATIO = 10.0
"""By how much longer a correlation time may be than on the axes that have such a process of their own."""


@dataclass(frozen=True, eq=False)
class NoiseChoice:
    """The effects on an axis that slow noise is or may be taken for, and slow noise of each kind in their place.

    Attributes
    ----------
    kinds
        Of the own effects, of which there may be none.
    own
        What these are worth together.
    found, without
        The fits with and without them.
    noise
        Trials of each kind in their place.
    """

    kinds: tuple[type[Effect], ...]
    own: float
    found: AxisFit
    without: AxisFit
    noise: Mapping[type[Effect], Trial]

    def worth(self, kind: type[Effect]) -> float:
        """Return what a kind is worth, over that of the own effects."""
        return self.noise[kind].worth - self.own if kind in self.noise else -PRIOR_LOG_ODDS

    def time(self, kind: type[Effect]) -> float:
        """Return the correlation time [s] of the process of a kind in their place; 0 where it has none."""
        effects = self.noise[kind].fit.description.noise
        return [effect.correlation_time for effect in effects if type(effect) is kind][-1] if _timed(kind) else 0.0

    def no_slower(self, longest: float) -> "NoiseChoice":
        """Return the choice without processes of a correlation time above the longest [s]."""
        return replace(self, noise={kind: one for kind, one in self.noise.items() if self.time(kind) <= longest})

    def alike(self, kind: type[Effect], log_alpha: float) -> AxisFit:
        """Return the fit with noise of a kind, if it is not much less likely; without any, if that is uncertain.

        Where there is no room for that kind, the fit as it is.
        """
        if kind not in self.noise or self.worth(kind) < -PRIOR_LOG_ODDS:
            return self.found
        other = self.noise[kind]
        return other.fit if other.log_p < log_alpha else self.without


def agreed(fits: Mapping[str, AxisFit], searches: Mapping[str, Search]) -> dict[str, AxisFit]:
    """Return the fits of axes, those in doubt with slow noise of the kind that their sensor speaks for."""
    found = dict(fits)
    for sensor in (GYRO, ACCEL):
        added = {axis: searches[axis].added(fits[axis], _faint) for axis in sensor if axis in fits}
        few = {axis: some for axis, some in added.items() if len(some) <= MAX_EFFECTS}
        if not _at_issue(list(map(_kinds, few.values()))):
            continue
        choices = _of_one_time({axis: choice_of(searches[axis], fits[axis], some) for axis, some in few.items()})
        catalogue = next(iter(searches.values())).catalogue
        kind = _spoken_for(list(choices.values()), [kind for kind in catalogue if kind.slow])
        if kind is not None:
            found |= {axis: choices[axis].alike(kind, searches[axis].log_alpha) for axis, some in few.items() if some}
    return found


def _faint(effect: Effect) -> bool:
    """Return whether faint slow noise may be taken for an effect."""
    return effect.slow or effect.of_time


def _timed(kind: type[Effect]) -> bool:
    return "correlation_time" in kind.limits()


def _at_issue(kinds: list[tuple[type[Effect], ...]]) -> bool:
    """Return whether axes differ in what they have, or one of several has a mean that noise may be taken for."""
    differ = len({some for some in kinds if some}) > 1
    return differ or (len(kinds) > 1 and any(kind.of_time for some in kinds for kind in some))


def _kinds(candidates: Sequence[Candidate]) -> tuple[type[Effect], ...]:
    return tuple(type(candidate.effect) for candidate in candidates)


def choice_of(search: Search, fit: AxisFit, candidates: Sequence[Candidate]) -> NoiseChoice:
    """Return some added effects of a fit, of which there may be none, and the likeliest noise of each slow kind."""
    weighed = [candidate.trial for candidate in candidates]
    kinds = _kinds(candidates)
    bare = search.fitted(fit.sequence, without(fit, candidates).description)
    own = fit.log_likelihood - bare.log_likelihood - sum(one.cost for one in weighed) + expected(*kinds)
    others = [search.trial_of(start, bare) for kind in search.catalogue if kind.slow for start in kind.starts(bare)]
    noise = {type(one.effect): one for one in sorted(others, key=lambda trial: trial.worth)}
    if len(kinds) == 1 and kinds[0].slow:
        noise[kinds[0]] = weighed[0]
    return NoiseChoice(kinds, own, fit, bare, noise)


def _of_one_time(choices: Mapping[str, NoiseChoice]) -> dict[str, NoiseChoice]:
    """Return the choices without processes far slower than those that axes have of their own; they are not alike."""
    alone = [(choice, choice.kinds[0]) for choice in choices.values() if len(choice.kinds) == 1]
    own = [choice.time(kind) for choice, kind in alone if _timed(kind)]
    longest = MAX_TIME_RATIO * max(own, default=np.inf)
    return {axis: choice.no_slower(longest) for axis, choice in choices.items()}


def _spoken_for(choices: list[NoiseChoice], slow: list[type[Effect]]) -> type[Effect] | None:
    """Return the kind of slow noise that all axes together make much likelier than any other, if there is one.

    On one of them it is what was found, or all are much likelier with it than with what was found.
    """
    totals = {kind: sum(max(choice.worth(kind), -PRIOR_LOG_ODDS) for choice in choices) for kind in slow}
    if not totals:
        return None
    *others, first = sorted(totals, key=totals.get)
    second = totals[others[-1]] if others else -PRIOR_LOG_ODDS * len(choices)
    shown = any(choice.kinds == (first,) for choice in choices) or totals[first] > MIN_LEAD
    return first if shown and totals[first] > second + MIN_LEAD else None
