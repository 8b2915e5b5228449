"""The axes of a sensor have slow noise of one kind, unless their samples say otherwise.

They are built alike. An axis whose slow noise is too faint to tell kinds apart, or a step or trend from noise, is taken
to have the kind that all axes of its sensor together speak for, if it explains that axis nearly as well.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from imugap.discovery.axis import AxisFit
from imugap.discovery.search import SLOW, Key, Search, Trial, at
from imugap.effects import BiasStep, RateRamp, WarmUp
from imugap.effects.effect import Effect
from imugap.log import ACCEL, GYRO

CLEAR = 3.0
"""Log-likelihood, parameters and places paid for, by which axes together have to speak for one kind."""
BEFOREHAND = 4.0
"""Logarithm of how much likelier the kind of the sensor is than any other on one axis, before its samples.

With no more does an axis speak against a kind: what it has may be its own.
"""
FAINT = (*SLOW, BiasStep, RateRamp, WarmUp)
"""What faint slow noise may be taken for."""


@dataclass(frozen=True, eq=False)
class _Choice:
    """The one effect on an axis that slow noise is or may be taken for, and slow noise of each kind in its place."""

    own: Trial
    without: AxisFit
    noise: Mapping[type[Effect], Trial]

    def worth(self, kind: type[Effect]) -> float:
        """Return what a kind is worth, over that of the own effect."""
        return self.noise[kind].worth - self.own.worth if kind in self.noise else -BEFOREHAND

    def alike(self, kind: type[Effect], log_alpha: float) -> AxisFit:
        """Return the fit with noise of a kind, if it is not much less likely; without any, if that is uncertain."""
        if self.worth(kind) < -BEFOREHAND:
            return self.own.fit
        other = self.noise[kind]
        return other.fit if other.log_p < log_alpha else self.without


def agreed(fits: Mapping[str, AxisFit], searches: Mapping[str, Search]) -> dict[str, AxisFit]:
    """Return the fits of axes, those in doubt with slow noise of the kind that their sensor speaks for."""
    found = dict(fits)
    for sensor in (GYRO, ACCEL):
        keys = {axis: searches[axis].added(fits[axis].description, FAINT) for axis in sensor if axis in fits}
        single = {axis: some[0] for axis, some in keys.items() if len(some) == 1}
        if len({type(at(fits[axis].description, key)) for axis, key in single.items()}) < 2:
            continue
        choices = {axis: _choice(searches[axis], fits[axis], key) for axis, key in single.items()}
        kind = _spoken_for(list(choices.values()))
        if kind is not None:
            found |= {axis: choice.alike(kind, searches[axis].log_alpha) for axis, choice in choices.items()}
    return found


def _choice(search: Search, fit: AxisFit, key: Key) -> _Choice:
    """Return the effect at a key of a fit, and the likeliest slow noise of each kind in its place."""
    own, without = search.weighed(fit, key)
    kinds = [kind for kind in SLOW if kind in search.catalogue]
    trials = [search.judged(start, without) for kind in kinds for start in kind.starts(without)]
    best = {type(one.effect): one for one in sorted(trials, key=lambda trial: trial.worth)}
    return _Choice(own, without, best | {type(own.effect): own} if isinstance(own.effect, SLOW) else best)


def _spoken_for(choices: list[_Choice]) -> type[Effect] | None:
    """Return the kind of slow noise of an axis that all together make much likelier than any other, if there is one."""
    totals = {kind: sum(max(choice.worth(kind), -BEFOREHAND) for choice in choices) for kind in SLOW}
    second, first = sorted(totals, key=totals.get)[-2:]
    shown = any(isinstance(choice.own.effect, first) for choice in choices)
    return first if shown and totals[first] > totals[second] + CLEAR else None
