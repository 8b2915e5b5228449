"""Cosine coefficients of a sequence, summed over bins of frequency."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.fft import dct

SINGLE_BINS = 64
"""Number of lowest and of highest coefficients with bins of their own."""
BIN_WIDTH = 0.03
"""Relative width of the other bins, relative to the distance from zero or from half the sampling rate."""
MAX_USED_SHARE = 0.98
"""Maximum share of the frequencies used; at half the sampling rate filters have a zero."""
MIN_RELATIVE_POWER, WINDOW_SHARE = 1e-4, 1 / 200
"""Power over its median below which it may be leakage from the ends of a log; width of the running mean, as a share."""
MIN_LEAKAGE_RATIO = 100.0
"""Minimum power of a used frequency, over the leaked power."""


def usable_share(values: np.ndarray) -> float:
    """Return the share of frequencies, from the lowest on, up to which samples have power beyond leakage.

    The cosine transform leaks power of the slopes s at both ends, where it mirrors the samples: 2/n (s_first^2 +
    s_last^2)/(2 sin(pi k/(2 n)))^4 at coefficient k of n. Any sample may be at the end of a part of the log, so the
    mean over all slopes is used.
    """
    power = dct(values - values.mean(), norm="ortho")[1:] ** 2
    width = max(int(WINDOW_SHARE * len(power)), 1)
    means = power[: len(power) // width * width].reshape(-1, width).mean(axis=1)
    place = (np.arange(len(means)) + 0.5) * width / len(values)
    leaked = 4 / len(values) * np.mean(np.diff(values) ** 2) / (2 * np.sin(np.pi / 2 * place)) ** 4
    loud = np.flatnonzero((means > MIN_RELATIVE_POWER * np.median(means)) & (means > MIN_LEAKAGE_RATIO * leaked))
    return float(min(MAX_USED_SHARE, (loud[-1] + 1) * width / len(power))) if len(loud) else MAX_USED_SHARE


def cosine_coefficients(values: np.ndarray) -> np.ndarray:
    """Return the orthonormal cosine coefficients k = 1..n-1 of columns."""
    return dct(values, axis=0, norm="ortho")[1:]


@dataclass(frozen=True, eq=False)
class Bins:
    """Neighbouring cosine coefficients k = 1..n-1 of a sequence, summed.

    Attributes
    ----------
    count, interval
        Number of samples n and sampling interval [s].
    share
        Share of the frequencies used, from the lowest on.
    step
        Step to which the output is rounded, or zero.
    """

    count: int
    interval: float
    share: float = MAX_USED_SHARE
    step: float = 0.0

    @property
    def rounding(self) -> float:
        """Return the variance that rounding adds to each coefficient (Sheppard 1898)."""
        return self.step**2 / 12

    @property
    def last(self) -> int:
        """Return the number of coefficients used."""
        return int(self.share * (self.count - 1))

    @cached_property
    def edges(self) -> np.ndarray:
        """Return the first coefficient (0 for k = 1) of each bin."""
        last = self.last
        if last <= 4 * SINGLE_BINS:
            return np.arange(last)
        return np.unique(np.concatenate([_widening(last // 2), last - _widening(last - last // 2)[1:]]))

    @cached_property
    def number(self) -> np.ndarray:
        """Return the number of coefficients in each bin."""
        return np.diff(np.r_[self.edges, self.last]).astype(float)

    @cached_property
    def frequency(self) -> np.ndarray:
        """Return the mean frequency of each bin [Hz]."""
        first = self.edges + 1
        return (first + (self.number - 1) / 2) / (2 * self.count * self.interval)

    @cached_property
    def width(self) -> np.ndarray:
        """Return the width of each bin [Hz]."""
        return self.number / (2 * self.count * self.interval)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over bins of ``values``, shape (n - 1,)."""
        return np.add.reduceat(values[: self.last], self.edges)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Interpolate values of the bins to the coefficients, shape (n - 1,), linearly in the logarithms.

        Coefficients with a bin of their own keep its value.
        """
        means = self.edges + 1 + (self.number - 1) / 2
        return np.exp(np.interp(_logarithms(self.count), np.log(means), np.log(values)))


@lru_cache(maxsize=4)
def _logarithms(count: int) -> np.ndarray:
    """Return the logarithms of k = 1..count-1."""
    return np.log(np.arange(1, count))


def _widening(count: int) -> np.ndarray:
    """Return bin edges from 0 up to ``count``: of single coefficients first, then of growing width."""
    bins = int(np.ceil(np.log(count / SINGLE_BINS) / BIN_WIDTH))
    return np.r_[0:SINGLE_BINS, np.rint(np.geomspace(SINGLE_BINS, count, bins + 1)).astype(int)]
