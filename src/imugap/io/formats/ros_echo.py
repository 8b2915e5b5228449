"""What ``rostopic echo`` and ``ros2 topic echo`` print of sensor_msgs/Imu: records of lines, or CSV without a header.

Records end with ``---``; nested names are joined by dots. The CSV of ``ros2 topic echo --csv`` has the fields of the
message in their order. (``rostopic echo -p`` writes a header, and is read as any table.)
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from imugap.io.formats import text
from imugap.io.formats.source import Source
from imugap.log import LogError

HEADER, END = b"header:", "---"
RATES, FORCES = "angular_velocity", "linear_acceleration"
UNITS = {RATES: "rad/s", FORCES: "m/s^2"}
"""Units by the definition of the message."""
STAMP = ("header.stamp.sec", "header.stamp.nanosec")
BATCH = 20_000
"""Records in a batch."""
COVARIANCE = 9


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a text is of such records, or its first line of the fields of sensor_msgs/Imu."""
    if path.is_dir() or b"\x00" in head:
        return False
    return head.lstrip().startswith(HEADER) or _is_fields(head.partition(b"\n")[0].decode(errors="replace"))


def open_source(path: Path, settings) -> Source:
    """Return the columns of the messages; LogError with the first record that has others."""
    with path.open(encoding="utf-8", errors="replace") as handle:
        if not handle.readline().lstrip().startswith(HEADER.decode()):
            return replace(text.open_source(path, settings), names=_fields(), whole=frozenset(STAMP))
        handle.seek(0)
        first = next(_records(handle), {})
    paths = tuple(first)
    whole = frozenset(name for name, value in first.items() if value.isdecimal() and ".stamp." in name)

    def batches(columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
        kinds = [np.int64 if paths[k] in whole else float for k in columns]
        with path.open(encoding="utf-8", errors="replace") as handle:
            rest = _alike(path, _records(handle), paths)
            while records := list(islice(rest, BATCH)):
                rows = [[record[k] for k in columns] for record in records]
                yield [np.array(values, kind) for values, kind in zip(zip(*rows, strict=True), kinds, strict=True)]

    with path.open("rb") as handle:
        rows = sum(line.startswith(END.encode()) for line in handle)
    return Source(path, tuple(map(_named, paths)), rows, batches, "message {}".format, heading="messages", whole=whole)


def _records(lines) -> Iterator[dict[str, str]]:
    """Yield the numbers of each record that has an end, by their names; lists, and texts, are left out."""
    found: dict[str, str] = {}
    above: list[tuple[int, str]] = []
    for line in lines:
        if line.startswith(END):
            yield found
            found, above = {}, []
            continue
        key, colon, value = line.rstrip().partition(":")
        name = key.lstrip()
        if not colon or name.startswith("-"):
            continue
        depth = len(key) - len(name)
        above = [one for one in above if one[0] < depth]
        value = value.strip()
        if not value:
            above.append((depth, name))
        elif text.NUMBER.fullmatch(value.lstrip(".") if value.lower() == ".nan" else value):
            found[".".join([*(one for _, one in above), name])] = value.lstrip(".") if value[:1] == "." else value


def _alike(path: Path, records: Iterator[dict[str, str]], names: tuple[str, ...]) -> Iterator[list[str]]:
    """Yield the values of records; LogError where one has other names."""
    for number, record in enumerate(records):
        if tuple(record) != names:
            other = sorted({*names} ^ {*record})
            raise LogError(path, f"message {number}", "the fields of the first message", f"{', '.join(other)[:120]}")
        yield list(record.values())


def _named(name: str) -> str:
    """Return the name of a field with its unit."""
    unit = UNITS.get(name.rpartition(".")[0].rpartition(".")[2])
    return f"{name} [{unit}]" if unit else name


def _fields() -> tuple[str, ...]:
    """Return the names of the fields of sensor_msgs/Imu; the covariances have none."""
    parts: list[str] = [*STAMP, ""]
    for name, axes in (("orientation", "xyzw"), (RATES, "xyz"), (FORCES, "xyz")):
        parts += [_named(f"{name}.{axis}") for axis in axes] + [""] * COVARIANCE
    return tuple(parts)


def _is_fields(line: str) -> bool:
    """Return whether a line has the values of these fields: whole seconds and nanoseconds, a text, and numbers."""
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) != len(_fields()) or text.NUMBER.fullmatch(cells[2]):
        return False
    return all(cell.isdecimal() for cell in cells[:2]) and all(text.NUMBER.fullmatch(cell) for cell in cells[3:])
