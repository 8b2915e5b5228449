"""Step of the bias."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual, StepGains

WIDTHS = 0.01, 0.05
"""Time constants, over the duration, of the onsets and decays that resemble a step."""


@dataclass(frozen=True)
class BiasStep(SystematicEffect):
    """Bias from a given time on."""

    name: ClassVar[str] = "bias_step"
    most: ClassVar[int] = 3
    of_time: ClassVar[bool] = True
    event: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    time: float = parameter("s", "time of the step since power-on")
    step: float = parameter("{u}", "change of the bias", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return zero before the step and the step from its time on."""
        return np.where(conditions.time >= self.time, self.step, 0.0)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"time": self.time, "size": self.step})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivative in the step."""
        return {"step": np.where(conditions.time >= self.time, 1.0, 0.0)}

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return trends before and after the step, with an onset before and a decay after it, quick or slow."""
        late = conditions.time - self.time
        before, after = np.minimum(late, 0.0), np.maximum(late, 0.0)
        return [
            np.column_stack([before, after, (late < 0) * np.exp(before / width), (late >= 0) * np.exp(-after / width)])
            for width in np.array(WIDTHS) * np.ptp(conditions.time)
        ]

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield a step where the matched filter of all steps is highest."""
        yield cls.highest(fit.steps, fit.sequence.conditions)

    @classmethod
    def highest(cls, steps: StepGains, conditions: Conditions) -> Start:
        """Return a step where the matched filter is highest."""
        place = int(np.argmax(steps.gains))
        time, gain = float(conditions.time[place]), float(steps.gains[place])
        return Start(cls(time, 0.0), ("step",), trials=steps.places(gain), gain=gain)


def _step(own, x, now):
    return x + own.size if now.time(0) >= own.time else x
