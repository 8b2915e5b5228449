"""Outliers."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import AdditiveEffect, Role, Transform, parameter
from imugap.numerics.samples.skipped_draws import skipped


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
        return self._drawn(len(conditions), rng, rng)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the errors to one part after the other."""
        sizes = skipped(rng, np.random.Generator.random, run.count)
        return lambda sequence, conditions: sequence + self._drawn(len(sequence), rng, sizes)

    def _drawn(self, count: int, places: np.random.Generator, sizes: np.random.Generator) -> np.ndarray:
        """Return the errors of ``count`` samples, from a stream for their places, and one for their sizes."""
        hit = places.random(count) < self.probability
        return np.where(hit, self.std * sizes.standard_normal(count), 0.0)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"probability": self.probability, "std": self.std})


def _step(own, x, now):
    y = x
    if own.draw.uniform() < own.probability:
        y = x + own.std * own.draw.normal()
    return y
