"""Distribution of the noise of single samples, by its quantiles."""

from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np
from scipy.special import ndtri

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Effect, Stage, parameter

PROBABILITIES = (0.001, 0.01, 0.05, 0.15, 0.3, 0.5, 0.7, 0.85, 0.95, 0.99, 0.999)
"""Probabilities of the quantiles."""
SCORES = ndtri(PROBABILITIES)
"""Quantiles of the normal distribution."""


def _quantile(number: int) -> float:
    """Declare the quantile of a number in :data:`PROBABILITIES`; by default that of the normal distribution."""
    meaning = f"quantile at {100 * PROBABILITIES[number]:g} %, in standard deviations"
    return parameter("1", meaning, low=-np.inf, default=float(SCORES[number]))


@dataclass(frozen=True)
class NoiseDistribution(Effect):
    """White noise of the quantiles q times std in place of those of a normal distribution.

    A sample of the noise becomes that of the same rank; between quantiles, and beyond the last, it is linear in the
    normal one. No name of the vocabulary: it describes noise that is not normal, and keeps its spectrum white.
    """

    name: ClassVar[str] = "noise_distribution"
    stage: ClassVar[Stage] = Stage.MODULATION
    named: ClassVar[bool] = False
    memoryless: ClassVar[bool] = True
    std: float = parameter("{u}", "standard deviation of a sample of the normal noise that it replaces")
    q_001: float = _quantile(0)
    q_01: float = _quantile(1)
    q_05: float = _quantile(2)
    q_15: float = _quantile(3)
    q_30: float = _quantile(4)
    q_50: float = _quantile(5)
    q_70: float = _quantile(6)
    q_85: float = _quantile(7)
    q_95: float = _quantile(8)
    q_99: float = _quantile(9)
    q_999: float = _quantile(10)

    def __post_init__(self) -> None:
        """Check the limits, and that the quantiles do not fall."""
        super().__post_init__()
        if np.any(np.diff(self.quantiles) < 0):
            raise ValueError(f"{self.name}: expected quantiles that do not fall; found {self.quantiles}")

    @classmethod
    def of(cls, values: np.ndarray, std: float) -> "NoiseDistribution":
        """Return the distribution of independent values, shape (n,), scaled to mean 0 and variance 1.

        ``std`` is the standard deviation of a sample of the noise [unit].
        """
        scaled = (values - values.mean()) / values.std()
        return cls(std, *map(float, np.quantile(scaled, PROBABILITIES)))

    @property
    def quantiles(self) -> tuple[float, ...]:
        """Return the quantiles, in standard deviations."""
        return tuple(getattr(self, item.name) for item in fields(self)[1:])

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Put the quantile of the same probability in place of each sample."""
        if self.std == 0:
            return sequence
        score, quantiles, slopes = sequence / self.std, np.array(self.quantiles), self._slopes
        segment = np.clip(np.searchsorted(SCORES, score) - 1, 0, len(slopes) - 1)
        return self.std * (quantiles[segment] + slopes[segment] * (score - SCORES[segment]))

    @property
    def _slopes(self) -> np.ndarray:
        """Return the slope of each segment between two quantiles."""
        return np.diff(self.quantiles) / np.diff(SCORES)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        values = {"std": self.std, "scores": SCORES, "quantiles": np.array(self.quantiles), "slopes": self._slopes}
        return Block(_step, values)


def _step(own, x, now):
    y = x
    if own.std > 0.0:
        score = x / own.std
        y = own.std * (own.quantiles[0] + own.slopes[0] * (score - own.scores[0]))
        for k in range(1, len(own.slopes)):
            if score > own.scores[k]:
                y = own.std * (own.quantiles[k] + own.slopes[k] * (score - own.scores[k]))
    return y
