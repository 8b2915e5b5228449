"""Rate error of the clock."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.effect import TINY, ClockEffect, parameter


@dataclass(frozen=True)
class ClockScale(ClockEffect):
    """Clock that runs at ``ratio`` times the right rate: stamps are multiplied by it."""

    name: ClassVar[str] = "clock_scale"
    ratio: float = parameter("1", "stamped over true time", low=TINY)

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the log with scaled stamps."""
        return log.set_axis(log.index * self.ratio)
