"""ArduPilot logs as text (``.log``): the lines of one message, ``IMU`` unless another is asked for.

The lines ``FMT`` name the columns of each message. Of several devices the number in the column ``I`` is the topic.
"""

from collections.abc import Iterator
from pathlib import Path

from imugap.io.formats import text
from imugap.io.formats.source import Source
from imugap.log import LogError

FORMAT = "FMT"
MESSAGE = "IMU"
NAMED = 5
"""Values of a line ``FMT`` before the names: itself, type, length, name of the message, format of the values."""
UNITS = {"Gyr": "rad/s", "Acc": "m/s^2", "TimeUS": "us"}
"""Begin of the names of columns, and their unit."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a text begins with the formats of messages."""
    return head.startswith(f"{FORMAT},".encode())


def open_source(path: Path, settings) -> Source:
    """Return the columns of the message; LogError where the log has none of it."""
    with path.open(encoding="utf-8", errors="replace") as handle:
        lines = _lines(path, handle)
        return text.of_lines(path, lines)


def _lines(path: Path, lines) -> Iterator[str]:
    """Yield the names of the columns and the values of the lines of the message."""
    names = None
    for line in lines:
        tag, _, rest = line.partition(",")
        if tag == FORMAT:
            cells = [cell.strip() for cell in line.split(",")]
            names = cells[NAMED:] if cells[NAMED - 2] == MESSAGE else names
            if cells[NAMED - 2] == MESSAGE:
                yield ",".join(map(_named, names)) + "\n"
        elif tag == MESSAGE and names is not None:
            yield rest.lstrip()
    if names is None:
        raise LogError(path, "messages", f"the message {MESSAGE}", "none")


def _named(name: str) -> str:
    unit = next((unit for begin, unit in UNITS.items() if name.startswith(begin)), None)
    return f"{name} [{unit}]" if unit else name
