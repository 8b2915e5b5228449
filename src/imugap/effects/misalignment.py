"""Misalignment of the input axis."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.cross_axis import CrossAxisEffect
from imugap.effects.effect import parameter
from imugap.log import triad


@dataclass(frozen=True)
class Misalignment(CrossAxisEffect):
    """Small angles of the input axis towards the other axes of its triad (IEEE 528: misalignment).

    The parameter of the own axis is zero.
    """

    name: ClassVar[str] = "misalignment"
    x: float = parameter("rad", "share of the input of the x axis", low=-np.inf, default=0.0)
    y: float = parameter("rad", "share of the input of the y axis", low=-np.inf, default=0.0)
    z: float = parameter("rad", "share of the input of the z axis", low=-np.inf, default=0.0)

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError if ``axis`` is no sensor axis, or its own angle is not zero."""
        super().check_axis(axis)
        own = getattr(self, axis[-1])
        if own != 0:
            raise ValueError(f"{self.name}.{axis[-1]}: expected 0 on its own axis {axis}; found {own!r}")

    @classmethod
    def inputs(cls, axis: str) -> tuple[str, ...]:
        """Return the other axes of the triad."""
        return tuple(one for one in triad(axis) if one != axis)
