"""Random telegraph noise."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, EquivalentEffect, parameter
from imugap.effects.gauss_markov import GaussMarkov


@dataclass(frozen=True)
class RandomTelegraph(EquivalentEffect):
    """Two levels, +-step/2, with switches by a Poisson process (Machlup 1954).

    Its autocovariance step^2/4 exp(-2 rate |lag|), so all of its second-order signature, is that of
    :attr:`equivalent`; it is not Gaussian.
    """

    name: ClassVar[str] = "random_telegraph"
    two_valued: ClassVar[bool] = True
    step: float = parameter("{u}", "distance of the two values")
    rate: float = parameter("1/s", "mean number of switches per second", low=TINY)

    @property
    def equivalent(self) -> GaussMarkov:
        """Return the Gauss-Markov process of the same autocovariance: std step/2, correlation time 1/(2 rate)."""
        return GaussMarkov(self.step / 2, 1 / (2 * self.rate))

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the first level, then the number of switches between stamps: exact for a Poisson process."""
        switches = np.cumsum(rng.poisson(self.rate * np.diff(conditions.time)) % 2)
        sign = rng.choice([-1.0, 1.0]) * np.where(np.r_[0, switches] % 2, -1.0, 1.0)
        return self.step / 2 * sign

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        odd = -0.5 * np.expm1(-2 * self.rate * interval)
        return Block(_step, {"level": self.step / 2, "odd": odd}, _start)


def _start(own, x, now):
    if own.draw.uniform() < 0.5:
        own.level = -own.level


def _step(own, x, now):
    y = x + own.level
    if own.draw.uniform() < own.odd:
        own.level = -own.level
    return y
