"""Messages of a receiver in a PX4 log: ``vehicle_gps_position``, or ``sensor_gps``, of either generation of fields.

Fields: msg/SensorGps.msg of PX4; accuracies are taken for standard deviations of each axis.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.formats import ulog
from imugap.kinematics.strapdown import VELOCITY
from imugap.log import TIME, LogError
from imugap.units import factor

MESSAGES = ("vehicle_gps_position", "sensor_gps")
FIELDS = (
    {
        "latitude": "latitude_deg",
        "longitude": "longitude_deg",
        "height": "altitude_ellipsoid_m",
        "sea": "altitude_msl_m",
    },
    {"latitude": "lat", "longitude": "lon", "height": "alt_ellipsoid", "sea": "alt"},
)
"""Fields of the position in degrees and metres; before version 1.15 in 1e-7 degrees and millimetres."""
SCALES = (
    {"latitude": 1.0, "longitude": 1.0, "height": 1.0, "sea": 1.0},
    {"latitude": 1e-7, "longitude": 1e-7, "height": 1e-3, "sea": 1e-3},
)
ACCURACIES = {"sd_n": "eph", "sd_e": "eph", "sd_d": "epv"} | dict.fromkeys(
    ("sd_vel_n", "sd_vel_e", "sd_vel_d"), "s_variance_m_s"
)
THREE_D, FIXED = 3, 6
"""Least and largest type of a fix that has a measured height."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as a PX4 log."""
    return ulog.recognises(path, head)


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of one message on the clock of the log; LogError where there is none."""
    name, data = ulog.message_of(path, MESSAGES, settings.topic, "--fixes-topic")
    used = (data["fix_type"] >= THREE_D) & (data["fix_type"] <= FIXED)
    data = {field: np.asarray(values[used], float) for field, values in data.items()}
    table = _position(path, name, data)
    notes = [f"message {name}, time since boot"]
    if not used.all():
        notes.append(f"left out {np.count_nonzero(~used)} without a fix in three dimensions")
    if not table["height"].any() and table["sea"].any():
        table["height"] = table["sea"]
        notes.append("heights above sea level")
    table = table.drop(columns="sea")
    if data.get("vel_ned_valid", np.zeros(1)).any():
        for column in VELOCITY:
            table[column] = np.where(data["vel_ned_valid"] > 0, data[f"{column}_m_s"], np.nan)
    for column, field in ACCURACIES.items():
        if field in data and (data[field] > 0).any():
            table[column] = np.where(data[field] > 0, data[field], np.nan)
    table.index = pd.Index(data["timestamp"] * factor(ulog.TICK), name=TIME)
    return Decoded(table, tuple(notes), f"message {{}} of {name}".format)


def _position(path: Path, name: str, data: Mapping[str, np.ndarray]) -> pd.DataFrame:
    """Return latitude and longitude [deg], height above the ellipsoid and above the sea [m]."""
    for fields, scales in zip(FIELDS, SCALES, strict=True):
        if set(fields.values()) <= set(data):
            return pd.DataFrame({column: data[field] * scales[column] for column, field in fields.items()})
    expected = " or ".join(", ".join(fields.values()) for fields in FIELDS)
    raise LogError(path, f"message {name}", f"the fields {expected}", ", ".join(data)[:200])
