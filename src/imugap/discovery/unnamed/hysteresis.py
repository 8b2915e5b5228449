"""Hysteresis: a mean that depends on the temperature and on where it came from.

No effect of the catalogue has a memory of the temperature. A loop over it wanders over a log like slow noise, or like a
warm-up beside a temperature, and as such it would be named. The play operator, the element of which Preisach's loops
are made (Visintin, Differential Models of Hysteresis, 1994, ch. III), follows the temperature by half its width: with
it and the temperature itself a loop of any breadth is described well enough to tell it from these.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter

HALVES = 0.03, 0.06, 0.1, 0.15, 0.22, 0.33
"""Halves of the widths, in ranges of the temperature."""


@dataclass(frozen=True)
class Hysteresis(SystematicEffect):
    """Bias = coefficient T + memory P: T the temperature, P what it drags along with a play of twice ``half``.

    ``half`` is one of :data:`HALVES`.
    """

    name: ClassVar[str] = "hysteresis"
    coefficient: float = parameter("{u}/degC", "change of the bias per degree", low=-np.inf)
    memory: float = parameter("{u}/degC", "change of the bias per degree dragged along", low=-np.inf)
    half: float = parameter("1", "half of the play over the range of the temperature", high=0.5)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the bias at every sample."""
        slopes = self.slopes(conditions)
        return self.coefficient * slopes["coefficient"] + self.memory * slopes["memory"]

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the temperature and what it drags along, each less its mean."""
        straight, *dragged = conditions.once(_columns).T
        return {"coefficient": straight, "memory": dragged[HALVES.index(self.half)]}

    @classmethod
    def starts(cls, fit: AxisFit) -> Iterator[Start]:
        """Yield the loop of the width that gains most, where the temperature is known and varies."""
        temperature = fit.sequence.conditions.temperature
        if temperature is None or np.ptp(temperature) == 0:
            return
        straight, *dragged = fit.whiten(fit.sequence.conditions.once(_columns)).T
        gains = [fit.joint_gain(np.column_stack([straight, one]))[0] for one in dragged]
        yield Start(cls(0.0, 0.0, HALVES[int(np.argmax(gains))]), ("coefficient", "memory"), trials=len(HALVES))


def _columns(conditions: Conditions) -> np.ndarray:
    """Return the temperature and what each play makes of it, each less its mean, shape (n, 1 + plays)."""
    temperature = np.ascontiguousarray(conditions.temperature, dtype=float)
    plays = [play(temperature, half * np.ptp(temperature)) for half in HALVES]
    columns = np.column_stack([temperature, *plays])
    return columns - columns.mean(axis=0)


@njit(cache=True)
def play(values, half):
    """Return what a pointer shows that ``values``, shape (n,), drag along with a play of twice ``half``."""
    dragged, at = np.empty(len(values)), values[0]
    for row in range(len(values)):
        at = min(max(at, values[row] - half), values[row] + half)
        dragged[row] = at
    return dragged
