"""What an exported file leaves out of an error model: each effect with its size, and what the log of a device lacks."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import isinf

import numpy as np

from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, AllanEffect, AxisModel, Effect, Stage

SAMPLES = 2**14
"""Samples of a simulated log at rest."""
SEED = 0
SAME = 0.01
"""Relative difference of Allan deviations that is none."""
Distance = Callable[[AxisModel, AxisModel, Conditions], float]
"""Distance of a log at rest of the first model from simulations of the second, under conditions."""


@dataclass(frozen=True)
class Omission:
    """Effect of an axis that a file leaves out.

    Attributes
    ----------
    axis, effect
        Axis and effect.
    ratio, time
        Allan deviation without it over that with it, at the averaging time [s] at which they differ most; None where
        it takes a motion, a temperature or several runs to show.
    distance
        Distance of a log at rest from simulations without it, as discovery measures it; 1 if they are as alike as two
        logs of the device, infinite where the simulations have no scatter to measure it by. None where it is not asked
        for, or the effect does not show at rest.
    """

    axis: str
    effect: Effect
    ratio: float | None
    time: float | None
    distance: float | None = None

    def sentence(self) -> str:
        """Return what is left out, how large it is, and what that costs, as text."""
        size = ", ".join(f"{name} {value:.6e}" for name, value in self.effect.parameters().items())
        return f"{self.axis} {self.effect.name} ({size}): {self._cost()}{self._distance()}"

    def _distance(self) -> str:
        if self.distance is None:
            return ""
        if isinf(self.distance):
            return "; without it the model has no noise that a distance could be measured by"
        return f"; distance {self.distance:.3g} (1: as alike as two logs of the device)"

    def _cost(self) -> str:
        if self.ratio is None:
            return "it shows with motion, temperature or over several runs only, not in the Allan deviation at rest"
        if abs(self.ratio - 1) < SAME:
            return f"no Allan deviation at rest changes by more than {SAME:.0%}"
        return f"without it the Allan deviation is {self.ratio:.2g} times what it should be at {self.time:.3g} s"


def cost(
    axis: str, model: AxisModel, effect: Effect, interval: float, longest: float, distance: Distance | None = None
) -> Omission:
    """Return an effect of a model with what leaving it out changes, up to an averaging time [s].

    The Allan variance of an effect that has one is exact; that of any other is of a simulated log at rest with and
    without it, drawn from the same random numbers.
    """
    found = _in_allan(axis, model, effect, interval, longest)
    if distance is None or found.ratio is None:
        return found
    at = Conditions(interval * np.arange(SAMPLES), interval, None, axis)
    return replace(found, distance=distance(*(_at_rest(one, at) for one in (model, _without(model, effect))), at))


def _without(model: AxisModel, effect: Effect) -> AxisModel:
    return AxisModel(tuple(one for one in model if one is not effect))


def _in_allan(axis: str, model: AxisModel, effect: Effect, interval: float, longest: float) -> Omission:
    rest = _without(model, effect)
    if isinstance(effect, AllanEffect):
        tau = np.geomspace(interval, longest, 200)
        return _largest(axis, effect, tau, rest.allan_variance(tau), model.allan_variance(tau))
    conditions = Conditions(interval * np.arange(SAMPLES), interval, None, axis)
    if effect.stage >= Stage.CLOCK or not _acts(effect, conditions):
        return Omission(axis, effect, None, None)
    runs = [_simulated(some, conditions) for some in (rest, model)]
    factors = 2 ** np.arange(int(np.log2(SAMPLES)) - 4)
    before, after = (np.array([_allan_variance(one, factor) for factor in factors]) for one in runs)
    return _largest(axis, effect, factors * interval, before, after)


def costs(
    axis: str, model: AxisModel, effects: Iterable[Effect], interval: float, longest: float,
    distance: Distance | None = None,
) -> list[Omission]:  # fmt: skip
    """Return the cost of each of some effects of a model."""
    return [cost(axis, model, one, interval, longest, distance) for one in effects]


def _largest(axis: str, effect: Effect, tau: np.ndarray, without: np.ndarray, full: np.ndarray) -> Omission:
    """Return the effect with the ratio of deviations that is farthest from one."""
    log_ratio = (np.log(np.maximum(without, TINY)) - np.log(np.maximum(full, TINY))) / 2
    place = int(np.argmax(np.abs(log_ratio)))
    return Omission(axis, effect, float(np.exp(log_ratio[place])), float(tau[place]))


def _acts(effect: Effect, conditions: Conditions) -> bool:
    """Return whether an effect can be simulated at rest."""
    try:
        AxisModel((effect,)).simulate(np.zeros(len(conditions)), conditions, SEED, "left out")
    except ValueError:
        return False
    return True


def _at_rest(model: AxisModel, conditions: Conditions) -> AxisModel:
    """Return a model without the effects that need a motion or a temperature."""
    return AxisModel(tuple(effect for effect in model if _acts(effect, conditions)))


def _simulated(model: AxisModel, conditions: Conditions) -> np.ndarray:
    """Return the output at rest."""
    return _at_rest(model, conditions).simulate(np.zeros(len(conditions)), conditions, SEED, "left out")


def _allan_variance(values: np.ndarray, factor: int) -> float:
    """Return the Allan variance of samples at an averaging factor, overlapping."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    means = (sums[factor:] - sums[:-factor]) / factor
    return float(np.mean((means[factor:] - means[:-factor]) ** 2) / 2)
