"""Flicker noise: bias instability."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfftfreq

from imugap.effects.effect import Conditions, StochasticEffect, parameter

FLOOR = np.sqrt(2 * np.log(2) / np.pi)
"""Allan deviation of flicker noise over B: 0.664 (IEEE 952)."""


@dataclass(frozen=True)
class BiasInstability(StochasticEffect):
    """Flicker noise: S(f) = B^2/(2 pi |f|), sigma(tau) = 0.664 B (IEEE 952, bias instability)."""

    name: ClassVar[str] = "bias_instability"
    density_b: float = parameter("{u}", "B")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw by spectral synthesis: independent Gaussian Fourier coefficients under the spectrum.

        The synthesis is four times longer than the run, so the run is not periodic and wanders on scales of its own
        length; power below 1/(4 duration), which a run cannot tell from its bias, is left out.
        """
        count = len(conditions)
        length = next_fast_len(4 * count, real=True)
        frequency = rfftfreq(length, conditions.interval)[1:]
        scale = np.sqrt(self.psd(frequency) * length / conditions.interval / 2)
        spectrum = np.zeros(len(frequency) + 1, complex)
        spectrum.real[1:] = scale * rng.standard_normal(len(frequency))
        spectrum.imag[1:] = scale * rng.standard_normal(len(frequency))
        return irfft(spectrum, length)[:count]

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return B^2/(2 pi |f|) (Farrell et al. 2022, eq. 18)."""
        return self.density_b**2 / (2 * np.pi * np.abs(np.asarray(frequency, float)))

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return 2 ln 2/pi B^2, whatever tau (IEEE 952)."""
        return np.full_like(np.asarray(tau, float), (FLOOR * self.density_b) ** 2)
