"""Noise of any slope: no effect of the catalogue, but what its slow processes are weighed against."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import StochasticEffect, parameter


@dataclass(frozen=True)
class PowerLaw(StochasticEffect):
    """Noise of PSD density^2 |2 sin(pi f interval)/interval|^-exponent: fractionally integrated white noise.

    Source: Kasdin 1995, Proc. IEEE 83, 802-827.
    """

    name: ClassVar[str] = "power_law"
    density: float = parameter("1", "size at 1 rad/s")
    exponent: float = parameter("1", "exponent of 1/f", low=0.05, high=4.0)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the PSD of the samples."""
        return self.density**2 * (2 / interval * np.sin(np.pi * frequency * interval)) ** -self.exponent
