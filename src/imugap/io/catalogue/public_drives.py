"""Recorded drives and flights of the catalogue: device and receiver on one clock, in the axes of the vehicle, in SI.

One function per format. Corrected are the properties of the device that the publisher documents: its mounting, the
clock of its stamps, biases that were subtracted on board.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from imugap import log
from imugap.io import gnss
from imugap.io.catalogue.datasets import DataSet
from imugap.kinematics.strapdown import ATTITUDE, VELOCITY
from imugap.log import ACCEL, AXES, GYRO, LogError
from imugap.numerics.rotation import from_euler
from imugap.units import to_si

CAR_MOUNTING = np.radians([180.0, -6.79, 185.35])
"""Roll, pitch, heading by which the axes of the vehicle become those of the device (the publisher's settings)."""
CAR_LAG_S = 0.125
"""Time by which the stamps of the device are late (the publisher's settings)."""
CAR_LEVER_M = (0.0, -0.05, 0.0)
POS_COLUMNS = {"latitude": 2, "longitude": 3, "height": 4, "vel_n": 15, "vel_e": 16, "vel_d": 17, "sd_n": 7, "sd_e": 8,
               "sd_d": 9, "sd_vel_n": 18, "sd_vel_e": 19, "sd_vel_d": 20}  # fmt: skip
"""Columns of an RTKLIB solution, by word of a line; ``vel_d`` is positive up there."""
TAG_START = struct.Struct("<64xId")
"""Header of an RTKLIB time tag: start time in seconds and their fraction."""
FLIGHT_LATENCY_S = 0.075
"""Latency of a fix in the log (mean of published estimates)."""
FLIGHT_BEGIN_S = 120.0
"""Begin of the flight; before, the aircraft is carried and does not point along its course [s]."""
FEWEST_SATELLITES = 4


@dataclass(frozen=True, eq=False)
class PublicDrive:
    """Log in the axes of the vehicle, fixes, and the solution of a filter on board, if any.

    Attributes
    ----------
    log, fixes
        On the clock of the device, corrected for the known latency of the fixes.
    aboard
        Index ``time`` [s], columns :data:`imugap.kinematics.strapdown.VELOCITY` and
        :data:`imugap.kinematics.strapdown.ATTITUDE`; or None.
    lever_m
        Lever arm from the device to the antenna [m].
    """

    log: pd.DataFrame
    fixes: pd.DataFrame
    aboard: pd.DataFrame | None
    lever_m: tuple[float, float, float]


def read_car(log_path: str | Path, clock_path: str | Path, fixes_path: str | Path, dataset: DataSet) -> PublicDrive:
    """Read a drive of ``rtklibexplorer_drive``: samples with a counter [ms], a time tag, and a solution of RTKLIB.

    The first and the last row of the samples, which may be incomplete, are dropped.
    """
    rows = pd.read_csv(log_path, header=None).iloc[1:-1].to_numpy(dtype=float)
    if rows.shape[1] != len(dataset.columns) + 1:
        raise LogError(log_path, "columns", f"{len(dataset.columns) + 1}", str(rows.shape[1]))
    head = Path(clock_path).read_bytes()[: TAG_START.size]
    if len(head) < TAG_START.size:
        raise LogError(clock_path, "file", f"a head of {TAG_START.size} bytes", f"{len(head)} bytes")
    seconds, fraction = TAG_START.unpack(head)
    words = pd.read_csv(fixes_path, sep=r"\s+", comment="%", header=None)
    due = pd.to_datetime(words[0] + " " + words[1]) - pd.Timestamp(seconds, unit="s")
    start = fraction - CAR_LAG_S
    turn = from_euler(CAR_MOUNTING).inv()
    columns = dict(zip(dataset.columns, rows.T, strict=False))
    parts = [
        turn.apply(np.column_stack([to_si(columns[axis], unit) for axis in triad]))
        for triad, unit in ((GYRO, dataset.gyro_unit), (ACCEL, dataset.accel_unit))
    ]
    time = (rows[:, -1] - rows[0, -1]) / 1e3 + 1 / dataset.rate_hz
    table = pd.DataFrame(np.hstack(parts), index=pd.Index(time, name=log.TIME), columns=list(AXES))
    fixes = pd.DataFrame({name: words[column].to_numpy(float) for name, column in POS_COLUMNS.items()})
    fixes["vel_d"] *= -1
    fixes[["latitude", "longitude"]] = to_si(fixes[["latitude", "longitude"]], "deg")
    fixes.index = pd.Index(due.dt.total_seconds().to_numpy() - start, name=log.TIME)
    return PublicDrive(log.check(table, log_path), gnss.check(fixes, fixes_path), None, CAR_LEVER_M)


def read_flight(path: str | Path) -> PublicDrive:
    """Read the flight of ``thor_flight75``, with the biases added that were subtracted on board.

    A fix is new where its time of week changes. The time before :data:`FLIGHT_BEGIN_S` is dropped.
    """
    from scipy.io import loadmat

    found = loadmat(path, squeeze_me=True, struct_as_record=False)
    if "flight_data" not in found:
        raise LogError(path, "structure", "flight_data", ", ".join(name for name in found if name[:2] != "__"))
    data = found["flight_data"]
    valid = np.flatnonzero(np.linalg.norm([data.ax, data.ay, data.az], axis=0) > 1)
    first = valid[0]
    names = dict(zip(AXES, ("p", "q", "r", "ax", "ay", "az"), strict=True))
    columns = {axis: (getattr(data, name) + getattr(data, f"{name}_bias"))[first:] for axis, name in names.items()}
    time = pd.Index(data.time[first:] - data.time[first], name=log.TIME)
    new = np.flatnonzero((np.diff(data.GPS_TOW) != 0) & (data.satVisible[1:] >= FEWEST_SATELLITES)) + 1
    fixes = pd.DataFrame({
        "latitude": to_si(data.lat[new], "deg"), "longitude": to_si(data.lon[new], "deg"), "height": data.alt[new],
        "vel_n": data.vn[new], "vel_e": data.ve[new], "vel_d": data.vd[new],
    })  # fmt: skip
    fixes.index = pd.Index(data.time[new] - data.time[first] - FLIGHT_LATENCY_S, name=log.TIME)
    aboard = [getattr(data, name)[first:] for name in ("navvn", "navve", "navvd", "phi", "theta", "psi")]
    known = pd.DataFrame(np.column_stack(aboard), index=time, columns=[*VELOCITY, *ATTITUDE])
    table = log.check(pd.DataFrame(columns, index=time), path)
    parts = (one.loc[FLIGHT_BEGIN_S:] for one in (table, gnss.check(fixes, path), known))
    return PublicDrive(*parts, (0.0, 0.0, 0.0))
