"""The axes of a sensor have slow noise of one kind, unless their samples say otherwise.

They are built alike. An axis whose slow noise is too faint to tell kinds apart, or a step or trend from noise, is taken
to have the kind that all axes of its sensor together speak for, if it explains that axis nearly as well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import OF_TIME, SLOW, Key, Search, Trial, at, expected, without
from imugap.effects import GaussMarkov
from imugap.effects.effect import Effect
from imugap.log import ACCEL, GYRO

CLEAR = 3.0
"""Log-likelihood, parameters and places paid for, by which axes together have to speak for one kind."""
BEFOREHAND = 4.0
"""Logarithm of how much likelier the kind of the sensor is than any other on one axis, before its samples.

With no more does an axis speak against a kind: what it has may be its own.
"""
FAINT = (*SLOW, *OF_TIME)
"""What faint slow noise may be taken for."""
MOST = 2
"""Number of effects that it may be taken for on one axis."""
SLOWER = 10.0
"""By how much longer a correlation time may be than on the axes that have such a process of their own."""


@dataclass(frozen=True, eq=False)
class _Choice:
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
        return self.noise[kind].worth - self.own if kind in self.noise else -BEFOREHAND

    @property
    def time(self) -> float:
        """Return the correlation time [s] of the Gauss-Markov process in their place."""
        effects = self.noise[GaussMarkov].fit.description.noise
        return [effect.correlation_time for effect in effects if isinstance(effect, GaussMarkov)][-1]

    def no_slower(self, longest: float) -> "_Choice":
        """Return the choice without a Gauss-Markov process of a correlation time above the longest [s]."""
        if GaussMarkov not in self.noise or self.time <= longest:
            return self
        return replace(self, noise={kind: one for kind, one in self.noise.items() if kind is not GaussMarkov})

    def alike(self, kind: type[Effect], log_alpha: float) -> AxisFit:
        """Return the fit with noise of a kind, if it is not much less likely; without any, if that is uncertain.

        Where there is no room for that kind, the fit as it is.
        """
        if kind not in self.noise or self.worth(kind) < -BEFOREHAND:
            return self.found
        other = self.noise[kind]
        return other.fit if other.log_p < log_alpha else self.without


def agreed(fits: Mapping[str, AxisFit], searches: Mapping[str, Search]) -> dict[str, AxisFit]:
    """Return the fits of axes, those in doubt with slow noise of the kind that their sensor speaks for."""
    found = dict(fits)
    for sensor in (GYRO, ACCEL):
        keys = {axis: searches[axis].added(fits[axis].description, FAINT) for axis in sensor if axis in fits}
        few = {axis: some for axis, some in keys.items() if len(some) <= MOST}
        if not _at_issue([_kinds(fits[axis], some) for axis, some in few.items()]):
            continue
        choices = _of_one_time({axis: _choice(searches[axis], fits[axis], some) for axis, some in few.items()})
        kind = _spoken_for(list(choices.values()))
        if kind is not None:
            found |= {axis: choices[axis].alike(kind, searches[axis].log_alpha) for axis, some in few.items() if some}
    return found


def _at_issue(kinds: list[tuple[type[Effect], ...]]) -> bool:
    """Return whether axes differ in what they have, or one of several has a mean that noise may be taken for."""
    differ = len({some for some in kinds if some}) > 1
    return differ or (len(kinds) > 1 and any(kind in OF_TIME for some in kinds for kind in some))


def _kinds(fit: AxisFit, keys: Sequence[Key]) -> tuple[type[Effect], ...]:
    return tuple(type(at(fit.description, key)) for key in keys)


def _choice(search: Search, fit: AxisFit, keys: Sequence[Key]) -> _Choice:
    """Return the effects at some keys of a fit, and the likeliest slow noise of each kind in their place."""
    weighed = [search.weighed(fit, key)[0] for key in keys]
    kinds = _kinds(fit, keys)
    bare = search.fitted(fit.sequence, without(fit, keys).description)
    own = fit.log_likelihood - bare.log_likelihood - sum(one.cost for one in weighed) + expected(*kinds)
    others = [search.judged(start, bare) for kind in SLOW if kind in search.catalogue for start in kind.starts(bare)]
    noise = {type(one.effect): one for one in sorted(others, key=lambda trial: trial.worth)}
    if len(kinds) == 1 and kinds[0] in SLOW:
        noise[kinds[0]] = weighed[0]
    return _Choice(kinds, own, fit, bare, noise)


def _of_one_time(choices: Mapping[str, _Choice]) -> dict[str, _Choice]:
    """Return the choices without processes far slower than those that axes have of their own; they are not alike."""
    own = [choice.time for choice in choices.values() if choice.kinds == (GaussMarkov,)]
    longest = SLOWER * max(own, default=np.inf)
    return {axis: choice.no_slower(longest) for axis, choice in choices.items()}


def _spoken_for(choices: list[_Choice]) -> type[Effect] | None:
    """Return the kind of slow noise that all axes together make much likelier than any other, if there is one.

    On one of them it is what was found, or all are much likelier with it than with what was found.
    """
    totals = {kind: sum(max(choice.worth(kind), -BEFOREHAND) for choice in choices) for kind in SLOW}
    second, first = sorted(totals, key=totals.get)[-2:]
    shown = any(choice.kinds == (first,) for choice in choices) or totals[first] > CLEAR
    return first if shown and totals[first] > totals[second] + CLEAR else None
