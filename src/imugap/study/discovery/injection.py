"""Known effects in real noise: are they found, with their names and sizes?

An effect of known size is added to the log of a real device. Discovery starts from the model that it found on the log
without it, so that what it names is what was added. Sizes are in detection limits: at size 1 a test that knows the
shape, at 1 % false alarms, finds one half in the noise of that model.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from imu_benchmark.sealing.detection_limits import Z
from imugap.discovery.device import Names, Settings, name_missing
from imugap.discovery.finding import Finding
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects import BiasStep, RateRamp, Sinusoid, WarmUp
from imugap.effects.conditions import Conditions
from imugap.effects.effect import SystematicEffect
from imugap.model import ErrorModel
from imugap.stream import stream

LINES, STEPS, CONSTANTS = (0.02, 0.45), (0.2, 0.8), (0.05, 0.25)
"""Ranges of the frequency [sampling rates], of the time of a step and of the time constant of a warm-up [durations]."""


class Kind(NamedTuple):
    """A kind of effect that is injected: the parameter that carries its size, and how one of unit size is drawn.

    ``draw`` takes a generator, the sampling interval [s] and the duration of the log [s].
    """

    size: str
    draw: Callable[[np.random.Generator, float, float], SystematicEffect]


KINDS: Mapping[str, Kind] = {
    "sinusoid": Kind("amplitude", lambda rng, interval, _: Sinusoid(rng.uniform(*LINES) / interval, 1.0, _phase(rng))),
    "bias_step": Kind("step", lambda rng, _, duration: BiasStep(rng.uniform(*STEPS) * duration, 1.0)),
    "rate_ramp": Kind("slope", lambda *_: RateRamp(1.0)),
    "warm_up": Kind("amplitude", lambda rng, _, duration: WarmUp(1.0, rng.uniform(*CONSTANTS) * duration)),
}
"""Kinds of effects by name."""


@dataclass(frozen=True, eq=False)
class Untouched:
    """A log of one axis without further effects, and what discovery found on it."""

    run: str
    axis: str
    log: pd.DataFrame
    found: Names

    @property
    def fit(self) -> AxisFit:
        """Return the fit of the final model to the log."""
        return self.found.results[self.axis].whole_fit

    @property
    def model(self) -> ErrorModel:
        """Return the model that was found."""
        return self.found.final


@dataclass(frozen=True, eq=False)
class Injection:
    """Effects injected into a log at a ``size`` [detection limits], and what discovery found of them."""

    base: Untouched
    size: float
    injected: tuple[SystematicEffect, ...]
    findings: tuple[Finding, ...]

    def rows(self) -> list[dict]:
        """Return a row for each injected effect: whether it is named, its size over the truth, and whether an interval
        holds it; and how many other names the log got."""
        names = [one.name for one in self.injected]
        others = sum(one.name not in names for one in self.findings)
        return [self._row(effect) | {"together": len(names), "others": others} for effect in self.injected]

    def _row(self, effect: SystematicEffect) -> dict:
        key = KINDS[effect.name].size
        true = getattr(effect, key)
        found = next((one.parameters[key] for one in self.findings if one.name == effect.name), None)
        same = {"run": self.base.run, "axis": self.base.axis, "name": effect.name, "size": self.size}
        if found is None:
            return same | {"named": False, "ratio": np.nan, "inside": np.nan}
        return same | {"named": True, "ratio": found.value / true, "inside": found.low <= true <= found.high}


def untouched(run: str, axis: str, log: pd.DataFrame, settings: Settings) -> Untouched:
    """Discover on one axis of a log as it is, at the level that it has among six."""
    own = log[[axis]]
    return Untouched(run, axis, own, name_missing([own], settings.of_some_axes(1)))


def inject(base: Untouched, kinds: Sequence[str], size: float, settings: Settings) -> Injection:
    """Add effects of a size [detection limits] to a log, and discover on it from the model without them."""
    conditions = base.fit.sequence.conditions
    effects = tuple(_of_size(kind, size, base, settings.seed) for kind in kinds)
    added = sum(effect.sample(_whole(conditions, base.log), None) for effect in effects)
    log = base.log.assign(**{base.axis: base.log[base.axis] + added})
    found = name_missing([log], replace(settings.of_some_axes(1), start=base.model))
    return Injection(base, size, effects, found.findings)


def _whole(conditions: Conditions, log: pd.DataFrame) -> Conditions:
    """Return the conditions of all rows of a log, of which a fit may leave out the last few."""
    time = log.index.to_numpy(float)
    return Conditions(time - time[0] + conditions.time[0], conditions.interval, axis=conditions.axis)


def _of_size(kind: str, size: float, base: Untouched, seed: int) -> SystematicEffect:
    """Draw an effect of a kind, and scale it to its size in the noise of the log."""
    rng = stream(seed, "injection", base.run, base.axis, kind, size)
    conditions = base.fit.sequence.conditions
    duration = conditions.interval * len(conditions)
    size_of, draw = KINDS[kind]
    unit = draw(rng, conditions.interval, duration)
    waveform = base.fit.whiten(unit.sample(conditions, None)[:, None])
    scale = size * Z / np.linalg.norm(waveform) * rng.choice([-1.0, 1.0])
    lowest, _ = unit.limits()[size_of]
    return replace(unit, **{size_of: float(scale if lowest < 0 else abs(scale))})


def _phase(rng: np.random.Generator) -> float:
    return rng.uniform(-np.pi, np.pi)
