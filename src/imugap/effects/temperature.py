"""Sensitivity of the bias to temperature."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class Temperature(AdditiveEffect):
    """Bias that follows the temperature's distance d from a reference (IEEE 1554: bias temperature sensitivity).

    Bias = coefficient d + quadratic d^2 + rate dT/dt.
    """

    name: ClassVar[str] = "temperature"
    coefficient: float = parameter("{u}/degC", "change of the bias per degree", low=-np.inf)
    reference: float = parameter("degC", "temperature at which the static effect is zero", low=-273.15, default=25.0)
    quadratic: float = parameter("{u}/degC^2", "curvature of the bias over temperature", low=-np.inf, default=0.0)
    rate: float = parameter("{u}*s/degC", "bias per rate of change of the temperature", low=-np.inf, default=0.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the bias at every sample; dT/dt by central differences."""
        if conditions.temperature is None:
            raise ValueError("temperature: expected conditions with a temperature; found none")
        distance = conditions.temperature - self.reference
        static = self.coefficient * distance + self.quadratic * distance**2
        if self.rate == 0:
            return static
        return static + self.rate * np.gradient(conditions.temperature, conditions.time)
