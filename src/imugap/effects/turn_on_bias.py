"""Turn-on bias."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import chdtri

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import AdditiveEffect, Evidence, Role, Transform, parameter
from imugap.numerics.samples.chi_square import log_tail

LEAST = 1e-300
"""Lower limit of a variance over runs."""


@dataclass(frozen=True)
class TurnOnBias(AdditiveEffect):
    """Bias drawn once per run from N(0, std^2) (IEEE 952: turn-on repeatability; He et al. 2023, eq. 14)."""

    name: ClassVar[str] = "turn_on_bias"
    role: ClassVar[Role] = Role.RUN
    std: float = parameter("{u}", "standard deviation over runs")

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw one offset for the whole run."""
        return np.full(len(conditions), self.std * rng.standard_normal())

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the offset of the run to any part."""
        offset = self.std * rng.standard_normal()
        return lambda sequence, conditions: sequence + offset

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"std": self.std, "offset": 0.0}, _start)

    @classmethod
    def between(cls, levels: np.ndarray, errors: np.ndarray) -> Evidence:
        """Estimate the effect from the means of several runs, shape (runs,), of standard deviations ``errors``.

        Without it their weighted scatter is chi-square distributed with one degree of freedom less than runs.
        """
        free = len(levels) - 1
        scatter = float(np.sum((levels - np.average(levels, weights=errors**-2)) ** 2 / errors**2))
        squares, noise = float(np.sum((levels - levels.mean()) ** 2)), float(np.mean(errors**2))
        low, high = (float(np.sqrt(max(squares / chdtri(free, tail) - noise, 0.0))) for tail in (0.025, 0.975))
        std = float(np.sqrt(max(squares / free - noise, LEAST)))
        return Evidence(cls(std), {"std": (low, high)}, log_tail(scatter, free), np.zeros(0, bool))


def _start(own, x, now):
    own.offset = own.std * own.draw.normal()


def _step(own, x, now):
    return x + own.offset
