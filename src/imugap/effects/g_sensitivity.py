"""Sensitivity of a gyroscope to specific force."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.cross_axis import CrossAxisEffect
from imugap.effects.effect import parameter
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class GSensitivity(CrossAxisEffect):
    """Rate error proportional to the specific force (IEEE 528: acceleration-sensitive drift rate)."""

    name: ClassVar[str] = "g_sensitivity"
    title: ClassVar[str] = "g-sensitivity"
    x: float = parameter("rad/s/(m/s^2)", "error per specific force along x", low=-np.inf)
    y: float = parameter("rad/s/(m/s^2)", "error per specific force along y", low=-np.inf)
    z: float = parameter("rad/s/(m/s^2)", "error per specific force along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of a gyroscope."""
        if axis not in GYRO:
            raise ValueError(f"{self.name}: expected one of {', '.join(GYRO)}; found {axis}")

    @classmethod
    def inputs(cls, axis: str) -> tuple[str, ...]:
        """Return the accelerometers, for a gyroscope."""
        return ACCEL if axis in GYRO else ()
