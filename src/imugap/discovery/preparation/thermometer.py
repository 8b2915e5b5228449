"""The temperature of a sensor by its readings, whose noise is none of the sensor's."""

import numpy as np
from scipy.ndimage import uniform_filter1d

SHARE = 20
"""Readings of the log over those of the widest mean, at least."""
FEWEST = 4
"""Readings below which there is nothing to tell noise by."""


def smoothed(readings: np.ndarray) -> np.ndarray:
    """Return readings [degC], shape (n,), as means of as many around each as tell the one between them best.

    Cross-validation (Stone 1974, doi:10.1111/j.2517-6161.1974.tb00994.x): of means over 1, 2, 4, ... neighbours on each
    side, that which leaves the least squares. Where the nearest neighbours do best, what is left is no noise, but the
    course or its steps, and the readings stay as they are.
    """
    if len(readings) < FEWEST:
        return readings
    halves = 2 ** np.arange(int(np.log2(max(len(readings) / (2 * SHARE), 1))) + 1)
    best = int(np.argmin([_left(readings, half) for half in halves]))
    return readings if best == 0 else _mean(readings, int(halves[best]))


def _left(readings: np.ndarray, half: int) -> float:
    """Return the mean square of what the neighbours, but not a reading itself, leave of it."""
    return float(np.mean(((readings - _mean(readings, half)) * (2 * half + 1) / (2 * half)) ** 2))


def _mean(readings: np.ndarray, half: int) -> np.ndarray:
    """Return the mean over ``half`` neighbours on each side; beyond its ends a log goes on as the line through them."""
    steps = np.arange(min(2 * half + 1, len(readings)))
    first, last = (np.polyfit(steps, part[: len(steps)], 1) for part in (readings, readings[::-1]))
    beyond = -np.arange(1.0, half + 1)
    padded = np.r_[np.polyval(first, beyond)[::-1], readings, np.polyval(last, beyond)]
    return uniform_filter1d(padded, 2 * half + 1)[half : half + len(readings)]
