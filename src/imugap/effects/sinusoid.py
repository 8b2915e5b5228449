"""Spectral line."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import diric

from imugap.effects.effect import TINY, AllanEffect, Conditions, parameter


@dataclass(frozen=True)
class Sinusoid(AllanEffect):
    """Sinusoid amplitude cos(2 pi f t + phase) (IEEE 952, sinusoidal noise).

    Its Allan variance is the mean over a random phase; a run that is long against the period has it, whatever its
    phase.
    """

    name: ClassVar[str] = "sinusoid"
    frequency: float = parameter("Hz", "f", low=TINY)
    amplitude: float = parameter("{u}", "amplitude")
    phase: float = parameter("rad", "phase at power-on", low=-np.inf, default=0.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sinusoid at the sample times."""
        return self.amplitude * np.cos(2 * np.pi * self.frequency * conditions.time + self.phase)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return amplitude^2 sin^4(pi f tau)/(pi f tau)^2 (IEEE 952)."""
        turns = self.frequency * np.asarray(tau, float)
        return (self.amplitude * np.sin(np.pi * turns) * np.sinc(turns)) ** 2

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return amplitude^2 sin^4(n u)/(n sin u)^2, u = pi f interval: means of n samples in place of integrals."""
        n, u = np.asarray(averaging), np.pi * self.frequency * interval
        return (self.amplitude * np.sin(n * u) * diric(2 * u, n)) ** 2
