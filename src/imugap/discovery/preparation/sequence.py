"""The evenly sampled error sequence of one axis, with flawed samples replaced and marked."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.special import log_ndtr, ndtri_exp

from imugap.discovery.preparation.cosine_bins import MAX_USED_SHARE, Bins
from imugap.effects.conditions import Conditions
from imugap.numerics.samples.gap_filling import Autoregression

MIN_COARSE_SHARE = 1 / 3
"""Minimum share of one value on a coarse lattice, whose step is the standard deviation or more."""
LEVEL_REACH = 8
"""Samples on each side from which the local level is estimated."""
MAX_BOUND_DEPTH = 4.0
"""Standard deviations beyond the bound from which the bound of a clipped sample carries no information."""
DRAW_ITERATIONS = 10
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
        Which samples are replacements, shape (n,); None for none of them.
    share
        Share of the frequencies, from the lowest on, with power beyond leakage.
    was_coarse
        Whether the lattice was coarse, where later changes of the values hide it; None if not changed.
    step
        Step of the lattice of the output, zero for none.
    """

    values: np.ndarray
    conditions: Conditions
    flawed: np.ndarray = None
    share: float = MAX_USED_SHARE
    was_coarse: bool | None = None
    step: float = 0.0

    def __post_init__(self) -> None:
        """Mark no sample as replaced where none is given."""
        if self.flawed is None:
            object.__setattr__(self, "flawed", np.zeros(len(self.values), bool))

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
        return bool(counts.max() > MIN_COARSE_SHARE * len(self.values))

    def with_values(self, values: np.ndarray) -> "AxisSequence":
        """Return the sequence with other values, which need not lie on the lattice."""
        return replace(self, values=values, was_coarse=self.coarse)

    def with_replaced(self, flawed: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with further samples replaced.

        They are drawn given the others (:mod:`imugap.numerics.samples.gap_filling`), so that neither level nor
        spectrum is biased.
        """
        if not flawed.any():
            return self
        good = ~(flawed | self.flawed)
        values = Autoregression.of(self.values, good).fill(self.values, ~good, rng)
        return replace(self, values=values, flawed=~good)

    def with_censored_drawn(self, low: np.ndarray, high: np.ndarray, rng: np.random.Generator) -> "AxisSequence":
        """Return the sequence with censored samples drawn from the distribution within their limits, no longer flawed.

        Each is normal about the mean of its neighbourhood, given that it is between ``low`` and ``high``, both of
        shape (n,). Samples without a limit stay, and those deep within a motion beyond the full scale, where a single
        limit carries no information. Mean and spread include the samples drawn before, so that censoring biases
        neither (data augmentation: Tanner and Wong 1987, doi:10.2307/2289457). Between two limits, where most samples
        may be censored, the mean of the neighbourhood is shrunk to that of the log by the share of its variance that is
        noise (James and Stein 1961). On a coarse lattice, where most neighbours are equal, all samples stay.
        """
        if _spread(self.values) == 0:
            return self
        deep = MAX_BOUND_DEPTH * _spread(self.values)
        one, both = np.isfinite(low) ^ np.isfinite(high), np.isfinite(low) & np.isfinite(high)
        at = np.flatnonzero(both | (one & (low > self.values - deep) | one & (high < self.values + deep)))
        values, flawed, low, high = self.values.copy(), self.flawed.copy(), low[at], high[at]
        for _ in range(DRAW_ITERATIONS):
            around, spread = uniform_filter1d(values, 2 * LEVEL_REACH + 1, mode="nearest"), _spread(values)
            moving = max(1 - spread**2 / (2 * LEVEL_REACH + 1) / around.var(), 0.0)
            level = np.where(both[at], around.mean() + moving * (around[at] - around.mean()), around[at])
            side = np.where(level - low < high - level, 1.0, -1.0)
            near, far = np.where(side > 0, low, high), np.where(side > 0, high, low)
            more, less = (log_ndtr(side * (level - bound) / spread) for bound in (near, far))
            share = 1 - rng.random(len(at))
            log_tail = np.logaddexp(more + np.log(share), less + np.log1p(-share))
            values[at] = level - side * spread * ndtri_exp(log_tail)
        flawed[at] = False
        return replace(self, values=values, flawed=flawed)


def _spread(values: np.ndarray) -> float:
    """Return a robust standard deviation of the noise, from the differences of neighbouring samples."""
    return float(np.median(np.abs(np.diff(values))) / 0.6745 / np.sqrt(2))
