"""Warm-up."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import TINY, AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class WarmUp(AdditiveEffect):
    """Exponential approach to the final bias, amplitude exp(-t/T) from power-on at t = 0."""

    name: ClassVar[str] = "warm_up"
    amplitude: float = parameter("{u}", "excess of the bias at power-on", low=-np.inf)
    time_constant: float = parameter("s", "T", low=TINY)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return amplitude exp(-t/T)."""
        return self.amplitude * np.exp(-conditions.time / self.time_constant)
