"""Rate or acceleration ramp."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AllanEffect, Start, SystematicEffect, parameter
from imugap.effects.residual import Residual


@dataclass(frozen=True)
class RateRamp(SystematicEffect, AllanEffect):
    """Trend R t since power-on, which has no spectrum: sigma(tau) = R tau/sqrt(2) (IEEE 952, rate ramp)."""

    name: ClassVar[str] = "rate_ramp"
    of_time: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    slope: float = parameter("{u}/s", "R, change of the bias per second", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return R t."""
        return self.slope * conditions.time

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"slope": self.slope})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the time, for the slope."""
        return {"slope": conditions.time}

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return curvature and torsion: powers two and three of the time."""
        centred = np.linspace(-1.0, 1.0, len(conditions))
        return [np.column_stack([centred**2, centred**3])]

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield a flat ramp, where there is none yet."""
        if not fit.has(cls):
            gain = fit.gains(fit.whiten(fit.sequence.conditions.time[:, None]))[0]
            yield Start(cls(0.0), ("slope",), gain=float(gain))

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return R^2 tau^2/2 (IEEE 952)."""
        return (self.slope * np.asarray(tau, float)) ** 2 / 2

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return R^2 (n interval)^2/2: means over neighbouring n samples are n intervals apart."""
        return self.allan_variance(np.asarray(averaging) * interval)


def _step(own, x, now):
    return x + own.slope * now.time(0)
