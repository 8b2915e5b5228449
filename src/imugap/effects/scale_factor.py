"""Scale factor errors."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import AdditiveEffect, Conditions, parameter


@dataclass(frozen=True)
class ScaleFactor(AdditiveEffect):
    """Error that depends on the input u of the own axis (IEEE 528: scale factor error, asymmetry, nonlinearity)."""

    name: ClassVar[str] = "scale_factor"
    error: float = parameter("1", "relative error of the scale factor", low=-np.inf)
    asymmetry: float = parameter("1", "half the scale factor of u > 0 less that of u < 0", low=-np.inf, default=0.0)
    nonlinearity: float = parameter("1/({u})", "error per square of the input", low=-np.inf, default=0.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return error u + asymmetry abs(u) + nonlinearity u^2."""
        u = conditions.input(self, [conditions.own_axis(self)])[:, 0]
        return self.error * u + self.asymmetry * np.abs(u) + self.nonlinearity * u**2
