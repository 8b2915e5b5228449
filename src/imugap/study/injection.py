"""Known effects in real noise: are they found, with their names and sizes?

An effect of known size is added to the log of a real device. Discovery starts from the model that it found on the log
without it, so that what it names is what was added. Sizes are in detection limits: at size 1 a test that knows the
shape, at 1 % false alarms, finds one half in the noise of that model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.stats import norm

from imugap.discovery.device import Discovery, Settings, discover
from imugap.discovery.finding import Finding
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects import BiasStep, RateRamp, Sinusoid, WarmUp
from imugap.effects.conditions import Conditions
from imugap.effects.effect import SystematicEffect
from imugap.log import AXES
from imugap.model import ErrorModel
from imugap.stream import stream

LIMIT = float(norm.isf(0.01))
"""Detection limit of a known waveform [Cramer-Rao standard deviations of its amplitude]."""
SIZE = {"sinusoid": "amplitude", "bias_step": "step", "rate_ramp": "slope", "warm_up": "amplitude"}
"""Parameter that carries the size of an effect."""
LINES, STEPS, CONSTANTS = (0.02, 0.45), (0.2, 0.8), (0.05, 0.25)
"""Ranges of the frequency [sampling rates], of the time of a step and of the time constant of a warm-up [durations]."""


@dataclass(frozen=True, eq=False)
class Untouched:
    """A log of one axis without further effects, and what discovery found on it."""

    run: str
    axis: str
    log: pd.DataFrame
    found: Discovery

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
    """Injected effects, and what discovery found of them."""

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
        key, true = SIZE[effect.name], getattr(effect, SIZE[effect.name])
        found = next((one.parameters[key] for one in self.findings if one.name == effect.name), None)
        same = {"run": self.base.run, "axis": self.base.axis, "name": effect.name, "size": self.size}
        if found is None:
            return same | {"named": False, "ratio": np.nan, "inside": np.nan}
        return same | {"named": True, "ratio": found.value / true, "inside": found.low <= true <= found.high}


def untouched(run: str, axis: str, log: pd.DataFrame, settings: Settings) -> Untouched:
    """Discover on one axis of a log as it is, at the level that it has among six."""
    own = log[[axis]]
    return Untouched(run, axis, own, discover([own], _of_one_axis(settings)))


def inject(base: Untouched, kinds: Sequence[str], size: float, settings: Settings) -> Injection:
    """Add effects of a size [detection limits] to a log, and discover on it from the model without them."""
    conditions = base.fit.sequence.conditions
    effects = tuple(_of_size(kind, size, base, settings.seed) for kind in kinds)
    added = sum(effect.sample(_whole(conditions, base.log), None) for effect in effects)
    log = base.log.assign(**{base.axis: base.log[base.axis] + added})
    found = discover([log], replace(_of_one_axis(settings), start=base.model))
    return Injection(base, size, effects, found.findings)


def _of_one_axis(settings: Settings) -> Settings:
    return replace(settings, alpha=settings.alpha / len(AXES))


def _whole(conditions: Conditions, log: pd.DataFrame) -> Conditions:
    """Return the conditions of all rows of a log, of which a fit may leave out the last few."""
    time = log.index.to_numpy(float)
    return Conditions(time - time[0] + conditions.time[0], conditions.interval, axis=conditions.axis)


def _of_size(kind: str, size: float, base: Untouched, seed: int) -> SystematicEffect:
    """Draw an effect of a kind, and scale it to its size in the noise of the log."""
    rng = stream(seed, "injection", base.run, base.axis, kind, size)
    conditions = base.fit.sequence.conditions
    duration = conditions.interval * len(conditions)
    unit = _shapes(rng, conditions.interval, duration)[kind]
    waveform = base.fit.whiten(unit.sample(conditions, None)[:, None])
    scale = size * LIMIT / np.linalg.norm(waveform) * rng.choice([-1.0, 1.0])
    amplitude = abs(scale) if kind == "sinusoid" else scale
    return replace(unit, **{SIZE[kind]: float(amplitude)})


def _shapes(rng: np.random.Generator, interval: float, duration: float) -> Mapping[str, SystematicEffect]:
    """Draw one effect of each kind, of unit size."""
    return {
        "sinusoid": Sinusoid(rng.uniform(*LINES) / interval, 1.0, rng.uniform(-np.pi, np.pi)),
        "bias_step": BiasStep(rng.uniform(*STEPS) * duration, 1.0),
        "rate_ramp": RateRamp(1.0),
        "warm_up": WarmUp(1.0, rng.uniform(*CONSTANTS) * duration),
    }
