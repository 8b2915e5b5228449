"""Noise common to several axes."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import EquivalentEffect, parameter
from imugap.effects.white_noise import WhiteNoise
from imugap.numerics.state_space import StateSpace


@dataclass(frozen=True)
class CommonMode(EquivalentEffect):
    """White noise of one source, such as the supply or a vibration, common to all axes with this effect.

    Their errors are coherent. Each axis by itself has the signature of :attr:`equivalent`.
    """

    name: ClassVar[str] = "common_mode"
    shared: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    density: float = parameter("{u}/sqrt(Hz)", "square root of the two-sided PSD at a loading of 1")
    loading: float = parameter("1", "signed share of the common noise that the axis takes", -np.inf, default=1.0)

    @property
    def equivalent(self) -> WhiteNoise:
        """Return the white noise of the same spectrum, of density x abs(loading)."""
        return WhiteNoise(self.density * abs(self.loading))

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the common noise and multiply it by the loading of the axis."""
        return self.loading * WhiteNoise(self.density).sample(conditions, rng)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step; the stream of the axes is one."""
        return Block(_step, {"std": self.density / np.sqrt(interval), "loading": self.loading})

    def state_space(self) -> StateSpace:
        """Return a model of one axis without states; the coherence of the axes is not in it."""
        return self.equivalent.state_space()


def _step(own, x, now):
    return x + own.loading * own.std * own.draw.normal()
