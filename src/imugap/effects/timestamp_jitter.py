"""Jitter of the time stamps."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.effect import ClockEffect, parameter


@dataclass(frozen=True)
class TimestampJitter(ClockEffect):
    """Stamps displaced independently by N(0, std^2); the samples themselves are taken at the right time.

    Where displaced stamps would change places they are put in order again, so a log stays a log.
    """

    name: ClassVar[str] = "timestamp_jitter"
    std: float = parameter("s", "standard deviation of the displacement")

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the log with displaced, strictly increasing stamps."""
        stamps = np.sort(log.index.to_numpy() + self.std * rng.standard_normal(len(log)))
        for row in np.flatnonzero(np.diff(stamps) <= 0) + 1:
            stamps[row] = np.nextafter(stamps[row - 1], np.inf)
        return log.set_axis(pd.Index(stamps, name=log.index.name))
