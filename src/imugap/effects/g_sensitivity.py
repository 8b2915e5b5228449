"""Sensitivity of a gyroscope to specific force."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import CHANNELS, Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class GSensitivity(SystematicEffect):
    """Rate error proportional to the specific force (IEEE 528: acceleration-sensitive drift rate)."""

    name: ClassVar[str] = "g_sensitivity"
    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    x: float = parameter("rad/s/(m/s^2)", "error per specific force along x", low=-np.inf)
    y: float = parameter("rad/s/(m/s^2)", "error per specific force along y", low=-np.inf)
    z: float = parameter("rad/s/(m/s^2)", "error per specific force along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of a gyroscope."""
        if axis not in GYRO:
            raise ValueError(f"{self.name}: expected one of {', '.join(GYRO)}; found {axis}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sum of the components of the specific force, each times its sensitivity."""
        self.own_axis(conditions)
        return self.error_free(conditions, ACCEL) @ np.array([self.x, self.y, self.z])

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"channel": CHANNELS[ACCEL[0]], "x": self.x, "y": self.y, "z": self.z})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the components of the specific force."""
        self.own_axis(conditions)
        return dict(zip(("x", "y", "z"), self.error_free(conditions, ACCEL).T, strict=True))

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the sensitivities to the components that vary, where the specific force is known."""
        conditions, start = fit.sequence.conditions, cls(0.0, 0.0, 0.0)
        if conditions.axis not in GYRO or not conditions.knows(ACCEL) or fit.has(cls):
            return
        free = tuple(name for name, slope in start.slopes(conditions).items() if np.ptp(slope) > 0)
        if free:
            yield from start.proposed(fit, free)


def _step(own, x, now):
    drift = own.x * now.at(own.channel, 0) + own.y * now.at(own.channel + 1, 0) + own.z * now.at(own.channel + 2, 0)
    return x + drift
