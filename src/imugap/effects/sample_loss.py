"""Lost samples."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.effects.effect import ClockEffect, parameter
from imugap.stretch import stretches


@dataclass(frozen=True)
class SampleLoss(ClockEffect):
    """Gaps: rows are missing, the stamps of the others are right (:func:`imugap.stretch.stretches`)."""

    name: ClassVar[str] = "sample_loss"
    probability: float = parameter("1", "probability that a gap begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of lost samples of a gap", low=1.0)

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the rows that are not lost; the first is never, and a single one is no log."""
        kept = log[~stretches(len(log), self.probability, self.length, rng)]
        if len(kept) < 2:
            raise ValueError(f"{self.name}: expected at least 2 samples that are left; found {len(kept)}")
        return kept
