"""Sensitivity of the bias to temperature."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class Temperature(AdditiveEffect):
    """Bias proportional to the temperature's distance from a reference (IEEE 1554: bias temperature sensitivity)."""

    name: ClassVar[str] = "temperature"
    coefficient: float = parameter("{u}/degC", "change of the bias per degree", low=-np.inf)
    reference: float = parameter("degC", "temperature at which the effect is zero", low=-273.15, default=25.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return coefficient x (temperature - reference)."""
        if conditions.temperature is None:
            raise ValueError("temperature: expected conditions with a temperature; found none")
        return self.coefficient * (conditions.temperature - self.reference)
