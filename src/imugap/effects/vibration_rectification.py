"""Vibration rectification."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd

from imugap.effects.effect import Conditions, Start, SystematicEffect, parameter
from imugap.log import ACCEL

if TYPE_CHECKING:
    from imugap.discovery.axis import AxisFit

WINDOW = 1.0
"""Length of the window of the running variance [s]."""


@dataclass(frozen=True)
class VibrationRectification(SystematicEffect):
    """Shift of the bias by vibration, proportional to its power (IEEE 1293: vibration rectification error)."""

    name: ClassVar[str] = "vibration_rectification"
    coefficient: float = parameter("{u}/(m/s^2)^2", "shift per variance of the specific force", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the coefficient times the variance of the specific force in a window around the sample.

        It is the sum of the variances of the three components; at the ends the window is what there is of it.
        """
        return self.coefficient * self.slopes(conditions)["coefficient"]

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the variance of the specific force."""
        return {"coefficient": conditions.once(_power)}

    @classmethod
    def starts(cls, fit: "AxisFit") -> Iterator[Start]:
        """Yield the coefficient, where the specific force is known and its variance varies."""
        if fit.sequence.conditions.knows(ACCEL) and not fit.has(cls):
            yield from cls(0.0).proposed(fit, ("coefficient",))


def _power(conditions: Conditions) -> np.ndarray:
    """Return the variance of the specific force in a window around each sample, summed over its components."""
    force = pd.DataFrame(conditions.input(VibrationRectification, ACCEL))
    length = 2 * round(WINDOW / 2 / conditions.interval) + 1
    return force.rolling(length, center=True, min_periods=1).var(ddof=0).sum(axis=1).to_numpy()
