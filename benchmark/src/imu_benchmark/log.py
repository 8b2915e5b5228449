"""Log of a device: a table over time.

Index ``time`` [s], increasing; columns from :data:`AXES` (rad/s, m/s^2, specific force at rest upward) and optionally
``temperature`` [degC].
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

GYRO = ("gyro_x", "gyro_y", "gyro_z")
ACCEL = ("accel_x", "accel_y", "accel_z")
AXES = GYRO + ACCEL
TEMPERATURE = "temperature"
TIME = "time"
"""Name of the index, and of the axis of effects on the clock."""


def from_samples(samples: Mapping[str, np.ndarray], interval_s: float) -> pd.DataFrame:
    """Make a log from columns of evenly sampled values, shape (n,); the first sample is at time zero."""
    count = len(next(iter(samples.values())))
    columns = {name: samples[name] for name in (*AXES, TEMPERATURE) if name in samples}
    return pd.DataFrame(columns, index=pd.Index(interval_s * np.arange(count), name=TIME))


def write(log: pd.DataFrame, path: str | Path) -> None:
    """Write the log as CSV, every number with all its digits."""
    log.to_csv(path)


def read(path: str | Path) -> pd.DataFrame:
    """Read a log that :func:`write` wrote."""
    return pd.read_csv(path, index_col=TIME)
