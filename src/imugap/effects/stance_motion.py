"""Motion of the foot at stance."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.conditions import Conditions
from imugap.effects.effect import Effect, Stage, parameter


@dataclass(frozen=True)
class StanceMotion(Effect):
    """Residual velocity of the foot at stance, N(bias, std^2).

    It is an error of the zero-velocity measurements of a filter, and does not change a log.
    """

    name: ClassVar[str] = "stance_motion"
    stage: ClassVar[Stage] = Stage.STANCE
    memoryless: ClassVar[bool] = True
    std: float = parameter("m/s", "standard deviation of the velocity at stance")
    bias: float = parameter("m/s", "mean velocity at stance", low=-np.inf)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the output unchanged."""
        return sequence
