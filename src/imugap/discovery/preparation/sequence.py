"""The evenly sampled error sequence of one axis, with flawed samples replaced and marked."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.special import log_ndtr, ndtri_exp

from imugap.discovery.preparation.cosine_bins import USED, Bins
from imugap.discovery.preparation.gap_filling import Autoregression
from imugap.effects.conditions import Conditions

COARSE = 1 / 3
"""Minimum share of one value on a coarse lattice, whose step is the standard deviation or more."""
REACH = 8
"""Samples on each side from which the local level is estimated."""
DEEP = 4.0
"""Standard deviations beyond the bound from which the bound of a clipped sample carries no information."""
ROUNDS = 10
"""Iterations in which clipped samples are drawn."""


@dataclass(frozen=True, eq=False)
class AxisSequence:
    """Error sequence of one axis (measured less error-free input, where there is one).

    Attributes
    ----------
    values
        Samples, shape (n,), evenly spaced; lost or flawed ones are replaced.
    conditions
        Time since the start of the log [s], interval, temperature, error-free input and name of the axis.
    flawed
        Which samples are replacements, shape (n,).
    share
        Share of the frequencies, from the lowest on, with power beyond leakage.
    was_coarse
        Whether the lattice was coarse, where later changes of the values hide it; None if not changed.
    step
        Step of the lattice of the output, zero for none.
    """

    values: np.ndarray
    conditions: Conditions
    flawed: np.ndarray
    share: float = USED
    was_coarse: bool | None = None
    step: float = 0.0

    @cached_property
    def bins(self) -> Bins:
        """Return the bins of its cosine coefficients."""
        return Bins(len(self.values), self.conditions.interval, self.share, self.step)

    @property
    def in_motion(self) -> bool:
        """Return whether the error-free signal of the axis is given, as for a device in motion."""
        return self.conditions.axis is not None and self.conditions.knows([self.conditions.axis])

    @cached_property
    def coarse(self) -> bool:
        """Return whether the lattice of the values is too coarse to examine the tails of their distribution."""
        if self.was_coarse is not None:
            return self.was_coarse
        _, counts = np.unique(self.values, return_counts=True)
        return bool(counts.max() > COARSE * len(self.values))

    def with_values(self, values: np.ndarray) -> "AxisSequence":
        """Return the sequence with other values, which need not lie on the lattice."""
        return replace(self, values=values, was_coarse=self.coarse)

    def with_replaced(self, flawed: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with further samples replaced.

        They are drawn given the others (:mod:`imugap.discovery.preparation.gap_filling`), so that neither level nor
        spectrum is biased.
        """
        if not flawed.any():
            return self
        good = ~(flawed | self.flawed)
        values = Autoregression.of(self.values, good).fill(self.values, ~good, rng)
        return replace(self, values=values, flawed=~good)

    def with_clipped_drawn(self, bound: np.ndarray, side: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with clipped samples drawn from the distribution beyond the full scale, no longer flawed.

        Each is normal about the mean of its neighbourhood, given that it is above (``side`` 1) or below (-1) its
        bound, both of shape (n,). Samples of side 0 stay, and those deep within a motion beyond the full scale, where
        the bound carries no information. Mean and spread include the samples drawn before, so that clipping biases
        neither (data augmentation: Tanner and Wong 1987, doi:10.2307/2289457). On a coarse lattice, where most
        neighbours are equal, all samples stay.
        """
        if _spread(self.values) == 0:
            return self
        at = np.flatnonzero(side * (bound - self.values) > -DEEP * np.abs(side) * _spread(self.values))
        values, flawed, side, bound = self.values.copy(), self.flawed.copy(), side[at], bound[at]
        for _ in range(ROUNDS):
            level, spread = uniform_filter1d(values, 2 * REACH + 1, mode="nearest")[at], _spread(values)
            chance = log_ndtr(side * (level - bound) / spread) + np.log(1 - rng.random(len(at)))
            values[at] = level - side * spread * ndtri_exp(chance)
        flawed[at] = False
        return replace(self, values=values, flawed=flawed)


def _spread(values: np.ndarray) -> float:
    """Return a robust standard deviation of the noise, from the differences of neighbouring samples."""
    return float(np.median(np.abs(np.diff(values))) / 0.6745 / np.sqrt(2))
