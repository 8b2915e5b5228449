"""Resolution of the output word."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import TINY, Conditions, Effect, Stage, parameter


@dataclass(frozen=True)
class Resolution(Effect):
    """Output rounded to a lattice of values (least significant bit of the output word)."""

    name: ClassVar[str] = "resolution"
    stage: ClassVar[Stage] = Stage.WORD
    step: float = parameter("{u}", "distance of neighbouring output values", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Round to the nearest multiple of the step."""
        return np.rint(sequence / self.step) * self.step
