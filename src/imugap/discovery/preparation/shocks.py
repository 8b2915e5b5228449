"""Shocks of a device at rest: brief disturbances of several axes at once, which are motion and no error of the sensor.

Outliers of single axes coincide by chance. A disturbance is a shock where so many axes are disturbed together less than
once in :data:`CHANCE` logs, were the axes independent.
"""

from collections.abc import Mapping

import numpy as np

from imugap.estimation.screening import disturbed
from imugap.log import ACCEL, GYRO
from imugap.numerics.samples.runs import runs_of
from imugap.stream import stream

MIN_AXES = 3
"""Fewest axes on which a burst is a shock; of both sensors, where the log has both."""
MAX_DURATION_S = 2.0
"""Longest shock [s]."""
CHANCE = 1e-3
"""Most coincidences of independent axes that are expected in the log."""


def common_shocks(outputs: Mapping[str, np.ndarray], interval: float) -> np.ndarray:
    """Return the samples of shocks of a device at rest, shape (n,).

    Parameters
    ----------
    outputs
        Samples of each axis, shape (n,) each; NaN where lost.
    interval
        Sampling interval [s].
    """
    masks = {axis: disturbed(values, stream(0, "shocks", axis)) for axis, values in outputs.items()}
    places = runs_of(np.any(list(masks.values()), axis=0))
    shocks = np.zeros(len(next(iter(masks.values()))), bool)
    shares = {axis: len(runs_of(mask)) / len(mask) for axis, mask in masks.items()}
    for first, end in places:
        seen = {axis for axis, mask in masks.items() if mask[first:end].any()}
        coincidences = len(places) * np.prod(sorted((end - first) * shares[axis] for axis in seen)[:-1])
        if (end - first) * interval <= MAX_DURATION_S and _is_shock(seen, set(masks)) and coincidences < CHANCE:
            shocks[first:end] = True
    return shocks


def _is_shock(seen: set[str], known: set[str]) -> bool:
    """Return whether a burst on some axes is a shock, of the axes that the log has."""
    both = all(seen & set(sensor) for sensor in (GYRO, ACCEL) if known & set(sensor))
    return len(seen) >= MIN_AXES and both
