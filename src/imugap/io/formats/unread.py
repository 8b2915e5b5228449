"""Spreadsheets, HDF5, pickles and Feather: recognised, but not read; the error says what to save instead."""

from pathlib import Path

from imugap.io.formats.archive import members
from imugap.io.formats.source import Source
from imugap.log import LogError

SPREADSHEET = "a spreadsheet (save the sheet as CSV)"
KINDS = {
    b"\xd0\xcf\x11\xe0": SPREADSHEET,
    b"\x89HDF\r\n\x1a\n": "HDF5 (write its arrays as CSV, Parquet or .npz)",
    b"ARROW1": "Feather (write Parquet)",
    b"\x80\x04": "a pickle, which would run as code (write Parquet or .npz)",
    b"\x80\x05": "a pickle, which would run as code (write Parquet or .npz)",
}
"""What a file with this begin is."""
SHEETS = "xl/", "content.xml"
"""Begin of the names in an archive that is a spreadsheet."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is one of these."""
    return _kind(path, head) is not None


def open_source(path: Path, settings) -> Source:
    """Raise a LogError with what to save instead."""
    with path.open("rb") as handle:
        found = _kind(path, handle.read(len(max(KINDS, key=len))))
    raise LogError(path, "file", "a log in a known format", found or "none")


def _kind(path: Path, head: bytes) -> str | None:
    names = members(path, head)
    if names is not None:
        return SPREADSHEET if any(name.startswith(SHEETS) for name in names) else None
    return next((kind for begin, kind in KINDS.items() if head.startswith(begin)), None)
