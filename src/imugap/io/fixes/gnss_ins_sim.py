"""Fixes of the simulator gnss-ins-sim: ``gps_time.csv`` and ``gps-K.csv`` of run K, side by side in a folder."""

from pathlib import Path

import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.formats.gnss_ins_sim import joined, run_of, runs
from imugap.log import TIME, LogError

CLOCK, SENSORS = "gps_time", ("gps",)
COLUMNS = {
    "gps_time (sec)": TIME, "gps_lat (deg)": "latitude", "gps_lon (deg)": "longitude", "gps_alt (m)": "height",
    "gps_vN (m/s)": "vel_n", "gps_vE (m/s)": "vel_e", "gps_vD (m/s)": "vel_d",
}  # fmt: skip


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a folder or a file is output of the simulator with fixes and their stamps."""
    return bool(runs(path, CLOCK, SENSORS))


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of one run; LogError where one of several is meant, or positions are not geodetic."""
    found = runs(path, CLOCK, SENSORS)
    source = joined(path, found[run_of(path, found, settings.topic)])
    if not set(COLUMNS) <= set(source.names):
        raise LogError(path, "line 1", f"the columns {', '.join(COLUMNS)}", ", ".join(source.names))
    block, _ = source.load([source.names.index(name) for name in COLUMNS], None)
    table = pd.DataFrame(dict(zip(COLUMNS.values(), block, strict=True))).set_index(TIME)
    return Decoded(table, source.notes, source.place)
