"""ArduPilot logs (``.bin``): recognised, but not read; the one package that reads them installs 48 MB of dialects."""

from pathlib import Path

from imugap.io.formats.source import Source
from imugap.log import LogError

MAGIC = b"\xa3\x95\x80"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as an ArduPilot log."""
    return head.startswith(MAGIC)


def open_source(path: Path, settings) -> Source:
    """Raise a LogError with the command of pymavlink that writes the samples as CSV, which is read."""
    expected = f"its samples as CSV (mavlogdump.py --types IMU --format csv {path.name} > imu.csv)"
    raise LogError(path, "file", expected, "a dataflash log of ArduPilot")
