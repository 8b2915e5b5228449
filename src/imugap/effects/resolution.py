"""Resolution of the output word."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from imugap.effects.block import Block, rint
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, parameter
from imugap.integrity.precision import decimal, spacing
from imugap.integrity.report import IMPROBABLE

FORMAT = 0.05
"""Step of decimal numbers [standard deviations of the noise] below which it is that of the file."""
FINE = 0.005
"""Step [standard deviations of the noise] below which a lattice is negligible."""
FAR = 1e9
"""Mean over the step beyond which a rounding leaves it as it is."""
DEEP = 8.0
"""Standard deviations beyond which a normal density is neglected."""
DITHERED, LEAST = 0.5, 0.02
"""Standard deviations [steps] above which rounding adds step^2/12, and below which the noise is not observable."""
BLOCK = 64
"""Samples of a block, which separates noise from drift."""


@dataclass(frozen=True)
class Resolution(Effect):
    """Output rounded to a lattice of values (least significant bit of the output word)."""

    name: ClassVar[str] = "resolution"
    stage: ClassVar[Stage] = Stage.WORD
    role: ClassVar[Role] = Role.OUTPUT
    memoryless: ClassVar[bool] = True
    rounds: ClassVar[bool] = True
    step: float = parameter("{u}", "distance of neighbouring output values", low=TINY)

    @property
    def lattice(self) -> float:
        """Distance of the levels."""
        return self.step

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Round to the nearest multiple of the step."""
        return np.rint(sequence / self.step) * self.step

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"size": self.step})

    def moments(self, mean: float, std: float) -> tuple[float, float]:
        """Return mean and variance of independent normal values after rounding."""
        reach = np.ceil(DEEP * std / self.step) + 1
        level = np.rint(mean / self.step) + np.arange(-reach, reach + 1)
        share = np.diff(ndtr((np.r_[level - 0.5, level[-1] + 0.5] * self.step - mean) / std))
        rounded = float(share @ level) * self.step
        return rounded, float(share @ (level * self.step - rounded) ** 2)

    def mean_ahead(self, mean: float, std: float) -> float:
        """Return the mean of independent normal values from their mean after rounding.

        Both are equal, to 1e-8 of the step, for a standard deviation of one step or more. Far beyond the step a mean
        has no digits that tell the difference.
        """
        if std > self.step or abs(mean) > FAR * self.step:
            return mean
        near = mean - self.step, mean + self.step
        return float(brentq(lambda tried: self.moments(tried, std)[0] - mean, *near, xtol=1e-9 * self.step))

    def std_ahead(self, mean: float, variance: float) -> float:
        """Return the standard deviation of independent normal values from mean and variance after rounding.

        Rounding adds step^2/12 (Sheppard 1898) for a step below about two standard deviations; for a larger one the
        variance depends on the position of the mean between two levels.
        """
        fine = np.sqrt(max(variance - self.step**2 / 12, 0.0))
        if fine > self.step * DITHERED:
            return float(fine)
        stds = self.step * np.geomspace(LEAST, 1.0, 60)
        found = np.array([self.moments(self.mean_ahead(mean, std), std)[1] for std in stds])
        return float(np.interp(variance, np.maximum.accumulate(found), stds))

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the lattice of the output ``values``, shape (n,), NaN where lost, or None.

        No sample is flawed: the samples contain the variance step^2/12 as white noise and, for a step that is not
        small, have a smaller kurtosis than a normal distribution.
        """
        known = np.isfinite(values)
        step, error = spacing(values[known])
        level = noise(values, conditions)
        if not step or step < FINE * level or (decimal(step) and step < FORMAT * level):
            return None
        returns = np.count_nonzero(np.diff(values[known])) + 1 - len(np.unique(values[known]))
        log_p = -float(returns) * np.log(step / max(error, np.spacing(step)))
        if log_p > np.log(IMPROBABLE):
            return None
        return Evidence(cls(step), {"step": (step - error, step + error)}, log_p, np.zeros(len(values), bool))


def noise(values: np.ndarray, conditions: Conditions) -> float:
    """Return the standard deviation of the noise of an output, NaN where lost: the median of that of short blocks."""
    values = values - conditions.error_free
    values = values[np.isfinite(values)]
    blocks = max(len(values) // BLOCK, 1)
    return float(np.median([block.std() for block in np.array_split(values, blocks)]))


def _step(own, x, now):
    return rint(x / own.size) * own.size
