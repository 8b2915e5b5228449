"""Noise of a flat spectrum within a band: the bricks of a spectrum that has no name."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.special import sici

from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Start, StochasticEffect, Transform, parameter
from imugap.effects.residual import Residual

SMALL = 0.01
"""Argument up to which a series gives the integral of the transfer function to rounding."""
PERIODS = 64
"""Length of a segment of a run in parts, in inverse widths of the band."""


@dataclass(frozen=True)
class BandNoise(StochasticEffect):
    """Normal noise of PSD density^2 for frequency - width/2 <= f < frequency + width/2, and of none elsewhere.

    No name of the vocabulary: a sum of bands describes a spectrum of any shape. The part of a band above half the
    sampling rate is left out; there is no noise below zero frequency.
    """

    name: ClassVar[str] = "band_noise"
    named: ClassVar[bool] = False
    density: float = parameter("{u}/sqrt(Hz)", "square root of the two-sided PSD within the band")
    frequency: float = parameter("Hz", "middle of the band")
    width: float = parameter("Hz", "width of the band")

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield nothing: the effect is not part of the vocabulary."""
        return iter(())

    @property
    def edges(self) -> tuple[float, float]:
        """Return the lower and the upper end of the band [Hz]."""
        return max(self.frequency - self.width / 2, 0.0), self.frequency + self.width / 2

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw white noise, and keep the band of it.

        The circular noise is twice as long as the run; a frequency of it at an end of the band counts by its share.
        """
        return self._drawn(len(conditions), conditions.interval, rng)

    def _drawn(self, count: int, interval: float, rng: np.random.Generator) -> np.ndarray:
        """Return so many samples at an interval [s]."""
        length = next_fast_len(2 * count, real=True)
        spectrum = rfft(rng.standard_normal(length))
        frequency, half = rfftfreq(length, interval), 0.5 / (length * interval)
        low, high = self.edges
        within = np.minimum(frequency + half, high) - np.maximum(np.maximum(frequency - half, 0.0), low)
        share = np.clip(within / np.where(frequency > 0, 2 * half, half), 0.0, 1.0)
        return self.density / np.sqrt(interval) * irfft(np.sqrt(share) * spectrum, length)[:count]

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds such noise to one part after the other, from other draws.

        Independent segments overlap by half under windows whose squares add up to one; they are :data:`PERIODS` times
        as long as the noise remembers, the inverse of the width, so that the ends of the band are as sharp as that.
        """
        memory = PERIODS / max(self.width * run.interval, PERIODS / run.count)
        hop = int(np.clip(memory / 2, 1, run.count))
        rise = np.sin(np.pi / 2 * (np.arange(hop) + 0.5) / hop)
        ready, fading = np.empty(0), self._drawn(2 * hop, run.interval, rng)[hop:]

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal ready, fading
            while len(ready) < len(sequence):
                segment = self._drawn(2 * hop, run.interval, rng)
                ready = np.r_[ready, rise * segment[:hop] + rise[::-1] * fading]
                fading = segment[hop:]
            now, ready = ready[: len(sequence)], ready[len(sequence) :]
            return sequence + now

        return transform

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return density^2 within the band."""
        low, high = self.edges
        size = np.abs(np.asarray(frequency, float))
        return np.where((size >= low) & (size < high), self.density**2, 0.0)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return density^2 within the band."""
        return self.psd(frequency)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return 4 density^2/(pi tau) [Si(2x) - Si(4x)/2 - sin^4(x)/x], x = pi f tau, from one end to the other.

        It is the integral of the PSD times sin^4(x)/x^2 (Farrell et al. 2022, eq. 16).
        """
        tau = np.asarray(tau, float)
        below, above = (_transfer(np.pi * end * tau) for end in self.edges)
        return 4 * self.density**2 / (np.pi * tau) * np.maximum(above - below, 0.0)

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the quadratic form of the autocovariance 2 density^2 int cos(2 pi f lag) df over the band."""
        found = [self._of_samples(int(n), interval) for n in np.ravel(averaging)]
        return np.reshape(found, np.shape(averaging))

    def _of_samples(self, count: int, interval: float) -> float:
        """Return the Allan variance of means over ``count`` samples."""
        lag = np.arange(2 * count)
        low, high = (min(2 * end * interval, 1.0) for end in self.edges)
        covariance = self.density**2 / interval * (high * np.sinc(high * lag) - low * np.sinc(low * lag))
        # products of the weights of two samples that lie so far apart, -1 and 1 for the two means
        weights = np.where(lag <= count, 2 * count - 3 * lag, lag - 2 * count)
        return float(weights[0] * covariance[0] + 2 * weights[1:] @ covariance[1:]) / (2 * count**2)


def _transfer(x: np.ndarray) -> np.ndarray:
    """Return the integral of sin^4(u)/u^2 from 0 to ``x``, by its series where the terms cancel."""
    safe = np.where(x > SMALL, x, 1.0)
    value = sici(2 * safe)[0] - sici(4 * safe)[0] / 2 - np.sin(safe) ** 4 / safe
    return np.where(x > SMALL, value, x**3 / 3 - 2 * x**5 / 15 + x**7 / 35)
