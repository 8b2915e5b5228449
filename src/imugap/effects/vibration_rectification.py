"""Vibration rectification."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import ACCEL

WINDOWS = (0.03, 0.1, 0.3, 1.0, 3.0)
"""Lengths of the window of the running variance of a search [s]."""
STEADY = 1.0
"""Time over which the variance of a shorter window is averaged [s]."""
SHORTEST = 3
"""Fewest samples of a window."""


@dataclass(frozen=True)
class VibrationRectification(SystematicEffect):
    """Shift of the bias by vibration, proportional to its power (IEEE 1293: vibration rectification error).

    The power is the variance of the specific force within a window around the sample, the sum of its three components
    or of that along the own axis alone; that of a window below a second is averaged over a second. What is slower than
    the window is motion, and no vibration.
    """

    name: ClassVar[str] = "vibration_rectification"
    of_motion: ClassVar[bool] = True
    coefficient: float = parameter("{u}/(m/s^2)^2", "shift per variance of the specific force", low=-np.inf)
    window: float = parameter("s", "length of the window of the variance", low=TINY, default=1.0)
    own: float = parameter(
        "1", "1: of the component along the own axis, 0: of all three", high=1.0, whole=True, default=0
    )

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the coefficient times the power; the window is truncated at the ends."""
        return self.coefficient * self.slopes(conditions)["coefficient"]

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the power."""
        return {"coefficient": conditions.once(_Power(self.window, bool(self.own)))}

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the start of the largest expected gain, where the specific force is known and its variance varies."""
        conditions = fit.sequence.conditions
        if not conditions.knows(ACCEL) or fit.has(cls):
            return
        windows = [window for window in WINDOWS if window > (SHORTEST - 1) * conditions.interval]
        ways = [cls(0.0, window, own) for own in (0, 1) for window in windows or WINDOWS[-1:]]
        powers = np.column_stack([way.slopes(conditions)["coefficient"] for way in ways])
        best = ways[int(np.argmax(fit.gains(fit.whiten(powers))))]
        yield from best.proposed(fit, ("coefficient",), len(ways))


@dataclass(frozen=True)
class _Power:
    """Variance of the specific force in a window around each sample."""

    window: float
    own: bool

    def __call__(self, conditions: Conditions) -> np.ndarray:
        force = pd.DataFrame(VibrationRectification.error_free(conditions, ACCEL))
        asked = force.iloc[:, ["xyz".index(conditions.axis[-1])] if self.own else [0, 1, 2]]
        around = {"center": True, "min_periods": 1}
        power = asked.rolling(_length(self.window, conditions), **around).var(ddof=0).sum(axis=1)
        if self.window < STEADY:
            power = power.rolling(_length(STEADY, conditions), **around).mean()
        return power.to_numpy()


def _length(window: float, conditions: Conditions) -> int:
    """Return the odd number of samples of a window [s]."""
    return 2 * round(window / 2 / conditions.interval) + 1
