"""Folder or zip archive with a text file for each sensor, as the loggers of phones write them.

Each file has stamps of its own. Where they differ, a row holds the samples of one sensor, and the others are missing.
"""

import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from imugap.io.formats import text
from imugap.io.formats.source import Source
from imugap.io.recognition.column_names import Meaning, assign, meaning
from imugap.log import TIME, LogError

MAGIC = b"PK\x03\x04"
ENDING = ".csv"
GYRO = ("gyroscope", "gyro", "gyroscopeuncalibrated")
"""Names of the file of the gyroscopes, letters alone, the first is preferred."""
TOTAL, RAW = ("totalacceleration",), ("accelerometeruncalibrated",)
PLAIN = ("accelerometer", "acceleration", "accelerometerwithg", "accelerationwithg")
FREE, GRAVITY = "accelerometer", "gravity"
"""Names of the files of which one has the specific force less that of gravity, and the other that of gravity."""
ELAPSED = "seconds_elapsed"
"""Column of the logger whose accelerometer is without gravity (Sensor Logger)."""
LARGEST_BYTES = 1 << 32
"""Largest text in an archive."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a folder or an archive has texts, one of them of a sensor or alone."""
    if path.is_dir():
        names = [one.name for one in path.iterdir()]
    elif head.startswith(MAGIC) and zipfile.is_zipfile(path):
        try:
            with zipfile.ZipFile(path) as archive:
                names = [Path(one).name for one in archive.namelist() if "/meta/" not in f"/{one}"]
        except Exception:  # damaged, which is said where it is opened
            return True
    else:
        return False
    texts = [one for one in names if one.lower().endswith(ENDING)]
    return bool({*map(_plain, texts)} & {*GYRO, *TOTAL, *PLAIN, *RAW}) or len(texts) == 1


def open_source(path: Path, settings) -> Source:
    """Return the samples of the gyroscopes and accelerometers; LogError where there are none of either."""
    with files(path) as found:
        tables = {kind: _table(path, found, kind) for kind in ("gyro", "accel")}
        if not any(tables.values()) and len(found) == 1:
            return _loaded(path, text.open_source(next(iter(found.values())), settings))
    parts = [one for one in tables.values() if one is not None]
    if not parts:
        known = ", ".join(found)[:200] or "none"
        raise LogError(path, "files", "Gyroscope.csv or Accelerometer.csv with columns x, y and z", known)
    stamp = parts[0].stamp
    names, columns = _joined([part.columns for part in parts], [part.time for part in parts])
    notes = (f"files {', '.join(name for part in parts for name in part.files)}",)
    return _in_memory(path, (stamp, *names), columns, notes)


@contextmanager
def files(path: Path) -> Iterator[Mapping[str, Path]]:
    """Yield the texts of a folder or archive, by their names; those of an archive exist within the block alone."""
    if path.is_dir():
        yield {one.name: one for one in sorted(path.iterdir()) if one.suffix.lower() == ENDING and one.is_file()}
        return
    with zipfile.ZipFile(path) as archive, TemporaryDirectory() as folder:
        found = {}
        for k, member in enumerate(archive.infolist()):
            name = Path(member.filename).name
            if member.is_dir() or not name.lower().endswith(ENDING) or "/meta/" in f"/{member.filename}":
                continue
            if member.file_size > LARGEST_BYTES:
                expected = f"texts of at most {LARGEST_BYTES >> 20} MB"
                raise LogError(path, f"file {name}", expected, f"{member.file_size >> 20} MB")
            found[name] = Path(folder) / f"{k}{ENDING}"
            found[name].write_bytes(archive.read(member))
        yield found


class _Table(NamedTuple):
    """Columns of one sensor: stamps and their name, samples by name, and the names of the files."""

    stamp: str
    time: np.ndarray
    columns: Mapping[str, np.ndarray]
    files: tuple[str, ...]


def _table(path: Path, found: Mapping[str, Path], kind: str) -> _Table | None:
    """Return the samples of the gyroscopes or accelerometers, with gravity where any file has it."""
    by_name = {_plain(name): name for name in found}
    names = GYRO if kind == "gyro" else (*TOTAL, *PLAIN, *RAW)
    name = next((by_name[one] for one in names if one in by_name), None)
    if name is None:
        return None
    one = _read(path, found, name, kind)
    if _plain(name) != FREE or one.stamp != TIME or ELAPSED not in text.open_source(found[name], None).names:
        return one
    if RAW[0] in by_name:
        return _read(path, found, by_name[RAW[0]], kind)
    if GRAVITY in by_name:
        other = _read(path, found, by_name[GRAVITY], kind)
        if np.array_equal(one.time, other.time) and one.columns.keys() == other.columns.keys():
            summed = {axis: values + other.columns[axis] for axis, values in one.columns.items()}
            return _Table(one.stamp, one.time, summed, (f"{name} + {by_name[GRAVITY]}",))
    return one


def _read(path: Path, found: Mapping[str, Path], name: str, kind: str) -> _Table:
    source = text.open_source(found[name], None)
    known = {column: one for column in source.names if (one := _meaning(column, kind)) is not None}
    times = [TIME] if TIME in source.names else list(assign(source.names).times)
    if not known or not times:
        expected = "columns of a time, x, y and z"
        raise LogError(path, f"file {name}, {source.heading}", expected, ", ".join(source.names)[:120])
    block, time = source.load([source.names.index(one) for one in known], source.names.index(times[0]))
    units = {column: f" [{one.unit}]" if one.unit else " [rad/s]" * (kind == "gyro") for column, one in known.items()}
    names = [f"{kind}_{'xyz'[one.axis]}{units[column]}" for column, one in known.items()]
    return _Table(times[0], time, dict(zip(names, block, strict=True)), (name,))


def _meaning(column: str, kind: str) -> Meaning | None:
    """Return what a column of the file of a sensor holds, its name or that after the name of the sensor."""
    found = meaning(column)
    found = found if found is not None and found.quantity == kind else meaning(f"{kind} {column}")
    return found if found is not None and found.quantity == kind and found.axis is not None else None


def _joined(tables: list[Mapping[str, np.ndarray]], times: list[np.ndarray]) -> tuple[list[str], list[np.ndarray]]:
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


def _loaded(path: Path, source: Source) -> Source:
    columns = [np.concatenate(parts) for parts in zip(*source.batches(range(len(source.names))), strict=True)]
    return _in_memory(path, source.names, columns, source.notes, source.whole)


def _in_memory(path, names, columns, notes, whole: frozenset[str] = frozenset()) -> Source:
    def batches(chosen):
        yield [columns[k] for k in chosen]

    whole = whole | {name for name, values in zip(names, columns, strict=True) if values.dtype.kind == "i"}
    return Source(path, tuple(names), len(columns[0]), batches, notes=notes, heading="files", whole=whole)


def _plain(name: str) -> str:
    return "".join(one for one in Path(name).stem.lower() if one.isalpha())
