"""Step of the bias."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class BiasStep(AdditiveEffect):
    """A bias that is there from a certain time on."""

    name: ClassVar[str] = "bias_step"
    time: float = parameter("s", "time of the step since power-on")
    step: float = parameter("{u}", "change of the bias", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return zero before the step and the step from its time on."""
        return np.where(conditions.time >= self.time, self.step, 0.0)
