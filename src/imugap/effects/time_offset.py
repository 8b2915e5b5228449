"""Delay of an axis."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from imugap.effects.effect import AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class TimeOffset(AdditiveEffect):
    """Input u that arrives late by an offset: u(t - offset) - u(t)."""

    name: ClassVar[str] = "time_offset"
    offset: float = parameter("s", "delay of the input", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Interpolate by a cubic spline; before the first and after the last sample the input is held."""
        u, time = conditions.input(self, [conditions.own_axis(self)])[:, 0], conditions.time
        return CubicSpline(time, u)(np.clip(time - self.offset, time[0], time[-1])) - u
