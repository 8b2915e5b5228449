"""Repeated values."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import Conditions, Effect, Stage, parameter
from imugap.stretch import stretches


@dataclass(frozen=True)
class StuckSamples(Effect):
    """Output that repeats its last value for a stretch of samples (:func:`imugap.stretch.stretches`)."""

    name: ClassVar[str] = "stuck_samples"
    stage: ClassVar[Stage] = Stage.TRANSFER
    probability: float = parameter("1", "probability that a stretch begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of repeats of a value", low=1.0)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Put the last value that was not in a stretch in place of those that are."""
        stuck = stretches(len(sequence), self.probability, self.length, rng)
        return sequence[np.maximum.accumulate(np.where(stuck, 0, np.arange(len(sequence))))]
