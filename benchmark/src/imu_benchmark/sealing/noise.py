"""Noise of a base device, without the effect classes: independent draws, sums, fractional differencing, rounding.

Densities are square roots of two-sided power spectral densities, as in the docstring of the library.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

LEAD = 3
"""Time before the log, in lengths of the log, from which long-memory noise is generated."""


@dataclass(frozen=True)
class BaseNoise:
    """Noise of one axis: white ``density`` N, flicker ``density_b`` B, walk ``density_k`` K, quantization ``q``.

    ``amplitude`` and ``frequency`` [Hz] are those of a line, if any.
    """

    density: float = 0.0
    density_b: float = 0.0
    density_k: float = 0.0
    q: float = 0.0
    amplitude: float = 0.0
    frequency: float = 0.0

    def white(self, count: int, interval: float, rng: np.random.Generator) -> np.ndarray:
        """Draw the white part, shape (count,): interval means of standard deviation N/sqrt(interval)."""
        return self.density / np.sqrt(interval) * rng.standard_normal(count)

    def coloured(self, count: int, interval: float, rng: np.random.Generator) -> np.ndarray:
        """Draw flicker, walk and quantization noise, shape (count,)."""
        parts = (
            (self.density_b, lambda: fractional(count, 1.0, rng)),
            (self.density_k * np.sqrt(interval), lambda: summed(count, rng)),
            (self.q / interval, lambda: rounded(count, rng)),
        )
        return sum((scale * draw() for scale, draw in parts if scale > 0), np.zeros(count))

    def line(self, time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw a phase and return the line at the instants ``time`` [s]."""
        return self.amplitude * np.sin(2 * np.pi * (self.frequency * time + rng.uniform()))

    def mode_variance(self, count: int, interval: float) -> np.ndarray:
        """Return the variance [unit^2] of the orthonormal cosine coefficients 1 to count - 1 of ``count`` samples.

        Coefficient k belongs to the frequency k/(2 count interval); its variance is the power spectral density there
        over the interval. The rounding error of an integral leaks 4 q^2/count from the two ends of the log.
        """
        gain = 4 * np.sin(np.pi * modes(count, interval) * interval) ** 2
        flicker, walk = self.density_b**2 / np.sqrt(gain), self.density_k**2 * interval / gain
        return self.density**2 / interval + flicker + walk + (self.q / interval) ** 2 * (gain + 4 / count)


def modes(count: int, interval: float) -> np.ndarray:
    """Return the frequencies [Hz] of the cosine coefficients 1 to count - 1 of ``count`` samples."""
    return np.arange(1, count) / (2 * count * interval)


def fractional(count: int, exponent: float, rng: np.random.Generator) -> np.ndarray:
    """Draw noise of two-sided density interval |2 sin(pi f interval)|^-exponent by fractional differencing.

    Kasdin and Walter (1992), Discrete simulation of power law noise: white noise of unit variance filtered with
    h_0 = 1, h_k = h_(k-1) (k - 1 + exponent/2)/k. The noise begins :data:`LEAD` lengths before the log.
    """
    total = (LEAD + 1) * count
    k = np.arange(1, total)
    weights = np.r_[1.0, np.cumprod((k - 1 + exponent / 2) / k)]
    length = next_fast_len(2 * total, real=True)
    drawn = rfft(rng.standard_normal(total), length) * rfft(weights, length)
    return irfft(drawn, length)[total - count : total]


def summed(count: int, rng: np.random.Generator) -> np.ndarray:
    """Draw the sums of independent unit increments, zero at the first sample."""
    return np.r_[0.0, np.cumsum(rng.standard_normal(count - 1))]


def rounded(count: int, rng: np.random.Generator) -> np.ndarray:
    """Draw differences of the unit-variance errors of rounding the integral of a large random signal."""
    path = np.cumsum(rng.normal(scale=20.0, size=count + 1))
    return np.diff((np.rint(path) - path) * np.sqrt(12))
