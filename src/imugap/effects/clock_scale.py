"""Rate error of the clock."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.block import Block
from imugap.effects.effect import TINY, ClockEffect, Evidence, parameter
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.chi_square import log_tail


@dataclass(frozen=True)
class ClockScale(ClockEffect):
    """Clock that runs at ``ratio`` times the right rate: stamps are multiplied by it."""

    name: ClassVar[str] = "clock_scale"
    memoryless: ClassVar[bool] = True
    ratio: float = parameter("1", "stamped over true time", low=TINY)

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the log with scaled stamps."""
        return log.set_axis(log.index * self.ratio)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"ratio": self.ratio})

    @classmethod
    def between(cls, log_interval: float, std: float) -> Evidence:
        """Return the estimate from two runs: logarithm of the true over the stamped interval, and its deviation."""
        ratio, *ends = (float(np.exp(-log_interval + side * NORMAL_QUANTILE * std)) for side in (0, -1, 1))
        log_p = log_tail((log_interval / std) ** 2, 1)
        return Evidence(cls(ratio), {"ratio": tuple(ends)}, log_p, np.zeros(0, bool))


def _step(own, x, now):
    return x * own.ratio
