"""Block bootstrap: confidence intervals of the mean of a correlated series."""

from dataclasses import dataclass

import numpy as np

RESAMPLES = 2000
FEWEST = 6
"""Fewest blocks for an interval."""


@dataclass(frozen=True)
class Mean:
    """Mean of a series, its interval (infinite where there are too few blocks), and the number of blocks."""

    value: float
    low: float
    high: float
    blocks: int

    @property
    def differs(self) -> bool:
        """Return whether zero is outside of the interval."""
        return self.low > 0 or self.high < 0


def decorrelation(series: np.ndarray) -> int:
    """Return the first lag at which the autocorrelation of ``series``, shape (n,), is not above zero; 1 or more."""
    from scipy.signal import correlate  # takes half a second to import

    centred = series - series.mean()
    correlation = correlate(centred, centred, method="fft")[len(series) - 1 :]
    through = np.flatnonzero(correlation <= 1e-9 * correlation[0])
    return int(max(through[0], 1)) if len(through) else len(series)


def mean(series: np.ndarray, rng: np.random.Generator, block: int | None = None, level: float = 0.95) -> Mean:
    """Return the mean of ``series``, shape (n,), with its interval by the circular block bootstrap.

    Politis and Romano (1992), A circular block-resampling procedure for stationary data. ``block`` is the length of the
    blocks: 1 for independent values; None for :func:`decorrelation`.
    """
    series = np.asarray(series, float)
    length = decorrelation(series) if block is None else block
    blocks, middle = len(series) // length, float(series.mean())
    if blocks < FEWEST:
        return Mean(middle, -np.inf, np.inf, blocks)
    sums = np.cumsum(np.concatenate([[0.0], series, series[: length - 1]]))
    means = (sums[length:] - sums[:-length]) / length
    drawn = means[rng.integers(len(means), size=(RESAMPLES, blocks))].mean(axis=1)
    low, high = np.quantile(drawn, [(1 - level) / 2, (1 + level) / 2])
    return Mean(middle, float(low), float(high), blocks)
