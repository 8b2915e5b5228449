"""Outliers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AdditiveEffect, Role, parameter


@dataclass(frozen=True)
class Outliers(AdditiveEffect):
    """Rare samples with an additional error N(0, std^2): the contaminated normal distribution (Tukey 1960)."""

    name: ClassVar[str] = "outliers"
    role: ClassVar[Role] = Role.OUTLIERS
    probability: float = parameter("1", "probability that a sample has the additional error", high=1.0)
    std: float = parameter("{u}", "standard deviation of the additional error")

    def free(self) -> tuple[str, ...]:
        """Return no parameter: a fit replaces the outliers, and does not adjust them."""
        return ()

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the additional error; samples without one have zero."""
        hit = rng.random(len(conditions)) < self.probability
        return np.where(hit, self.std * rng.standard_normal(len(conditions)), 0.0)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"probability": self.probability, "std": self.std})


def _step(own, x, now):
    y = x
    if own.draw.uniform() < own.probability:
        y = x + own.std * own.draw.normal()
    return y
