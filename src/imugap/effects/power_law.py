"""Noise of any slope."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import gamma

from imugap.effects.block import Block
from imugap.effects.coloured_block import coloured_block, coloured_parts
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Start, StochasticEffect, Transform, parameter
from imugap.effects.residual import Residual
from imugap.numerics.spectra import allan_from_psd as spectrum

STEEPEST = 3.0
"""Smallest exponent with an infinite Allan variance (a trend)."""
ACCURACY = 1e-10
"""Relative error of an Allan variance."""


@dataclass(frozen=True)
class PowerLaw(StochasticEffect):
    """Noise of PSD density^2 |2 sin(pi f interval)/interval|^-exponent: fractionally integrated white noise.

    No name of the vocabulary: noise of any slope, which slow processes are weighed against, and which stands in a
    model for noise that fits no name. Of an exponent from one on it begins with its run, at zero.
    Source: Kasdin 1995, Proc. IEEE 83, 802-827.
    """

    name: ClassVar[str] = "power_law"
    named: ClassVar[bool] = False
    density: float = parameter("{u}/sqrt(Hz)*(rad/s)^(exponent/2)", "square root of the two-sided PSD at 1 rad/s")
    exponent: float = parameter("1", "exponent of 1/f", low=0.05, high=4.0)

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield nothing: the effect is not part of the vocabulary."""
        return iter(())

    @property
    def integrations(self) -> int:
        """Return the number of summations of stationary noise."""
        return int((self.exponent + 1) // 2)

    @property
    def is_trend(self) -> bool:
        """Return whether the Allan variance is infinite."""
        return self.exponent >= STEEPEST

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw stationary noise of this spectrum, or sums from zero of such noise; its covariance is exact.

        By circulant embedding (Davies and Harte 1987, Biometrika 74, 95-101).
        """
        count, sums = len(conditions), self.integrations
        white = self.density**2 * conditions.interval ** (self.exponent - 1)
        length = next_fast_len(2 * count, real=True)
        deviation = np.sqrt(white) * _deviation(self.exponent / 2 - sums, length)
        drawn = rng.standard_normal((2, len(deviation)))
        real = [0, -1] if length % 2 == 0 else [0]
        drawn[:, real] *= np.array([[np.sqrt(2)], [0.0]])
        values = irfft(deviation * np.sqrt(length / 2) * (drawn[0] + 1j * drawn[1]), length)[:count]
        for _ in range(sums):
            values = np.cumsum(np.r_[0.0, values[1:]])
        return values

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step. Power below 1e-7 of the rate is left out."""
        return coloured_block(self._std(interval), self.exponent / 2 - self.integrations, sums=self.integrations)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds such noise to one part of a run after the other, from other draws."""
        order = self.exponent / 2 - self.integrations
        return coloured_parts(run, rng, self._std(run.interval), order, sums=self.integrations)

    def _std(self, interval: float) -> float:
        """Return the standard deviation of the white noise that is integrated."""
        return self.density * interval ** ((self.exponent - 1) / 2)

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return density^2 |2 pi f|^-exponent."""
        return self.density**2 * (2 * np.pi * np.abs(np.asarray(frequency, float))) ** -self.exponent

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return the Allan variance of :meth:`psd`; infinite from an exponent of :data:`STEEPEST` on."""
        return self._bounded(
            np.asarray(tau, float), lambda tau: spectrum.allan_variance(self.psd, tau, accuracy=ACCURACY)
        )

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the PSD of the samples."""
        sine = np.sin(np.pi * np.asarray(frequency, float) * interval)
        return self.density**2 * (2 / interval * sine) ** -self.exponent

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the Allan variance of the samples; infinite from an exponent of :data:`STEEPEST` on."""
        psd = partial(self.sampled_psd, interval=interval)
        return self._bounded(
            interval * np.asarray(averaging), lambda tau: spectrum.allan_variance(psd, tau, interval, accuracy=ACCURACY)
        )

    def _bounded(self, tau: np.ndarray, variance: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        return variance(tau) if self.exponent < STEEPEST else np.full(tau.shape, np.inf)


@lru_cache(maxsize=1)
def _deviation(order: float, length: int) -> np.ndarray:
    """Return the square roots of the eigenvalues of the circulant covariance of fractionally integrated unit noise.

    The covariance at lag k is gamma_0 prod_j (j - 1 + d)/(j - d) (Hosking 1981, Biometrika 68, 165-176), d the
    ``order``.
    """
    lag = np.arange(1, length // 2 + 1)
    first = gamma(1 - 2 * order) / gamma(1 - order) ** 2
    half = first * np.cumprod(np.r_[1.0, (lag - 1 + order) / (lag - order)])
    circle = np.r_[half, half[1 : length - len(half) + 1][::-1]]
    return np.sqrt(np.maximum(rfft(circle).real, 0.0))
