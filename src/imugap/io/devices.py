"""Rows of several devices in one table, where a column says of which device each row is."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from imugap.io.formats.source import Source, whole_file
from imugap.io.recognition.column_names import words_of
from imugap.log import LogError

NAMING = frozenset([
    "id", "instance", "device", "sensor", "address", "addr", "mac", "node", "imu", "serial", "number", "tag", "i",
    "name", "source", "topic", "side", "foot", "location", "label",
])  # fmt: skip
"""Words of the name of such a column; it has no others."""
ROWS = 2000
"""Rows at the begin of a file that show whether it has several devices."""
SHOWN = 8
RECURRENCE = 4
"""Fewest rows of a device there, on average."""


def one_device(source: Source, topic: str | None) -> Source:
    """Return the rows of the device ``topic``, or all where no column names devices; LogError where it decides."""
    _require_one_sensor(source)
    for column in (k for k, name in enumerate(source.names) if _names_devices(name)):
        with whole_file(source.path):
            known = _devices(source, column)
        if len(known) < 2:
            continue
        if topic not in known:
            expected = f"one device, or --topic with one of them: {', '.join(known)}"
            found = "rows of several, one among the other" if topic is None else repr(topic)
            raise LogError(source.path, f"column {source.names[column]}", expected, found)
        return _rows_of(source, column, topic)
    return source


def _require_one_sensor(source: Source) -> None:
    """Raise a LogError where the first word of each line names a sensor, and the columns are those of one of them."""
    name = source.names[0]
    if not any(one.isalpha() for one in name):
        return
    with whole_file(source.path):
        tags = [one for one in _devices(source, 0) if one.isidentifier()]
    if len(tags) > 1 and any(tag in name for tag in tags):
        expected = "lines of one sensor (a file for each first word)"
        raise LogError(source.path, source.heading, expected, f"lines of {', '.join(tags[:SHOWN])}")


def _names_devices(name: str) -> bool:
    words = [word for word in words_of(name) if not word.isdigit()]
    return bool(words) and NAMING.issuperset(words)


def _devices(source: Source, column: int) -> list[str]:
    """Return the texts in a column that recur from the first rows on; none where there are nearly as many as rows."""
    first: list[str] = []
    for batch in islice(source.texts(column), 1):
        first = batch[:ROWS].tolist()
    known = list(dict.fromkeys(one for one in first if one))
    return known if RECURRENCE * len(known) <= len(first) else []


def _rows_of(source: Source, column: int, device: str) -> Source:
    """Return the rows of a source with a text in a column."""

    def texts(other: int) -> Iterator[np.ndarray]:
        for values, devices in zip(source.texts(other), source.texts(column), strict=True):
            yield values[devices == device]

    def batches(columns):
        for values, devices in zip(source.batches(columns), source.texts(column), strict=True):
            kept = devices == device
            yield [one[kept] for one in values]

    def place(row: int) -> str:
        rows = np.flatnonzero(np.concatenate(list(source.texts(column))) == device)
        return source.place(int(rows[row]) if row < len(rows) else row)

    notes = (*source.notes, f"rows of {device}")
    return replace(source, batches=batches, cells=texts, place=place, notes=notes, topic=device)
