"""Remove the noise of the readings of temperature, which is not a variation of the sensor's temperature."""

import numpy as np
from scipy.ndimage import uniform_filter1d

MIN_MEANS_PER_LOG = 20
"""Minimum number of readings of the log over those of the widest mean."""
MIN_READINGS = 4
"""Minimum number of readings for an estimate of their noise."""


def smoothed(readings: np.ndarray) -> np.ndarray:
    """Smooth readings [degC], shape (n,), by a running mean of the width of least prediction error.

    Cross-validation (Stone 1974, doi:10.1111/j.2517-6161.1974.tb00994.x): of means over 1, 2, 4, ... neighbours on each
    side, the one that predicts the readings between them best. Where the nearest neighbours do, the differences are no
    noise, and the readings are returned unchanged.
    """
    if len(readings) < MIN_READINGS:
        return readings
    halves = 2 ** np.arange(int(np.log2(max(len(readings) / (2 * MIN_MEANS_PER_LOG), 1))) + 1)
    best = int(np.argmin([_left(readings, half) for half in halves]))
    return readings if best == 0 else _mean(readings, int(halves[best]))


def _left(readings: np.ndarray, half: int) -> float:
    """Return the mean square error of the readings predicted by their neighbours."""
    return float(np.mean(((readings - _mean(readings, half)) * (2 * half + 1) / (2 * half)) ** 2))


def _mean(readings: np.ndarray, half: int) -> np.ndarray:
    """Return the mean over ``half`` neighbours on each side; the log is extrapolated linearly at its ends."""
    steps = np.arange(min(2 * half + 1, len(readings)))
    first, last = (np.polyfit(steps, part[: len(steps)], 1) for part in (readings, readings[::-1]))
    beyond = -np.arange(1.0, half + 1)
    padded = np.r_[np.polyval(first, beyond)[::-1], readings, np.polyval(last, beyond)]
    return uniform_filter1d(padded, 2 * half + 1)[half : half + len(readings)]
