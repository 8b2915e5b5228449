"""Misalignment of the input axis."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import CHANNELS, Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import triad


@dataclass(frozen=True)
class Misalignment(SystematicEffect):
    """Small angles of the input axis towards the other axes of its triad (IEEE 528: misalignment).

    The parameter of the own axis is zero.
    """

    name: ClassVar[str] = "misalignment"
    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    x: float = parameter("rad", "share of the input of the x axis", low=-np.inf, default=0.0)
    y: float = parameter("rad", "share of the input of the y axis", low=-np.inf, default=0.0)
    z: float = parameter("rad", "share of the input of the z axis", low=-np.inf, default=0.0)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError if ``axis`` is no sensor axis, or its own angle is not zero."""
        super().check_axis(axis)
        own = getattr(self, axis[-1])
        if own != 0:
            raise ValueError(f"{self.name}.{axis[-1]}: expected 0 on its own axis {axis}; found {own!r}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sum of the inputs of the other axes, each times its angle."""
        angles = dict(zip(triad(self.own_axis(conditions)), (self.x, self.y, self.z), strict=True))
        leaning = {axis: angle for axis, angle in angles.items() if angle}
        return self.error_free(conditions, list(leaning)) @ np.array(list(leaning.values()))

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"channel": CHANNELS[triad(axis)[0]], "x": self.x, "y": self.y, "z": self.z})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the known inputs of the other axes of the triad."""
        own = self.own_axis(conditions)
        others = [axis for axis in triad(own) if axis != own]
        others = [axis for axis in others if conditions.knows([axis])] or others
        return {axis[-1]: column for axis, column in zip(others, self.error_free(conditions, others).T, strict=True)}

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the angles to the axes with an input, where one is known."""
        conditions = fit.sequence.conditions
        if conditions.axis is None or fit.has(cls):
            return
        if not any(conditions.knows([axis]) for axis in triad(conditions.axis) if axis != conditions.axis):
            return
        free = tuple(name for name, slope in cls().slopes(conditions).items() if np.ptp(slope) > 0)
        if free:
            yield from cls().proposed(fit, free)


def _step(own, x, now):
    across = own.x * now.at(own.channel, 0) + own.y * now.at(own.channel + 1, 0) + own.z * now.at(own.channel + 2, 0)
    return x + across
