"""Quantization of the integrated signal: the angle or velocity of which the rate samples are differences."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import StochasticEffect, Transform, parameter


@dataclass(frozen=True)
class Quantization(StochasticEffect):
    """Rounding of the integrated signal: sigma(tau) = sqrt(3) Q/tau (IEEE 952, quantization noise).

    The angle or velocity has a white error e of standard deviation Q (lsb/sqrt(12) if multiples of lsb are what it is
    rounded to); the rate has (e_k - e_(k-1))/interval. Rounding of the rate word itself is
    :class:`~imugap.effects.resolution.Resolution`.
    """

    name: ClassVar[str] = "quantization"
    q: float = parameter("{u}*s", "Q, standard deviation of the rounding error of the integrated signal")

    def end_error(self, interval: float) -> float:
        """Return q/interval, the standard deviation of one rounding error in a difference of two."""
        return self.q / interval

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Difference independent errors, uniform within half a least significant bit."""
        half = np.sqrt(3) * self.q
        return np.diff(rng.uniform(-half, half, len(conditions) + 1)) / conditions.interval

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the differences to one part after the other."""
        half = np.sqrt(3) * self.q
        last = rng.uniform(-half, half)

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal last
            errors = np.r_[last, rng.uniform(-half, half, len(sequence))]
            last = errors[-1]
            return sequence + np.diff(errors) / run.interval

        return transform

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"span": 2 * np.sqrt(3) * self.q / interval, "last": 0.0}, _start)

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Raise NotImplementedError: the density, (2 pi f)^2 interval Q^2, depends on the sampling interval."""
        raise NotImplementedError("quantization: expected a sampling interval (sampled_psd); found none (psd)")

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return 3 Q^2/tau^2 (IEEE 952)."""
        return 3 * self.q**2 / np.asarray(tau, float) ** 2

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return 4 Q^2/interval sin^2(pi f interval) (IEEE 952)."""
        return 4 * self.q**2 / interval * np.sin(np.pi * np.asarray(frequency, float) * interval) ** 2

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return 3 Q^2/(n interval)^2: exact, as a second difference of the angle holds e - 2 e + e."""
        return self.allan_variance(np.asarray(averaging) * interval)


def _start(own, x, now):
    own.last = own.span * (own.draw.uniform() - 0.5)


def _step(own, x, now):
    error = own.span * (own.draw.uniform() - 0.5)
    y = x + (error - own.last)
    own.last = error
    return y
