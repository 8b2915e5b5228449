"""Vibration rectification."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.effect import AdditiveEffect, Conditions, parameter
from imugap.log import ACCEL

WINDOW = 1.0
"""Length of the window of the running variance [s]."""


@dataclass(frozen=True)
class VibrationRectification(AdditiveEffect):
    """Shift of the bias by vibration, proportional to its power (IEEE 1293: vibration rectification error)."""

    name: ClassVar[str] = "vibration_rectification"
    coefficient: float = parameter("{u}/(m/s^2)^2", "shift per variance of the specific force", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the coefficient times the variance of the specific force in a window around the sample.

        It is the sum of the variances of the three components; at the ends the window is what there is of it.
        """
        force = pd.DataFrame(conditions.input(self, ACCEL))
        length = 2 * round(WINDOW / 2 / conditions.interval) + 1
        power = force.rolling(length, center=True, min_periods=1).var(ddof=0).sum(axis=1)
        return self.coefficient * power.to_numpy()
