"""Constant bias."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AdditiveEffect, Role, parameter


@dataclass(frozen=True)
class Bias(AdditiveEffect):
    """A constant offset (IEEE 1554: fixed bias)."""

    name: ClassVar[str] = "bias"
    role: ClassVar[Role] = Role.BIAS
    memoryless: ClassVar[bool] = True
    value: float = parameter("{u}", "offset of the output", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the offset at every sample."""
        return np.full(len(conditions), self.value)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"value": self.value})


def _step(own, x, now):
    return x + own.value
