"""Names of what is in a zip archive, by which a format that comes as one is recognised."""

import zipfile
from pathlib import Path

BEGIN = b"PK\x03\x04"
"""Begin of an archive with anything in it."""


def members(path: Path, head: bytes) -> tuple[str, ...] | None:
    """Return the names in an archive, none where it is damaged; None for a file that is no archive."""
    if not head.startswith(BEGIN) or not zipfile.is_zipfile(path):
        return None
    try:
        with zipfile.ZipFile(path) as archive:
            return tuple(archive.namelist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return ()
