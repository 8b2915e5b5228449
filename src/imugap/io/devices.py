"""Rows of several devices in one table, where a column says of which device each row is, or their order does."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from imugap.io.formats.source import Source, whole_file
from imugap.io.recognition.column_names import words_of
from imugap.io.recognition.interleaved import Interleaved, interleaved, order_changes
from imugap.io.recognition.samples import STRETCH, STRETCHES
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


def require_one_device(source: Source, samples: Sequence[np.ndarray], stamps: Sequence[np.ndarray | None]) -> None:
    """Raise a LogError where the rows of a stretch are of devices that alternate.

    ``samples``, shape (n, axes), and ``stamps``, shape (n,) or None, of each stretch of rows.
    """
    found = next(filter(None, map(interleaved, samples, stamps)), None)
    if found is not None:
        raise LogError(source.path, "rows", f"one device ({_choices(found)})", found.evidence)


def _choices(found: Interleaved) -> str:
    """Return the readings of rows that alternate, and the options that decide."""
    one = "--rows 1/1 takes all as of one, which then vibrates at a fraction of its rate"
    if found.devices is None:
        return f"a file of each, or a column that names the device of each row; {one}"
    return f"--rows 1/{found.devices} takes the first of {found.devices} devices, and so on; {one}"


def stretches_of(rows: int) -> list[slice]:
    """Return stretches spread over rows."""
    last = max(rows - STRETCH, 0)
    begins = sorted({int(begin) for begin in np.linspace(0, last, STRETCHES if last else 1)})
    return [slice(begin, begin + STRETCH) for begin in begins]


def every_row(source: Source, columns: Sequence[int], rows: tuple[int, int]) -> Source:
    """Return one row of some, ``(1, 2)`` the first of each two; LogError where their order by ``columns`` changes."""
    number, devices = rows
    if devices == 1:
        return source
    changed = order_changes(source.load(columns, None)[0].T, devices)
    if changed is not None:
        expected = f"rows of {devices} devices in one order (a row may be lost; split the file there)"
        raise LogError(source.path, f"rows near {source.place(changed)}", expected, "another order than before")

    def batches(chosen):
        first = number - 1
        for values in source.batches(chosen):
            count = len(values[0])
            yield [one[first::devices] for one in values]
            first = (first - count) % devices

    notes = (*source.notes, f"row {number} of {devices}")
    return replace(
        source, batches=batches, cells=None, place=lambda row: source.place(row * devices + number - 1), notes=notes
    )


def _require_one_sensor(source: Source) -> None:
    """Raise a LogError where the first word of each line names a sensor, and the columns are those of one of them."""
    name = next(iter(source.names), "")
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
