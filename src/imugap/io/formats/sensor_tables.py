"""Tables of the sensors of a device, each with stamps of its own, as one table of samples.

Where the stamps differ, a row holds the samples of one sensor, and the others are missing.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from imugap.io.formats.source import Source
from imugap.io.recognition.column_names import Meaning, assign, meaning
from imugap.log import TIME, LogError

GYRO = ("gyroscope", "gyro", "gyr", "uncalgyro", "gyroscopeuncalibrated", "rotationrate", "angularvelocity")
"""Names of the table of the gyroscopes, letters alone, the first is preferred."""
TOTAL, RAW = ("totalacceleration",), ("accelerometeruncalibrated", "uncalaccel")
PLAIN = (
    "accelerometer", "acceleration", "accelerometerwithg", "accelerationwithg", "accel", "acce", "acc",
)  # fmt: skip
FREE, GRAVITY = "accelerometer", "gravity"
"""Names of the tables of which one has the specific force less that of gravity, and the other that of gravity."""
ELAPSED = "seconds_elapsed"
"""Column of the logger whose accelerometer is without gravity (Sensor Logger)."""
PLATFORM, STANDARD = "platform", "standardisation"
"""What this logger says of the phone, and whether it undid the sign and the unit of Apple's accelerations."""
UNCERTAIN = "accelerometer_acceleration"
"""Name of accelerations that may have the sign of Core Motion."""
OPPOSITE = "the sign of the accelerations of iOS undone: gravity points down in them"

Tables = Mapping[str, Callable[[], Source]]
"""How the table of each sensor is opened, by its name."""


class _Table(NamedTuple):
    """Columns of one sensor: stamps and their name, samples by name, and the names of the tables."""

    stamp: str
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    tables: tuple[str, ...]


def has_sensors(names) -> bool:
    """Return whether a table of an inertial sensor is among names."""
    return bool({*map(plain, names)} & {*GYRO, *TOTAL, *PLAIN, *RAW})


def joined(path: Path, tables: Tables, metadata: Mapping[str, str], kind: str) -> Source:
    """Return the samples of the gyroscopes and accelerometers; LogError where there are none of either.

    Parameters
    ----------
    metadata
        What the logger says of the phone.
    kind
        What the tables are in the file, in the plural.
    """
    parts = [one for one in (_table(path, tables, quantity) for quantity in ("gyro", "accel")) if one is not None]
    if not parts:
        known = ", ".join(tables)[:200] or "none"
        raise LogError(path, kind, "Gyroscope or Accelerometer with columns x, y and z", known)
    names, columns = _on_one_clock([part.columns for part in parts], [part.time for part in parts])
    notes = [f"{kind} {', '.join(name for part in parts for name in part.tables)}"]
    by_name = dict(zip((parts[0].stamp, *names), columns, strict=True))
    if _of_sensor_logger(tables):
        by_name, sign = _signed(by_name, tables, metadata)
        notes += sign
    return in_memory(path, tuple(by_name), list(by_name.values()), tuple(notes))


def in_memory(path, names, columns, notes, whole: frozenset[str] = frozenset()) -> Source:
    """Return columns in memory as those of a file; as numbers, texts are NaN."""

    def batches(chosen):
        yield [np.full(len(columns[k]), np.nan) if columns[k].dtype.kind == "U" else columns[k] for k in chosen]

    def texts(column):
        yield columns[column].astype(str)

    whole = whole | {name for name, values in zip(names, columns, strict=True) if values.dtype.kind == "i"}
    return Source(path, tuple(names), len(columns[0]), batches, notes=notes, heading="names", whole=whole, cells=texts)


def plain(name: str) -> str:
    """Return the letters of the name of a table, without its ending."""
    return "".join(one for one in Path(name).stem.lower() if one.isalpha())


def _of_sensor_logger(tables: Tables) -> bool:
    return any(plain(name) in (FREE, *RAW) and ELAPSED in tables[name]().names for name in tables)


