"""Shocks of a device at rest: brief bursts on several axes at once, which are motion and no error of the sensor."""

from collections.abc import Mapping

import numpy as np

from imugap.estimation.screening import knocked
from imugap.log import ACCEL, GYRO
from imugap.numerics.runs import runs_of
from imugap.stream import stream

MIN_AXES = 3
"""Fewest axes on which a burst is a shock; of both sensors, where the log has both."""
MAX_DURATION_S = 2.0
"""Longest shock [s]."""


def common_shocks(outputs: Mapping[str, np.ndarray], interval: float) -> np.ndarray:
    """Return the samples of shocks of a device at rest, shape (n,).

    Parameters
    ----------
    outputs
        Samples of each axis, shape (n,) each; NaN where lost.
    interval
        Sampling interval [s].
    """
    masks = {axis: knocked(values, stream(0, "shocks", axis)) for axis, values in outputs.items()}
    anywhere = np.any(list(masks.values()), axis=0)
    shocks = np.zeros(len(anywhere), bool)
    for first, end in runs_of(anywhere):
        seen = {axis for axis, mask in masks.items() if mask[first:end].any()}
        if (end - first) * interval <= MAX_DURATION_S and _is_shock(seen, set(masks)):
            shocks[first:end] = True
    return shocks


def _is_shock(seen: set[str], known: set[str]) -> bool:
    """Return whether a burst on some axes is a shock, of the axes that the log has."""
    both = all(seen & set(sensor) for sensor in (GYRO, ACCEL) if known & set(sensor))
    return len(seen) >= MIN_AXES and both
