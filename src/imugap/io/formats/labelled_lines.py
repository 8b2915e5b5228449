"""Text with a label before each number, as microcontrollers print it: ``ax:0.1,ay:0.2``, ``Gyro X: 0.1, Y: 0.2 rad/s``.

The labels are the names of columns. A single axis continues the label before it, a unit behind the last number of a
line is that of the line, and a record ends where its first label stands again.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from imugap.io.formats.source import Source
from imugap.io.recognition.column_names import LETTERS, meaning
from imugap.io.recognition.unit_text import looks_like_unit
from imugap.log import LogError

HEAD_BYTES = 1 << 14
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
PAIR = re.compile(rf"([A-Za-z][\w./²^-]*(?: [A-Za-z][\w./²^-]*)?)\s*[:=]\s*({NUMBER})(?![\w.:])")
"""A label of one or two words, and its number."""
UNIT = re.compile(rf"[:=]\s*{NUMBER}\s+([^\s,;:=]+)\s*$")
"""The unit behind the last number of a line."""
SHARE = 0.3
"""Share of the lines at the begin that hold such pairs; messages may stand between the records."""
BATCH = 20_000
"""Records in a batch."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether most lines of a text hold labels with a number, some of them of an inertial sensor."""
    if path.is_dir() or b"\x00" in head:
        return False
    lines = _head(path)
    held = [line for line in lines if PAIR.search(line)]
    return len(held) > SHARE * len(lines) and any(
        (found := meaning(name)) is not None and found.axis is not None for name in _record(held)[0]
    )


def open_source(path: Path, settings) -> Source:
    """Return the columns of all records; LogError with the first line whose labels are others."""
    held = [line for line in _head(path) if PAIR.search(line)]
    names, labels, lines = _record(held)

    def batches(columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
        rest = _records(path, labels)
        while records := list(islice(rest, BATCH)):
            table = np.array(records, float).T
            yield [table[k] for k in columns]

    with path.open("rb") as handle:
        rows = sum(1 for _ in handle) // lines + 1
    return Source(path, names, rows, batches, "record {}".format, heading="labels")


def _head(path: Path) -> list[str]:
    """Return the first lines that are not empty."""
    with path.open(encoding="utf-8", errors="replace") as handle:
        lines = handle.read(HEAD_BYTES).splitlines()
    return [line for line in lines[: max(len(lines) - 1, 1)] if line.strip()]


def _record(held: list[str]) -> tuple[tuple[str, ...], list[str], int]:
    """Return the names of columns, the labels of a record, and the number of its lines."""
    names: list[str] = []
    labels: list[str] = []
    stem: list[str] = []
    for count, line in enumerate(held):
        found = [label for label, _ in PAIR.findall(line)]
        if labels and found[0] == labels[0]:
            return tuple(names), labels, count
        unit = UNIT.search(line)
        known = f" [{unit[1]}]" if unit and looks_like_unit(unit[1]) else ""
        for label in found:
            *words, last = label.split()
            stem = words if last.lower() in LETTERS and words else stem if label.lower() in LETTERS else []
            names.append(" ".join([*stem, last] if label.lower() in LETTERS else [label]) + known)
        labels += found
    return tuple(names), labels, max(len(held), 1)


def _records(path: Path, labels: list[str]) -> Iterator[list[str]]:
    """Yield the numbers of each whole record."""
    found: list[tuple[str, str]] = []
    with path.open(encoding="utf-8", errors="replace") as handle:
        for number, line in enumerate(handle, 1):
            pairs = PAIR.findall(line) if line.endswith("\n") else []
            if not pairs:
                continue
            found += pairs
            if [label for label, _ in found] != labels[: len(found)]:
                expected = f"the labels {', '.join(labels)}"
                raise LogError(path, f"line {number}", expected, ", ".join(label for label, _ in pairs)[:120])
            if len(found) == len(labels):
                yield [value for _, value in found]
                found = []