def _signed(
    columns: Mapping[str, np.ndarray], tables: Tables, metadata: Mapping[str, str]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return accelerations of Sensor Logger as specific forces, where what it says of the phone decides their sign."""
    platform, standard = metadata.get(PLATFORM, "").lower(), metadata.get(STANDARD, "").lower() == "true"
    if platform == "android" or standard or {*map(plain, tables)} & {*TOTAL}:
        return dict(columns), []
    if platform == "ios":
        opposite = {name: -values for name, values in columns.items() if name.startswith("accel")}
        return {**columns, **opposite}, [OPPOSITE]
    return {name.replace("accel", UNCERTAIN): values for name, values in columns.items()}, []


def _table(path: Path, tables: Tables, kind: str) -> _Table | None:
    """Return the samples of the gyroscopes or accelerometers, with gravity where any table has it."""
    by_name = {plain(name): name for name in tables}
    names = GYRO if kind == "gyro" else (*TOTAL, *PLAIN, *RAW)
    name = next((by_name[one] for one in names if one in by_name), None)
    if name is None:
        return None
    one = _read(path, tables, name, kind)
    if plain(name) != FREE or one.stamp != TIME or ELAPSED not in tables[name]().names:
        return one
    if RAW[0] in by_name:
        return _read(path, tables, by_name[RAW[0]], kind)
    if GRAVITY in by_name:
        other = _read(path, tables, by_name[GRAVITY], kind)
        if np.array_equal(one.time, other.time) and one.columns.keys() == other.columns.keys():
            summed = {axis: values + other.columns[axis] for axis, values in one.columns.items()}
            return _Table(one.stamp, one.time, summed, (f"{name} + {by_name[GRAVITY]}",))
    return one


def _read(path: Path, tables: Tables, name: str, kind: str) -> _Table:
    source = tables[name]()
    known = {column: one for column in source.names if (one := _meaning(column, kind)) is not None}
    times = [TIME] if TIME in source.names else list(assign(source.names).times)
    if not known or not times:
        expected = "columns of a time, x, y and z"
        raise LogError(path, f"{name}, {source.heading}", expected, ", ".join(source.names)[:120])
    least = min(one.rank for one in known.values())
    known = {column: one for column, one in known.items() if one.rank == least}
    block, time = source.load([source.names.index(one) for one in known], source.names.index(times[0]))
    of_phone = ELAPSED in source.names or Path(name).suffix
    usual = " [rad/s]" if kind == "gyro" and of_phone else ""  # that of the platforms of phones
    units = {column: f" [{one.unit}]" if one.unit else usual for column, one in known.items()}
    names = [f"{kind}_{'xyz'[one.axis]}{units[column]}" for column, one in known.items()]
    return _Table(times[0], time, dict(zip(names, block, strict=True)), (name,))


def _meaning(column: str, kind: str) -> Meaning | None:
    """Return what a column of the table of a sensor holds, its name or that after the name of the sensor."""
    found = meaning(column)
    found = found if found is not None and found.quantity == kind else meaning(f"{kind} {column}")
    return found if found is not None and found.quantity == kind and found.axis is not None else None


def _on_one_clock(
    tables: list[Mapping[str, np.ndarray]], times: list[np.ndarray]
) -> tuple[list[str], list[np.ndarray]]:
    """Return the names of the samples, and stamps and samples on the stamps of all tables, NaN where there are none."""
    stamps = np.unique(np.concatenate(times))
    alike = all(np.array_equal(time, times[0]) for time in times)
    names, columns = [], [times[0] if alike else stamps]
    for table, time in zip(tables, times, strict=True):
        rows = np.searchsorted(stamps, time)
        for name, values in table.items():
            names.append(name)
            spread = np.full(len(stamps), np.nan)
            spread[rows] = values
            columns.append(values if alike else spread)
    return names, columns
