"""One axis of a log as discovery works on it: even in time, its flawed samples replaced and marked."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from imugap.discovery.noise import USED, Bins
from imugap.effects.effect import Conditions

COARSE = 1 / 3
"""Share of one value above which a lattice of values is coarse: its step is the standard deviation or more."""


@dataclass(frozen=True, eq=False)
class Sequence:
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
    few
        Whether the samples sat on few levels, where the values no longer show it.
    """

    values: np.ndarray
    conditions: Conditions
    flawed: np.ndarray
    share: float = USED
    few: bool | None = None

    @cached_property
    def bins(self) -> Bins:
        """Return the bins of its cosine coefficients."""
        return Bins(len(self.values), self.conditions.interval, self.share)

    @cached_property
    def coarse(self) -> bool:
        """Return whether the values sit on so few levels that their law says nothing of tails."""
        if self.few is not None:
            return self.few
        _, counts = np.unique(self.values, return_counts=True)
        return bool(counts.max() > COARSE * len(self.values))

    def changed(self, values: np.ndarray) -> "Sequence":
        """Return the sequence with other values, which may lie between the levels of the samples."""
        return replace(self, values=values, few=self.coarse)

    def mended(self, flawed: np.ndarray, rng: np.random.Generator) -> "Sequence":
        """Return the sequence with further samples replaced by their surroundings.

        A stretch of flawed samples becomes the straight line between the means of its neighbourhoods plus white noise
        of the size that neighbouring samples differ by, so that neither level nor spectrum sees it.
        """
        if not flawed.any():
            return self
        return replace(self, values=_mended(self.values, flawed | self.flawed, rng), flawed=flawed | self.flawed)


def _mended(values: np.ndarray, flawed: np.ndarray, rng: np.random.Generator, reach: int = 8) -> np.ndarray:
    good = np.flatnonzero(~flawed)
    kernel = min(reach, len(good))
    means = np.convolve(np.pad(values[good], (kernel // 2, kernel - 1 - kernel // 2), "edge"), np.ones(kernel), "valid")
    level = np.interp(np.flatnonzero(flawed), good, means / kernel)
    spread = np.median(np.abs(np.diff(values[good]))) / 0.6745 / np.sqrt(2)
    result = values.copy()
    result[flawed] = level + spread * rng.standard_normal(len(level))
    return result
