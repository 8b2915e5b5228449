"""Random telegraph noise."""

from copy import deepcopy
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, EquivalentEffect, Transform, parameter
from imugap.effects.gauss_markov import GaussMarkov

MOST_SWITCHES = 1e9
"""Mean number of switches between samples above which an odd one is as probable as an even one, to rounding."""


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
        switches = self._switched(conditions.time, None, rng)
        sign = rng.choice([-1.0, 1.0]) * np.where(switches % 2, -1.0, 1.0)
        return self.step / 2 * sign

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the process to one part after the other.

        The first level is drawn behind the switches of the whole run, which are drawn twice.
        """
        again = deepcopy(rng)
        before = None
        for conditions in run.parts():
            self._switched(conditions.time, before, rng)
            before = conditions.time[-1]
        level, before = rng.choice([-1.0, 1.0]), None

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal level, before
            sign = level * np.where(self._switched(conditions.time, before, again) % 2, -1.0, 1.0)
            level, before = sign[-1], conditions.time[-1]
            return sequence + self.step / 2 * sign

        return transform

    def _switched(self, time: np.ndarray, before: float | None, rng: np.random.Generator) -> np.ndarray:
        """Return the number of switches, modulo 2 each, up to each time [s], since the sample before the first one."""
        elapsed = np.diff(time) if before is None else np.diff(time, prepend=before)
        switches = np.cumsum(rng.poisson(np.minimum(self.rate * elapsed, MOST_SWITCHES)) % 2)
        return np.r_[0, switches] if before is None else switches

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
