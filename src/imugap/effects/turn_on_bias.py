"""Bias that differs from power-on to power-on."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.conditions import Conditions
from imugap.effects.effect import AdditiveEffect, parameter


@dataclass(frozen=True)
class TurnOnBias(AdditiveEffect):
    """A bias drawn once per run from N(0, std^2) (IEEE 952: turn-on repeatability; He et al. 2023, eq. 14)."""

    name: ClassVar[str] = "turn_on_bias"
    std: float = parameter("{u}", "standard deviation over runs")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw one offset and hold it for the run."""
        return np.full(len(conditions), self.std * rng.standard_normal())
