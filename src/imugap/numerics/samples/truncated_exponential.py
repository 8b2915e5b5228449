"""Exponential density on the unit interval."""

import numpy as np

STEEPEST = 50.0
"""Largest slope of the log-density."""


def log_slope(places: np.ndarray) -> tuple[float, float]:
    """Estimate the slope of the log-density of ``places``, shape (n,), within [0, 1]; return it and its standard error.

    Maximum likelihood: the mean of the density exp(s x) over the unit interval is 1/(1 - exp(-s)) - 1/s.
    """
    mean = places.mean()
    slope = float(np.clip(12 * (mean - 0.5), -STEEPEST, STEEPEST))
    for _ in range(30):
        expected = 1 / -np.expm1(-slope) - 1 / slope if abs(slope) > 1e-3 else 0.5 + slope / 12
        spread = 1 / slope**2 - np.exp(-slope) / np.expm1(-slope) ** 2 if abs(slope) > 1e-3 else 1 / 12
        slope = float(np.clip(slope + (mean - expected) / max(spread, 1e-6), -STEEPEST, STEEPEST))
    return slope, float(1 / np.sqrt(len(places) * max(spread, 1e-6)))
