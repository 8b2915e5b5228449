"""Sensitivity of a gyroscope to specific force."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class GSensitivity(AdditiveEffect):
    """Rate error proportional to the specific force (IEEE 528: acceleration-sensitive drift rate)."""

    name: ClassVar[str] = "g_sensitivity"
    x: float = parameter("rad/s/(m/s^2)", "error per specific force along x", low=-np.inf)
    y: float = parameter("rad/s/(m/s^2)", "error per specific force along y", low=-np.inf)
    z: float = parameter("rad/s/(m/s^2)", "error per specific force along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of a gyroscope."""
        if axis not in GYRO:
            raise ValueError(f"{self.name}: expected one of {', '.join(GYRO)}; found {axis}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sum of the components of the specific force, each times its sensitivity."""
        conditions.own_axis(self)
        return conditions.input(self, ACCEL) @ np.array([self.x, self.y, self.z])
