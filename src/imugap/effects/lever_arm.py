"""Lever arm of an accelerometer."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import CHANNELS, Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import ACCEL, GYRO
from imugap.numerics.spectra.band_limited import weights


@dataclass(frozen=True)
class LeverArm(SystematicEffect):
    """Accelerometer at r from the reference point: it also senses w x (w x r) + dw/dt x r."""

    name: ClassVar[str] = "lever_arm"
    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    common: ClassVar[tuple[str, ...]] = ACCEL
    x: float = parameter("m", "r along x", low=-np.inf)
    y: float = parameter("m", "r along y", low=-np.inf)
    z: float = parameter("m", "r along z", low=-np.inf)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is one of an accelerometer."""
        if axis not in ACCEL:
            raise ValueError(f"{self.name}: expected one of {', '.join(ACCEL)}; found {axis}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the component along the own axis; dw/dt is that of :mod:`imugap.numerics.spectra.band_limited`."""
        slopes = self.slopes(conditions)
        return self.x * slopes["x"] + self.y * slopes["y"] + self.z * slopes["z"]

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step; the slope of the angular rate needs the input ahead."""
        first, shares = weights(0.0, slope=True)
        own, second, third = (np.arange(3) + ACCEL.index(axis)) % 3
        arm = np.array([self.x, self.y, self.z])
        values = {
            "own": CHANNELS[GYRO[own]], "second": CHANNELS[GYRO[second]], "third": CHANNELS[GYRO[third]],
            "along": arm[own], "across": arm[second], "beyond": arm[third],
            "first": first, "slopes": np.array(shares) / interval,
        }  # fmt: skip
        return Block(_step, values, past=-first, ahead=first + len(shares) - 1)

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


def _step(own, x, now):
    u = now.at(own.own, 0)
    v = now.at(own.second, 0)
    w = now.at(own.third, 0)
    turning = v * (u * own.across - v * own.along) - w * (w * own.along - u * own.beyond)
    second = 0.0
    third = 0.0
    for k in range(len(own.slopes)):
        second = second + own.slopes[k] * now.at(own.second, own.first + k)
        third = third + own.slopes[k] * now.at(own.third, own.first + k)
    return x + (turning + (second * own.beyond - third * own.across))
