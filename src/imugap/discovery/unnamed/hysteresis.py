"""Hysteresis: a mean that depends on the temperature and on its history.

No effect of the catalogue has hysteresis. A loop over the temperature imitates slow noise, or a warm-up with a
temperature term. The play operator, the element of Preisach's model (Visintin, Differential Models of Hysteresis, 1994,
ch. III), follows the temperature at a distance of half its width. With the temperature itself it approximates a loop of
any width well enough to distinguish it from these.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter

HALF_WIDTHS = 0.03, 0.06, 0.1, 0.15, 0.22, 0.33
"""Half-widths of the play [ranges of the temperature]."""


@dataclass(frozen=True)
class Hysteresis(SystematicEffect):
    """Bias = coefficient T + play_coefficient P: T the temperature, P its play of half-width ``half_width``.

    ``half_width`` is one of :data:`HALF_WIDTHS`.
    """

    name: ClassVar[str] = "hysteresis"
    coefficient: float = parameter("{u}/degC", "change of the bias per degree", low=-np.inf)
    play_coefficient: float = parameter("{u}/degC", "change of the bias per degree of the play", low=-np.inf)
    half_width: float = parameter("1", "half-width of the play over the range of the temperature", high=0.5)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the bias at every sample."""
        slopes = self.slopes(conditions)
        return self.coefficient * slopes["coefficient"] + self.play_coefficient * slopes["play_coefficient"]

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the temperature and its play, each less its mean, by the name of the parameter."""
        linear, *follower = conditions.once(_temperature_and_plays).T
        return {"coefficient": linear, "play_coefficient": follower[HALF_WIDTHS.index(self.half_width)]}

    @classmethod
    def starts(cls, fit: AxisFit) -> Iterator[Start]:
        """Yield the hysteresis of the half-width of largest gain, where the temperature is known and varies."""
        temperature = fit.sequence.conditions.temperature
        if temperature is None or np.ptp(temperature) == 0:
            return
        linear, *follower = fit.whiten(fit.sequence.conditions.once(_temperature_and_plays)).T
        gains = [fit.joint_gain(np.column_stack([linear, one]))[0] for one in follower]
        yield Start(
            cls(0.0, 0.0, HALF_WIDTHS[int(np.argmax(gains))]),
            ("coefficient", "play_coefficient"),
            trials=len(HALF_WIDTHS),
        )


def _temperature_and_plays(conditions: Conditions) -> np.ndarray:
    """Return the temperature and its plays, each less its mean, shape (n, 1 + plays)."""
    temperature = np.ascontiguousarray(conditions.temperature, dtype=float)
    plays = [play(temperature, half_width * np.ptp(temperature)) for half_width in HALF_WIDTHS]
    columns = np.column_stack([temperature, *plays])
    return columns - columns.mean(axis=0)


@njit(cache=True)
def play(values, half_width):
    """Apply the play operator of half-width ``half_width`` to ``values``, shape (n,)."""
    follower, at = np.empty(len(values)), values[0]
    for row in range(len(values)):
        at = min(max(at, values[row] - half_width), values[row] + half_width)
        follower[row] = at
    return follower
