"""Lever arm of an accelerometer."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class LeverArm(SystematicEffect):
    """Accelerometer at r from the reference point: it also senses w x (w x r) + dw/dt x r."""

    name: ClassVar[str] = "lever_arm"
    of_motion: ClassVar[bool] = True
    common: ClassVar[tuple[str, ...]] = ACCEL
    x: float = parameter("m", "r along x", low=-np.inf)
    y: float = parameter("m", "r along y", low=-np.inf)
    z: float = parameter("m", "r along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of an accelerometer."""
        if axis not in ACCEL:
            raise ValueError(f"{self.name}: expected one of {', '.join(ACCEL)}; found {axis}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the component along the own axis; dw/dt is that of :mod:`imugap.numerics.band_limited`."""
        slopes = self.slopes(conditions)
        return self.x * slopes["x"] + self.y * slopes["y"] + self.z * slopes["z"]

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivatives in the components of the arm."""
        component = ACCEL.index(self.own_axis(conditions))
        return dict(zip(("x", "y", "z"), conditions.once(_fields)[:, :, component], strict=True))

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the arm, where the angular rate is known and its components are separately observable."""
        conditions = fit.sequence.conditions
        if conditions.axis in ACCEL and conditions.knows(GYRO) and not fit.has(cls):
            yield from cls(0.0, 0.0, 0.0).proposed(fit, ("x", "y", "z"))


def _fields(conditions: Conditions) -> np.ndarray:
    """Return the specific force that arms of one metre along x, y and z add, shape (3 arms, n, 3 components)."""
    rate = LeverArm.error_free(conditions, GYRO)
    change = LeverArm.interpolated(conditions, GYRO)(conditions.time, 1)
    return np.array([np.cross(rate, np.cross(rate, arm)) + np.cross(change, arm) for arm in np.eye(3)])
