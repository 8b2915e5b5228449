"""Warm-up."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block, exp
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Start, SystematicEffect, parameter
from imugap.effects.residual import Residual

CONSTANTS = 14
"""Number of time constants of the grid of a search."""


@dataclass(frozen=True)
class WarmUp(SystematicEffect):
    """Exponential approach to the final bias, amplitude exp(-t/T) from power-on at t = 0."""

    name: ClassVar[str] = "warm_up"
    title: ClassVar[str] = "warm-up"
    of_time: ClassVar[bool] = True
    transient: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    amplitude: float = parameter("{u}", "excess of the bias at power-on", low=-np.inf)
    time_constant: float = parameter("s", "T", low=TINY)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return amplitude exp(-t/T)."""
        return self.amplitude * np.exp(-conditions.time / self.time_constant)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"amplitude": self.amplitude, "time_constant": self.time_constant})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivatives in amplitude and time constant."""
        aged = conditions.time / self.time_constant
        decay = np.exp(-aged)
        return {"amplitude": decay, "time_constant": self.amplitude * decay * aged / self.time_constant}

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return decays of two other time constants and a trend."""
        decays = [np.exp(-conditions.time / (factor * self.time_constant)) for factor in (0.3, 3.0)]
        return [np.column_stack([*decays, conditions.time])]

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the time constant, from a grid, with the best fit to the residual."""
        if fit.has(cls):
            return
        conditions = fit.sequence.conditions
        grid = np.geomspace(10 * conditions.interval, conditions.interval * len(conditions) / 2, CONSTANTS)
        decays = (np.exp(-conditions.time[:, None] / constant) for constant in grid)
        gains = np.array([fit.gains(fit.whiten(decay))[0] for decay in decays])
        start = cls(0.0, float(grid[np.argmax(gains)]))
        yield Start(start, ("amplitude", "time_constant"), trials=CONSTANTS / 2, gain=float(gains.max()))


def _step(own, x, now):
    return x + own.amplitude * exp(-now.time(0) / own.time_constant)
