"""Misalignment of the input axis."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from imugap.effects.effect import Conditions, Start, SystematicEffect, parameter
from imugap.log import triad

if TYPE_CHECKING:
    from imugap.discovery.axis import AxisFit


@dataclass(frozen=True)
class Misalignment(SystematicEffect):
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

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the inputs of the other axes of the triad, of those that are known."""
        own = conditions.own_axis(self)
        others = [axis for axis in triad(own) if axis != own]
        others = [axis for axis in others if conditions.knows([axis])] or others
        return {axis[-1]: column for axis, column in zip(others, conditions.input(self, others).T, strict=True)}

    @classmethod
    def starts(cls, fit: "AxisFit") -> Iterator[Start]:
        """Yield the angles to the axes with an input, where one is known."""
        conditions = fit.sequence.conditions
        if conditions.axis is None or fit.has(cls):
            return
        if not any(conditions.knows([axis]) for axis in triad(conditions.axis) if axis != conditions.axis):
            return
        free = tuple(name for name, slope in cls().slopes(conditions).items() if np.ptp(slope) > 0)
        if free:
            yield from cls().proposed(fit, free)
