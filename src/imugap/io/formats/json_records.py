"""Logs in JSON: an object a line, an array of objects, or arrays by name; nested names are joined by dots.

A file is read whole, in some ten times its size of memory, and at most 512 MB.
"""

import json
import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from imugap.io.formats import clock_text, sensor_tables
from imugap.io.formats.source import Source
from imugap.log import LogError

BEGIN = re.compile(rb"^(\xef\xbb\xbf)?\s*(\{\s*\"|\[\s*[\[{])")
LONGEST = 16
"""Most numbers of an array that are columns of one record."""
RECURRENCE = 4
"""Fewest records of a sensor, on average, where a text names the sensor of each."""
LARGEST_BYTES = 1 << 29
"""Largest file."""
METADATA = "metadata"
UNENDED = "left out the last line, which has no end"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as an object with a name, or an array of objects or arrays."""
    return BEGIN.match(head) is not None


def open_source(path: Path, settings) -> Source:
    """Return the columns of all records, or the samples of the sensors where a text names that of each record."""
    whole, notes = _decoded(path)
    records = _records(whole)
    if not records:
        columns = _columns_of(whole)
        if not columns:
            raise LogError(path, "JSON", "records with the names of columns, or arrays of equal length", _found(whole))
        return sensor_tables.in_memory(path, tuple(columns), list(columns.values()), notes)
    flat = [_flat(one) for one in records]
    sensor = _naming(flat)
    if sensor is None:
        table = _table(flat)
        return sensor_tables.in_memory(path, tuple(table), list(table.values()), notes)
    by_sensor: dict[str, list[dict]] = {}
    for one in flat:
        by_sensor.setdefault(str(one.get(sensor)), []).append(one)
    metadata = next((rows[0] for name, rows in by_sensor.items() if name.lower() == METADATA), {})
    tables = {name: partial(_source, path, rows) for name, rows in by_sensor.items()}
    return sensor_tables.joined(path, tables, {key: str(text) for key, text in metadata.items()}, "records")


def _decoded(path: Path) -> tuple[object, tuple[str, ...]]:
    """Return the value of a file, or those of its lines; LogError with the line that is none."""
    size = path.stat().st_size
    if size > LARGEST_BYTES:
        expected = f"JSON of at most {LARGEST_BYTES >> 20} MB, which is read whole (write CSV or Parquet)"
        raise LogError(path, "file", expected, f"{size >> 20} MB")
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    try:
        return json.loads(text), ()
    except json.JSONDecodeError as error:
        if error.msg != "Extra data":
            raise LogError(path, f"line {error.lineno}", "JSON", error.msg) from error
    values: list[object] = []
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            values.append(json.loads(line))
        except json.JSONDecodeError as error:
            if number == len(lines) and not text.endswith("\n"):
                return values, (UNENDED,)
            raise LogError(path, f"line {number}", "an object in JSON", error.msg) from error
    return values, ()


def _records(value: object) -> list[dict]:
    """Return the longest array of objects in a value."""
    if isinstance(value, list) and value and all(isinstance(one, dict) for one in value):
        inner = [_records(part) for one in value for part in one.values() if isinstance(part, list)]
        return value if len(value) > 1 or not any(inner) else max(inner, key=len)
    parts = value.values() if isinstance(value, dict) else ()
    return max((_records(part) for part in parts), key=len, default=[])


def _flat(record: Mapping, before: str = "") -> dict[str, object]:
    """Return the values of a record by their names."""
    found: dict[str, object] = {}
    for key, value in record.items():
        name = f"{before}{key}"
        if isinstance(value, dict):
            found |= _flat(value, f"{name}.")
        elif isinstance(value, list) and 0 < len(value) <= LONGEST:
            labels = (
                [f"{name}_{axis}" for axis in "xyz"] if len(value) == 3 else [f"{name}[{k}]" for k in range(len(value))]
            )
            found |= dict(zip(labels, value, strict=True))
        elif isinstance(value, str | int | float) and not isinstance(value, bool):
            found[name] = value
    return found


def _naming(records: list[dict]) -> str | None:
    """Return the name of the text that names the sensor of each record, None where none does."""
    texts: dict[str, set[str]] = {}
    for one in records:
        for name, value in one.items():
            if isinstance(value, str):
                texts.setdefault(name, set()).add(value)
    known = (
        name
        for name, values in texts.items()
        if len(values) * RECURRENCE <= len(records) and sensor_tables.has_sensors(values)
    )
    return next(known, None)


def _source(path: Path, records: list[dict]) -> Source:
    table = _table(records)
    return sensor_tables.in_memory(path, tuple(table), list(table.values()), ())


def _table(records: list[dict]) -> dict[str, np.ndarray]:
    """Return the columns of records: numbers, NaN where a record has none, times in nanoseconds, or texts."""
    names = dict.fromkeys(name for one in records for name in one)
    return {name: _values([one.get(name) for one in records]) for name in names}


def _values(cells: list[object]) -> np.ndarray:
    """Return cells as numbers, whole ones as such, as times in nanoseconds, or as texts."""
    known = [one for one in cells if one is not None]
    try:
        if len(known) == len(cells) and all(isinstance(one, int) or str(one).lstrip("-").isdecimal() for one in known):
            return np.array([int(one) for one in known], np.int64)
        return np.array([np.nan if one is None else float(one) for one in cells])
    except (ValueError, OverflowError):
        times = len(known) == len(cells) and all(isinstance(one, str) and clock_text.is_time(one) for one in known)
        return (
            clock_text.nanoseconds(pa.array(known, pa.string()))
            if times
            else np.array(["" if one is None else str(one) for one in cells])
        )


def _columns_of(value: object) -> dict[str, np.ndarray]:
    """Return arrays of equal length by name, those of the longest."""
    flat = _arrays(value) if isinstance(value, dict) else {}
    longest = max(map(len, flat.values()), default=0)
    return {name: values for name, values in flat.items() if len(values) == longest > 1}


def _arrays(value: Mapping, before: str = "") -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    for key, part in value.items():
        if isinstance(part, dict):
            found |= _arrays(part, f"{before}{key}.")
        elif isinstance(part, list) and part and all(isinstance(one, list) and len(one) == 3 for one in part):
            found |= dict(zip([f"{before}{key}_{axis}" for axis in "xyz"], np.array(part, float).T, strict=True))
        elif isinstance(part, list) and not any(isinstance(one, list | dict) for one in part):
            found[f"{before}{key}"] = _values(part)
    return found


def _found(value: object) -> str:
    return json.dumps(value)[:120]
