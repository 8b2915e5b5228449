"""Rate or acceleration random walk."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import StochasticEffect, Transform, parameter
from imugap.numerics.state_space import StateSpace


@dataclass(frozen=True)
class RandomWalk(StochasticEffect):
    """Wiener process: S(f) = K^2/(2 pi f)^2, sigma^2(tau) = K^2 tau/3 (IEEE 952, rate random walk)."""

    name: ClassVar[str] = "random_walk"
    slow: ClassVar[bool] = True
    stationary: ClassVar[bool] = False
    density_k: float = parameter("{u}/s/sqrt(Hz)", "K, square root of the two-sided PSD of the driving noise")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Sum independent increments of standard deviation K sqrt(interval), from zero at the first sample."""
        increments = self.density_k * np.sqrt(conditions.interval) * rng.standard_normal(len(conditions))
        increments[0] = 0.0
        return np.cumsum(increments)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the process to one part after the other."""
        std, last = self.density_k * np.sqrt(run.interval), None

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal last
            increments = std * rng.standard_normal(len(sequence))
            increments[0] = 0.0 if last is None else last + increments[0]
            values = np.cumsum(increments)
            last = values[-1]
            return sequence + values

        return transform

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"std": self.density_k * np.sqrt(interval), "level": 0.0})

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return K^2/(2 pi f)^2 (Farrell et al. 2022, eq. 19)."""
        return (self.density_k / (2 * np.pi * np.asarray(frequency, float))) ** 2

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return K^2 tau/3 (IEEE 952)."""
        return self.density_k**2 * np.asarray(tau, float) / 3

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return (K interval/(2 sin(pi f interval)))^2: that of the increments over the gain of a difference."""
        return (self.density_k * interval / (2 * np.sin(np.pi * np.asarray(frequency, float) * interval))) ** 2

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return K^2 interval (2 n^2 + 1)/(6 n): means differ by increments weighted 1, 2 .. n .. 2, 1, over n."""
        n = np.asarray(averaging, float)
        return self.density_k**2 * interval * (2 * n**2 + 1) / (6 * n)

    def state_space(self) -> StateSpace:
        """Return one integrating state."""
        return StateSpace.first_order(decay=0.0, driving_psd=self.density_k**2, variance=0.0)


def _step(own, x, now):
    y = x + own.level
    own.level = own.level + own.std * own.draw.normal()
    return y
