"""Folder or zip archive with a text file for each sensor, as the loggers of phones write them."""

import csv
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from imugap.io.formats import sensor_tables, text
from imugap.io.formats.archive import members
from imugap.io.formats.source import Source
from imugap.log import LogError

ENDING = ".csv"
METADATA = "metadata.csv"
LARGEST_BYTES = 1 << 32
"""Largest text in an archive."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a folder or an archive has texts, one of them of a sensor or alone."""
    if path.is_dir():
        names = [one.name for one in path.iterdir()]
    else:
        packed = members(path, head)
        if not packed:
            return packed is not None  # damaged, which is said where it is opened
        names = [Path(one).name for one in packed if "/meta/" not in f"/{one}"]
    texts = [one for one in names if one.lower().endswith(ENDING)]
    return sensor_tables.has_sensors(texts) or len(texts) == 1


def open_source(path: Path, settings) -> Source:
    """Return the samples of the gyroscopes and accelerometers; LogError where there are none of either."""
    with files(path) as found:
        if len(found) == 1 and not sensor_tables.has_sensors(found):
            return text.loaded(path, text.open_source(next(iter(found.values())), settings))
        tables = {name: partial(text.open_source, one, None) for name, one in found.items()}
        return sensor_tables.joined(path, tables, _metadata(found), "files")


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


def _metadata(found: Mapping[str, Path]) -> dict[str, str]:
    """Return the first row of the file of metadata by the names of its columns; nothing where there is none."""
    path = next((one for name, one in found.items() if name.lower() == METADATA), None)
    if path is None:
        return {}
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as handle:
        row = next(csv.DictReader(handle), {})
    return {name: text for name, text in row.items() if isinstance(name, str) and isinstance(text, str)}
