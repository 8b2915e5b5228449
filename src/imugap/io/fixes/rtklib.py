"""Solutions of RTKLIB (``.pos``): geodetic positions in degrees, time as a date or as week and seconds.

Times are converted to UTC, the scale of seconds since 1970.
"""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.gps_time import GPS_EPOCH_S, WEEK_S, utc
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.log import TIME, LogError

COLUMNS = {
    "latitude(deg)": "latitude", "longitude(deg)": "longitude", "height(m)": "height", "sdn(m)": "sd_n",
    "sde(m)": "sd_e", "sdu(m)": "sd_d", "vn(m/s)": "vel_n", "ve(m/s)": "vel_e", "vu(m/s)": "vel_u",
    "sdvn": "sd_vel_n", "sdve": "sd_vel_e", "sdvu": "sd_vel_d",
}  # fmt: skip
SYSTEMS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "GPST": utc, "UTC": lambda time: time, "JST": lambda time: time - 9 * 3600,
}  # fmt: skip
"""Time systems, each with its conversion to UTC [s]."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins with the comments of RTKLIB, which name a time system."""
    lines = head.splitlines()
    return any(line.startswith(b"%") and any(one.encode() in line.split() for one in SYSTEMS) for line in lines)


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of a solution; LogError for another time system, or positions not geodetic in degrees."""
    text = path.read_text(errors="replace").replace(",", " ")
    header = next((line for line in text.splitlines() if line.startswith("%") and "(m)" in line), "%")
    system, *names = header.lstrip("% ").split()
    if not set(list(COLUMNS)[:3]) <= set(names):
        raise LogError(path, "header", "positions as latitude(deg) longitude(deg) height(m)", " ".join(names)[:120])
    if system not in SYSTEMS:
        raise LogError(path, "header", f"a time system, {' or '.join(SYSTEMS)}", system)
    rows = "\n".join(line for line in text.splitlines() if line[:1] != "%")
    words = pd.read_csv(io.StringIO(rows), sep=r"\s+", header=None)
    table = words[range(2, min(len(names) + 2, words.shape[1]))].set_axis(names[: words.shape[1] - 2], axis=1)
    table = table[[name for name in COLUMNS if name in table]].astype(float).rename(columns=COLUMNS)
    if "vel_u" in table:
        table["vel_d"] = -table.pop("vel_u")
    if words[0].dtype.kind in "iuf":
        time = words[0] * WEEK_S + words[1] + GPS_EPOCH_S
    else:
        due = pd.to_datetime(words[0] + " " + words[1], format="%Y/%m/%d %H:%M:%S.%f")
        time = (due - pd.Timestamp(0)).dt.total_seconds()
    table.index = pd.Index(SYSTEMS[system](time.to_numpy(float)), name=TIME)
    converted = "UTC" if system == "UTC" else f"{system} -> UTC"
    return Decoded(table, (f"RTKLIB, {converted} in seconds since 1970",))
