"""Vibration rectification."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.block import CHANNELS, Block, require_short
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
    memoryless: ClassVar[bool] = True
    coefficient: float = parameter("{u}/(m/s^2)^2", "shift per variance of the specific force", low=-np.inf)
    window: float = parameter("s", "length of the window of the variance", low=TINY, default=1.0)
    own: float = parameter(
        "1", "1: of the component along the own axis, 0: of all three", high=1.0, whole=True, default=0
    )

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the coefficient times the power; the window is truncated at the ends."""
        return self.coefficient * self.slopes(conditions)["coefficient"]

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step; its windows are centred, so that it needs the input ahead."""
        require_short(self.name, (self.window + STEADY) / interval)
        half, smooth = (round(length / 2 / interval) for length in (self.window, STEADY))
        smooth = smooth if self.window < STEADY else 0
        one = {"channel": CHANNELS[axis], "end": CHANNELS[axis] + 1}
        all_three = {"channel": CHANNELS[ACCEL[0]], "end": CHANNELS[ACCEL[-1]] + 1}
        values = {
            "coefficient": self.coefficient, **(one if self.own else all_three), "half": half, "smooth": smooth,
            "powers": np.full(2 * smooth + 1, -1.0), "slot": 0, "next": 0,
        }  # fmt: skip
        return Block(_step, values, past=half, ahead=half + smooth)

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
    """Return the odd number of samples of a window [s], at most such as covers all samples from any of them."""
    return 2 * min(round(window / 2 / conditions.interval), len(conditions)) + 1


def _step(own, x, now):
    for k in range(own.next, own.smooth + 1):
        power = -1.0
        if now.known(k):
            power = 0.0
            for channel in range(own.channel, own.end):
                count = 0.0
                mean = 0.0
                for j in range(k - own.half, k + own.half + 1):
                    if now.known(j):
                        count = count + 1.0
                        mean = mean + now.at(channel, j)
                mean = mean / count
                for j in range(k - own.half, k + own.half + 1):
                    if now.known(j):
                        power = power + (now.at(channel, j) - mean) * (now.at(channel, j) - mean) / count
        own.powers[own.slot] = power
        own.slot = own.slot + 1
        if own.slot == len(own.powers):
            own.slot = 0
    own.next = own.smooth
    total = 0.0
    known = 0.0
    for k in range(len(own.powers)):
        if own.powers[k] >= 0.0:
            total = total + own.powers[k]
            known = known + 1.0
    return x + own.coefficient * (total / known)
