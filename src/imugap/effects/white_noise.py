"""White noise: angle or velocity random walk."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Stage, StochasticEffect, parameter
from imugap.numerics.state_space import StateSpace


@dataclass(frozen=True)
class WhiteNoise(StochasticEffect):
    """White noise of the rate: S(f) = N^2, sigma^2(tau) = N^2/tau (IEEE 952, angle random walk)."""

    name: ClassVar[str] = "white_noise"
    stage: ClassVar[Stage] = Stage.NOISE
    white: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    density: float = parameter("{u}/sqrt(Hz)", "N, square root of the two-sided PSD")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw interval means: independent, standard deviation N/sqrt(interval)."""
        return self.density / np.sqrt(conditions.interval) * rng.standard_normal(len(conditions))

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"std": self.density / np.sqrt(interval)})

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return N^2 (Farrell et al. 2022, eq. 17)."""
        return np.full_like(np.asarray(frequency, float), self.density**2)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return N^2/tau (IEEE 952)."""
        return self.density**2 / np.asarray(tau, float)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return N^2."""
        return self.psd(frequency)

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return N^2/(n interval)."""
        return self.allan_variance(np.asarray(averaging) * interval)

    def state_space(self) -> StateSpace:
        """Return a model without states."""
        return StateSpace.white(self.density**2)


def _step(own, x, now):
    return x + own.std * own.draw.normal()
