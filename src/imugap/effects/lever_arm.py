"""Lever arm of an accelerometer."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class LeverArm(AdditiveEffect):
    """Accelerometer at r from the point whose specific force is meant: it senses w x (w x r) + dw/dt x r on top."""

    name: ClassVar[str] = "lever_arm"
    x: float = parameter("m", "r along x", low=-np.inf)
    y: float = parameter("m", "r along y", low=-np.inf)
    z: float = parameter("m", "r along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of an accelerometer."""
        if axis not in ACCEL:
            raise ValueError(f"{self.name}: expected one of {', '.join(ACCEL)}; found {axis}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the component along the own axis; dw/dt by central differences."""
        component = ACCEL.index(conditions.own_axis(self))
        arm = np.array([self.x, self.y, self.z])
        rate = conditions.input(self, GYRO)
        change = np.gradient(rate, conditions.time, axis=0)
        return (np.cross(rate, np.cross(rate, arm)) + np.cross(change, arm))[:, component]
