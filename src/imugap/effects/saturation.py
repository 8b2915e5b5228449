"""Full scale of the output."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import TINY, Conditions, Effect, Stage, parameter


@dataclass(frozen=True)
class Saturation(Effect):
    """Output that goes no further than its full scale (IEEE 528: input limits)."""

    name: ClassVar[str] = "saturation"
    stage: ClassVar[Stage] = Stage.RANGE
    limit: float = parameter("{u}", "full scale, on both sides", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Clip to +-limit."""
        return np.clip(sequence, -self.limit, self.limit)
