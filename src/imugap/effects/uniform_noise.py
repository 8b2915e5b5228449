"""White noise of uniform numbers, as of a random generator that is not normal, or of a dither."""

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
from scipy.special import ndtr

from imugap.effects.block import Block, sqrt
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Distribution, Transform, parameter
from imugap.effects.white_noise import WhiteNoise
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.skipped_draws import skipped
from imugap.numerics.samples.white_samples import MAX_LEFT, NORMAL_KURTOSIS, WhiteSamples, two_sided_log_p

EXCESS = -1.2
"""Excess of the kurtosis of a uniform law."""
HIGHEST_KURTOSIS = 2.6
"""Highest kurtosis of noise that is not nearly normal, as real noise is."""


@dataclass(frozen=True)
class UniformNoise(WhiteNoise):
    """White noise, a sum of uniform and normal numbers; ``share`` is that of the uniform ones in the variance.

    Its spectrum and Allan variance are those of normal white noise of the same density; its kurtosis is
    3 - 1.2 share^2. A file for a filter or another simulator has its density alone.
    """

    name: ClassVar[str] = "uniform_noise"
    normal: ClassVar[bool] = False
    share: float = parameter("1", "share of the variance that is of uniform numbers", high=1.0, default=1.0)

    def free(self) -> tuple[str, ...]:
        """Return the density: a spectrum does not show the law."""
        return ("density",)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw independent samples, first the normal part of all."""
        return self._drawn(len(conditions), conditions.interval, rng, rng)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the noise to one part after the other."""
        later = skipped(rng, np.random.Generator.standard_normal, run.count)
        return lambda sequence, conditions: sequence + self._drawn(len(sequence), run.interval, rng, later)

    def _drawn(
        self, count: int, interval: float, normal: np.random.Generator, uniform: np.random.Generator
    ) -> np.ndarray:
        """Return samples from a stream for the normal part, and one for the uniform part."""
        parts = np.sqrt(1 - self.share) * normal.standard_normal(count)
        return self.density / np.sqrt(interval) * (parts + np.sqrt(12 * self.share) * (uniform.random(count) - 0.5))

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        std = self.density / np.sqrt(interval)
        return Block(_step, {"std": std * sqrt(1 - self.share), "width": std * sqrt(12 * self.share)})

    @classmethod
    def shown(cls, samples: WhiteSamples, density: float) -> Distribution | None:
        """Return the noise whose kurtosis the samples have, if their law is nearer to it than to a normal one."""
        if samples.kurtosis > HIGHEST_KURTOSIS:
            return None
        share = _share(samples.kurtosis)
        if samples.left_by(partial(_law, share=min(share * samples.share**2, 1.0))) > MAX_LEFT:
            return None
        ends = (_share(samples.kurtosis + side * NORMAL_QUANTILE * samples.kurtosis_error) for side in (1, -1))
        score = samples.kurtosis_score
        effect = cls(density, min(share, 1.0))
        return Distribution(
            effect, {"share": tuple(min(end, 1.0) for end in ends)}, two_sided_log_p(score), score**2 / 2
        )


def _share(kurtosis: float) -> float:
    """Return the share of the variance that is uniform where the kurtosis is given, more than 1 below that of all."""
    return float(np.sqrt(max((kurtosis - NORMAL_KURTOSIS) / EXCESS, 0.0)))


def _law(values: np.ndarray, share: float) -> np.ndarray:
    """Return the cumulative probability of a sum of normal and uniform values of variance 1."""
    half, std = np.sqrt(3 * share), np.sqrt(max(1 - share, 1e-9))
    ends = (_integral((values + side * half) / std) for side in (1, -1))
    return np.clip(std * np.subtract(*ends) / (2 * half), 0.0, 1.0)


def _integral(x: np.ndarray) -> np.ndarray:
    """Return the integral of the normal distribution function up to x."""
    return x * ndtr(x) + np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)


def _step(own, x, now):
    return x + own.std * own.draw.normal() + own.width * (own.draw.uniform() - 0.5)
