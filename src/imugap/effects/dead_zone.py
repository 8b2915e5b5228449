"""Dead zone: an output that is zero while its input is small."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import bdtr

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, parameter
from imugap.integrity.precision import grain, spacing
from imugap.integrity.report import IMPROBABLE
from imugap.numerics.samples.truncated_exponential import log_slope

NEAREST, FEWEST = 100, 20
"""Samples next to the gap that give the density there, and their least number."""
EXPONENTIAL = np.log([1 / 0.025, 2, 1 / 0.975])
"""Quantiles of the distance of the innermost sample from the edge, over its mean: 97.5, 50 and 2.5 %."""


@dataclass(frozen=True)
class DeadZone(Effect):
    """Output that is zero where its input is within the zone, and its input elsewhere (IEEE 528: dead band)."""

    name: ClassVar[str] = "dead_zone"
    stage: ClassVar[Stage] = Stage.RANGE
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    width: float = parameter("{u}", "width of the zone of the input, symmetric about zero", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Put zero in place of the samples within the zone."""
        return np.where(np.abs(sequence) < self.width / 2, 0.0, sequence)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"half": self.width / 2})

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the zone of the output ``values``, shape (n,), NaN where lost, or None.

        Samples are zero, and no other is in a gap about zero. The density of the sizes next to the gap is taken to fall
        off in it exponentially, by the slope that they show and two standard errors more. Samples of one passage near
        the gap count as one, and as many are zero as the gap lacks.
        """
        size = np.abs(values[np.isfinite(values)])
        zeros = np.count_nonzero(size == 0)
        outside = np.sort(size[size > 0])
        if not zeros or len(outside) < FEWEST:
            return None
        step, _ = spacing(values[np.isfinite(values)])
        inner, reach = float(outside[0]), float(outside[min(NEAREST, len(outside)) - 1])
        gap, window = inner - step, reach - inner + step
        if gap < max(step / 2, float(grain(size).max())):
            return None
        inside = outside[outside <= reach] - inner + step / 2
        slope, error = log_slope(inside / window)
        steepest = max(slope + 2 * error, 0.0) / window
        ratio = _mass(-steepest, gap) / _mass(steepest, window)
        near = (size > 0) & (size <= reach)
        passages = np.count_nonzero(np.diff(near.astype(int), prepend=0) == 1)
        log_p = -passages * float(np.log1p(ratio))
        if log_p > np.log(IMPROBABLE) or bdtr(zeros, zeros + len(inside), ratio / (1 + ratio)) < IMPROBABLE:
            return None
        low, width, high = 2 * inner + step * np.r_[-1, 0, 1] - 2 * window / len(inside) * EXPONENTIAL
        if step:
            first, second = (np.count_nonzero(np.abs(outside - inner - k * step) < step / 2) for k in (0, 1))
            width = min(max(width + step - 2 * step * first / max(second, 1), low), high)
        interval = {"width": (max(float(low), 0.0), float(high))}
        half = np.full(len(values), width / 2)
        flawed = np.isfinite(values) & (values == 0)
        return Evidence(
            cls(float(width)), interval, log_p, flawed, (-float(width) / 2, float(width) / 2), (-half, half)
        )


def _mass(slope: float, length: float) -> float:
    """Return the integral of exp(slope x) over x from 0 to ``length``."""
    return float(np.expm1(slope * length) / slope) if abs(slope * length) > 1e-9 else length


def _step(own, x, now):
    return 0.0 if -own.half < x and x < own.half else x
