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
"""Share of one value above which a lattice of values is coarse: its step is the standard deviation or more."""
REACH = 8
"""Samples that tell the level about a flawed one."""
DEEP = 4.0
"""So many standard deviations behind its bound a clipped sample would be anyway."""
ROUNDS = 10
"""Rounds in which clipped samples are drawn."""


@dataclass(frozen=True, eq=False)
class AxisSequence:
    """Error sequence of one axis (measured less error-free input, where there is one).

    Attributes
    ----------
    values
        Samples, shape (n,), evenly spaced; what was lost or flawed is replaced.
    conditions
        Time since the start of the log [s], interval, temperature, error-free input and name of the axis.
    flawed
        Which samples are replacements, shape (n,).
    share
        Share of the frequencies, from the lowest on, that has power beyond leakage.
    was_coarse
        Whether the samples sat on few levels, where the values no longer show it.
    step
        Distance of the levels of the output, zero where it is on no lattice.
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
        """Return whether the error-free signal of the axis is known, as for a device in motion."""
        return self.conditions.axis is not None and self.conditions.knows([self.conditions.axis])

    @cached_property
    def coarse(self) -> bool:
        """Return whether the values sit on so few levels that their law says nothing of tails."""
        if self.was_coarse is not None:
            return self.was_coarse
        _, counts = np.unique(self.values, return_counts=True)
        return bool(counts.max() > COARSE * len(self.values))

    def with_values(self, values: np.ndarray) -> "AxisSequence":
        """Return the sequence with other values, which may lie between the levels of the samples."""
        return replace(self, values=values, was_coarse=self.coarse)

    def with_replaced(self, flawed: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with further samples replaced by their surroundings.

        They are drawn given the others (:mod:`imugap.discovery.preparation.gap_filling`), so that neither level nor
        spectrum sees them, whatever the noise is.
        """
        if not flawed.any():
            return self
        good = ~(flawed | self.flawed)
        values = Autoregression.of(self.values, good).fill(self.values, ~good, rng)
        return replace(self, values=values, flawed=~good)

    def with_clipped_drawn(self, bound: np.ndarray, side: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with clipped samples drawn anew from what lies beyond the full scale: flawed no more.

        Each is normal about the mean of its neighbourhood, given that it is above (``side`` 1) or below (-1) its
        bound, both of shape (n,); those of side 0 stay, and those of which the bound says nothing, deep within a
        motion beyond the full scale. Mean and spread take the samples drawn before with them, so that what is clipped
        biases neither (data augmentation: Tanner and Wong 1987, doi:10.2307/2289457). Where most neighbours are equal,
        on a coarse lattice, there is no spread to draw from, and all stay.
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
    """Return the standard deviation of the noise between neighbouring samples, whatever a few of them are."""
    return float(np.median(np.abs(np.diff(values))) / 0.6745 / np.sqrt(2))
