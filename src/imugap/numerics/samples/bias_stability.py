"""Bias and bias stability of a sequence (IEEE 1554, JJF 1535-2015)."""

import numpy as np


def period_means(sequence: np.ndarray, interval: float, period: float) -> np.ndarray:
    """Return the means over consecutive periods of length ``period`` [s], without an incomplete last one."""
    length = round(period / interval)
    count = len(sequence) // length if length else 0
    if count < 2:
        raise ValueError(
            f"bias stability: expected at least two periods of {period} s, each of at least one interval of "
            f"{interval} s; found a sequence of {len(sequence) * interval} s"
        )
    return sequence[: count * length].reshape(count, length).mean(axis=1)


def bias_stability(sequence: np.ndarray, interval: float, period: float) -> float:
    """Return the standard deviation of the period means about the mean of the run (He et al. 2023, eq. 7; ddof 1)."""
    means = period_means(sequence, interval, period)
    return float(np.sqrt(np.sum((means - sequence.mean()) ** 2) / (len(means) - 1)))
