"""Misalignment of the input axis."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter
from imugap.log import triad


@dataclass(frozen=True)
class Misalignment(AdditiveEffect):
    """Small angles by which the input axis leans to the other axes of its triad (IEEE 528: misalignment).

    The parameter of the own axis is zero.
    """

    name: ClassVar[str] = "misalignment"
    x: float = parameter("rad", "share of the input of the x axis", low=-np.inf, default=0.0)
    y: float = parameter("rad", "share of the input of the y axis", low=-np.inf, default=0.0)
    z: float = parameter("rad", "share of the input of the z axis", low=-np.inf, default=0.0)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError if ``axis`` is no sensor axis or leans to itself."""
        super().check_axis(axis)
        own = getattr(self, axis[-1])
        if own != 0:
            raise ValueError(f"{self.name}.{axis[-1]}: expected 0 on its own axis {axis}; found {own!r}")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sum of the inputs of the other axes, each times its angle."""
        angles = dict(zip(triad(conditions.own_axis(self)), (self.x, self.y, self.z), strict=True))
        leaning = {axis: angle for axis, angle in angles.items() if angle}
        return conditions.input(self, list(leaning)) @ np.array(list(leaning.values()))
