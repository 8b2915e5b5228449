"""Law of independent values, by their skewness and kurtosis, and by the numbers of them in cells."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.special import log_ndtr, ndtr

NORMAL_KURTOSIS = 3.0
"""Kurtosis of a normal law."""
CELLS = 12
"""Cells of equal probability in which values are counted."""
MAX_LEFT = 0.25
"""Largest share of the deviation of the density from the normal one that a law leaves."""
LAGS, TOLERATED_CORRELATION, CHANCE = 50, 0.05, 4.0
"""Lags at which magnitudes may be correlated, the correlation that is tolerated, as frequencies that are left out make
it, and standard deviations by which chance may exceed it."""


@dataclass(frozen=True, eq=False)
class WhiteSamples:
    """White noise of an unknown law with a little normal noise in it.

    Attributes
    ----------
    values
        Independent values of mean 0 and variance 1, shape (n,).
    share
        Standard deviation of the noise in them; the rest of the variance is of many samples, and normal.
    """

    values: np.ndarray
    share: float

    @classmethod
    def of(cls, values: np.ndarray, share: float) -> "WhiteSamples":
        """Return values, shape (n,), scaled to mean 0 and variance 1."""
        return cls((values - values.mean()) / values.std(), min(float(share), 1.0))

    @cached_property
    def _moments(self) -> tuple[float, float]:
        """Third and fourth moment of the values."""
        return float(np.mean(self.values**3)), float(np.mean(self.values**4))

    @property
    def skewness(self) -> float:
        """Return the skewness of the noise."""
        return self._moments[0] / self.share**3

    @property
    def kurtosis(self) -> float:
        """Return the kurtosis of the noise."""
        return NORMAL_KURTOSIS + (self._moments[1] - NORMAL_KURTOSIS) / self.share**4

    @property
    def skewness_error(self) -> float:
        """Return the standard deviation of the skewness, whatever the law is."""
        z, third = self.values, self._moments[0]
        return float(np.std(z**3 - 3 * z - 1.5 * third * z**2) / np.sqrt(len(z)) / self.share**3)

    @property
    def kurtosis_error(self) -> float:
        """Return the standard deviation of the kurtosis, whatever the law is."""
        z, (third, fourth) = self.values, self._moments
        return float(np.std(z**4 - 4 * third * z - 2 * fourth * z**2) / np.sqrt(len(z)) / self.share**4)

    @property
    def skewness_score(self) -> float:
        """Return the skewness of many values over its standard deviation where they are normal."""
        return float(self._moments[0] * np.sqrt(len(self.values) / 6))

    @property
    def kurtosis_score(self) -> float:
        """Return the excess of the kurtosis of many values over its standard deviation where they are normal."""
        return float((self._moments[1] - NORMAL_KURTOSIS) * np.sqrt(len(self.values) / 24))

    def left_by(self, law: Callable[[np.ndarray], np.ndarray]) -> float:
        """Return the share of the squared deviation of the density from the normal one that a law leaves.

        ``law`` is the cumulative distribution function of variance 1, with the normal noise.
        """
        return self._deviation(law) / max(self._deviation(ndtr), np.finfo(float).tiny)

    def _deviation(self, law: Callable[[np.ndarray], np.ndarray]) -> float:
        """Return the mean squared relative deviation of the numbers in cells of equal probability, less chance."""
        cell = np.clip((CELLS * law(self.values)).astype(int), 0, CELLS - 1)
        relative = np.bincount(cell, minlength=CELLS) * CELLS / len(cell)
        return max(float(np.mean((relative - 1) ** 2)) - (CELLS - 1) / len(cell), 0.0)

    @cached_property
    def dependent(self) -> bool:
        """Whether the magnitudes of samples are correlated at any lag, as those of a tone or a burst are."""
        sizes = np.abs(self.values) - np.abs(self.values).mean()
        length = next_fast_len(len(sizes) + LAGS, real=True)
        products = irfft(np.abs(rfft(sizes, length)) ** 2, length)[: LAGS + 1]
        largest = np.max(np.abs(products[1:])) / products[0]
        return bool(largest > TOLERATED_CORRELATION + CHANCE / np.sqrt(len(sizes)))


def two_sided_log_p(score: float) -> float:
    """Return the log p-value of a standard normal variable, two-sided."""
    return float(np.log(2) + log_ndtr(-abs(score)))
