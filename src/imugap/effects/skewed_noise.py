"""White noise of a skewed law: its large samples are of one sign more than of the other."""

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from scipy.special import ndtr

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Distribution, parameter
from imugap.effects.white_noise import WhiteNoise
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.white_samples import MAX_LEFT, WhiteSamples, two_sided_log_p

MOST = 3.0
"""Largest skewness; that of exponential numbers is 2."""
LEAST_SKEWNESS = 0.3
"""Least skewness of noise that is not nearly symmetric, as real noise is."""
WIDEST, HALVINGS = 0.7, 60
"""Value of c above that of the largest skewness, and halvings of an interval in which c is."""


@dataclass(frozen=True)
class SkewedNoise(WhiteNoise):
    """White noise whose samples go with the cube (1 + c N)^3 of a normal value N, less the mean.

    This is nearly a gamma law of the same skewness (Wilson and Hilferty 1931, doi:10.1073/pnas.17.12.684): exponential
    numbers at 2, normal ones at 0. A negative skewness turns the sign of the noise. Its spectrum and Allan variance are
    those of normal white noise of the same density. A file for a filter or another simulator has its density alone.
    """

    name: ClassVar[str] = "skewed_noise"
    normal: ClassVar[bool] = False
    skewness: float = parameter("1", "skewness of a sample", low=-MOST, high=MOST, default=1.0)

    def free(self) -> tuple[str, ...]:
        """Return the density: a spectrum does not show the law."""
        return ("density",)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw independent samples."""
        sign, c, mean, std = _cube(self.skewness)
        cubes = _cubed(rng.standard_normal(len(conditions)), c) - mean
        return self.density / np.sqrt(conditions.interval) * sign / std * cubes

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        sign, c, mean, std = _cube(self.skewness)
        return Block(_step, {"size": sign * self.density / np.sqrt(interval) / std, "c": c, "mean": mean})

    @classmethod
    def shown(cls, samples: WhiteSamples, density: float) -> Distribution | None:
        """Return the noise of the skewness of the samples, if their law is nearer to it than to a normal one."""
        skewness = samples.skewness
        if not LEAST_SKEWNESS < abs(skewness) < MOST:
            return None
        if samples.left_by(partial(_law, skewness=skewness * samples.share**3)) > MAX_LEFT:
            return None
        error, score = NORMAL_QUANTILE * samples.skewness_error, samples.skewness_score
        ends = max(float(skewness - error), -MOST), min(float(skewness + error), MOST)
        return Distribution(cls(density, skewness), {"skewness": ends}, two_sided_log_p(score), score**2 / 2)


def _cubed(normal: np.ndarray, c: float) -> np.ndarray:
    """Return ((1 + c N)^3 - 1)/c of normal values, which is 3 N where c is 0."""
    return normal * (3 + c * normal * (3 + c * normal))


def _moments(c: float) -> tuple[float, float, float]:
    """Return mean, standard deviation and skewness of :func:`_cubed`: sums of the moments of a normal value."""
    variance = 9 + 36 * c**2 + 15 * c**4
    third = 162 * c + 864 * c**3 + 810 * c**5
    return 3 * c, float(np.sqrt(variance)), third / variance**1.5


def _cube(skewness: float) -> tuple[float, float, float, float]:
    """Return the sign, c, and mean and standard deviation of :func:`_cubed` for a skewness."""
    low, high = 0.0, WIDEST
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _moments(middle)[2] < abs(skewness) else (low, middle)
    return (-1.0 if skewness < 0 else 1.0, high, *_moments(high)[:2])


def _law(values: np.ndarray, skewness: float) -> np.ndarray:
    """Return the cumulative probability of values of variance 1 of a skewness."""
    sign, c, mean, std = _cube(skewness)
    probability = ndtr((np.cbrt(1 + c * (mean + std * sign * values)) - 1) / c)
    return probability if sign > 0 else 1 - probability


def _step(own, x, now):
    normal = own.draw.normal()
    return x + own.size * (normal * (3.0 + own.c * normal * (3.0 + own.c * normal)) - own.mean)
