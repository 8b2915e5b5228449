"""Catalogue of data sets: their raw files, sources and checksums, and their download.

The catalogue is two tables, ``datasets.csv`` and ``files.csv``; every row is validated against its JSON schema. Raw
files are stored in ``<folder>/<dataset>/<file>``, those of a data set that continues another one beside its files. They
are copied from a mirror of the same layout or downloaded, verified by their SHA-256 checksum, and get their name only
when complete.
"""

import csv
import errno
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from hashlib import file_digest
from math import inf
from pathlib import Path
from typing import BinaryIO
from urllib.parse import urljoin, urlsplit

import yaml

from imugap.io.strict_yaml import excerpt
from imugap.log import ACCEL, GYRO, TEMPERATURE
from imugap.units import to_si

CHUNK_BYTES = 65536
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk that takes no more: what has come of a download is in the way, and is not kept."""


class CatalogueError(ValueError):
    """Catalogue that violates its schema or is inconsistent; the message has table, line and column."""


class FetchError(RuntimeError):
    """Raw file that is not available or has a wrong checksum; the message says how to place it by hand."""


class OverlongError(Exception):
    """Download that is longer than the catalogue says."""


LOG, POSITIONS, POSES, EVENTS, FIXES, CLOCK = "log", "positions", "poses", "events", "fixes", "clock"
"""Content of a raw file: the log, possibly with the others, or one of the others alone."""


@dataclass(frozen=True)
class RawFile:
    """Raw file with ``content`` of ``runs``, in the order of the file; ``folder`` is that of its data set."""

    folder: str
    name: str
    runs: tuple[int, ...]
    size_bytes: int
    sha256: str
    url: str
    content: str = LOG

    def place(self, folder: str | Path) -> Path:
        """Return the path of the file in ``folder`` (``data/raw`` or a mirror)."""
        return Path(folder) / self.folder / self.name


@dataclass(frozen=True)
class DataSet:
    """Set of raw logs of the same rate, columns, units, frame and licence; one row of ``datasets.csv``.

    A set of the kind ``recording`` has no ``columns``: its files are read as those of a user
    (:func:`imugap.io.recording.read`).
    """

    name: str
    title: str
    kind: str
    rate_hz: float
    columns: tuple[str, ...]
    arrays: tuple[str, ...]
    reference: tuple[str, ...]
    gyro_unit: str | None
    accel_unit: str | None
    frame: str
    licence: str
    source: str
    remarks: str
    files: tuple[RawFile, ...] = ()
    positions: tuple[str, ...] = ()
    position_axes: tuple[str, ...] = ()
    position_unit: str | None = None
    position_rate_hz: float | None = None
    full_scale: float = inf
    """Full scale of the accelerometers [m/s^2]; infinite where no sample is near it."""
    continues: str | None = None
    """Data set beside whose files these are stored."""

    @property
    def runs(self) -> tuple[int, ...]:
        """Return all runs of the set, in increasing order."""
        return self.runs_with(LOG)

    def runs_with(self, content: str) -> tuple[int, ...]:
        """Return the runs with a file of ``content``, in increasing order."""
        return tuple(sorted(run for file in self.files if file.content == content for run in file.runs))

    @property
    def units(self) -> tuple[str | None, ...]:
        """Return the unit of each column in the files."""
        known = {"time": "s", TEMPERATURE: "degC"}
        known |= dict.fromkeys(GYRO, self.gyro_unit) | dict.fromkeys(ACCEL, self.accel_unit)
        return tuple(known[column] for column in self.columns)

    def file(self, run: int, content: str = LOG) -> RawFile:
        """Return the file that holds ``content`` of ``run``."""
        for file in self.files:
            if run in file.runs and file.content == content:
                return file
        runs = ", ".join(map(str, self.runs_with(content))) or f"none: no file holds {content}"
        raise CatalogueError(f"{self.name}: expected a run among {runs}; found {run!r}")


class RawFiles:
    """Verified raw files of a data set, by run and content."""

    def __init__(self, dataset: DataSet, paths: Iterable[str | Path]) -> None:
        """Verify the paths of all files of a data set; :class:`FetchError` on a wrong checksum."""
        self.dataset = dataset
        self._paths = {Path(path).name: Path(path) for path in paths}
        for file in dataset.files:
            verify(file, self._paths[file.name])

    def path(self, run: int, content: str = LOG) -> Path:
        """Return the path of the file that holds ``content`` of ``run``."""
        return self._paths[self.dataset.file(run, content).name]


def load(tables: str | Path, schemas: str | Path) -> dict[str, DataSet]:
    """Load and validate the catalogue.

    Parameters
    ----------
    tables
        Folder of ``datasets.csv`` and ``files.csv``.
    schemas
        Folder of ``datasets.schema.yaml`` and ``files.schema.yaml``.

    Returns
    -------
    dict
        Name to :class:`DataSet`, in the order of the table.
    """
    tables, schemas = Path(tables), Path(schemas)
    sets: dict[str, DataSet] = {}
    for place, row in _rows(tables / "datasets.csv", schemas / "datasets.schema.yaml"):
        if row["dataset"] in sets:
            raise CatalogueError(f"{place}, column dataset: expected a new name; found {row['dataset']!r} again")
        sets[row["dataset"]] = _data_set(row)
    for place, row in _rows(tables / "files.csv", schemas / "files.schema.yaml"):
        if row["dataset"] not in sets:
            raise CatalogueError(
                f"{place}, column dataset: expected one of {', '.join(sets)}; found {row['dataset']!r}"
            )
        owner = sets[row["dataset"]]
        file = _raw_file(row, owner.continues or owner.name)
        if not file.runs or set(file.runs) & set(owner.runs_with(file.content)):
            raise CatalogueError(f"{place}, column run: expected increasing, still free runs; found {row['run']!r}")
        sets[owner.name] = replace(owner, files=(*owner.files, file))
    empty = [name for name, owner in sets.items() if not owner.files]
    if empty:
        raise CatalogueError(f"{tables / 'files.csv'}: expected a file for every data set; found none for {empty[0]!r}")
    return sets


def available(dataset: DataSet, folder: str | Path, mirror: str | Path | None = None) -> bool:
    """Return whether every file of ``dataset`` is in ``folder`` or in ``mirror``."""
    return all(_found(file, folder, mirror) for file in dataset.files)


def locate(file: RawFile, folder: str | Path, mirror: str | Path | None = None) -> Path:
    """Return the path of ``file`` in ``folder``, else in ``mirror``; :class:`FetchError` if in neither."""
    found = _found(file, folder, mirror)
    if found is None:
        raise FetchError(_by_hand(file, folder, "not found"))
    return found


def fetch(file: RawFile, folder: str | Path, mirror: str | Path | None = None) -> Path:
    """Copy or download ``file`` into ``folder`` and return its path; an existing file is only verified.

    The file is written as ``<file>.partial`` and renamed when its checksum is right. An interrupted download is
    continued by the next call where the server supports it. An existing file with another checksum is an error, and is
    not changed.

    Parameters
    ----------
    folder
        Folder of raw logs (``data/raw``); the file is stored as ``<folder>/<dataset>/<file>``.
    mirror
        Folder of the same layout from which the file is copied, if it has it, in place of a download.
    """
    target = file.place(folder)
    if target.exists():
        if (fault := _fault(target, file)) is not None:
            raise FetchError(_by_hand(file, folder, f"{target} is another file ({fault}); it was left alone"))
        return target
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(target.name + ".partial")
    source = _found(file, folder, mirror)
    try:
        if source is not None:
            shutil.copyfile(source, partial)
        elif not partial.exists() or partial.stat().st_size < file.size_bytes:
            _download(file.url, partial, file.size_bytes)
    except OverlongError as error:
        partial.unlink()
        found = "more; what had come was removed"
        raise FetchError(_by_hand(file, folder, f"expected {file.size_bytes} bytes; found {found}")) from error
    except OSError as error:  # requests' errors are OSErrors too
        if source is not None or error.errno in FULL:
            partial.unlink(missing_ok=True)
        raise FetchError(_by_hand(file, folder, f"{type(error).__name__}: {error}")) from error
    if (fault := _fault(partial, file)) is not None:
        partial.unlink()
        raise FetchError(_by_hand(file, folder, f"{source or file.url} gave another file ({fault}); it was removed"))
    return partial.rename(target)


def verify(file: RawFile, path: str | Path) -> None:
    """Raise a :class:`FetchError` unless the file at ``path`` is the one that the catalogue names."""
    if (fault := _fault(Path(path), file)) is not None:
        raise FetchError(f"{path}: {fault}")


def _found(file: RawFile, folder: str | Path, mirror: str | Path | None) -> Path | None:
    places = [file.place(root) for root in (folder, mirror) if root]
    return next((place for place in places if place.is_file()), None)


class _Capped:
    """File that takes no more bytes than the catalogue names."""

    def __init__(self, file: BinaryIO, most: int) -> None:
        self.file, self.most, self.flush = file, most, file.flush

    def write(self, content: bytes) -> int:
        """Write, or raise an OverlongError."""
        if self.file.tell() + len(content) > self.most:
            raise OverlongError
        return self.file.write(content)


def _download(url: str, partial: Path, size_bytes: int) -> None:
    """Append the missing rest of ``url`` to ``partial``, or start again if the server sends the whole file.

    More bytes than expected are an OverlongError, a redirect to another host an OSError.
    """
    import pooch

    with partial.open("ab") as output:

        def check(response, **_) -> None:
            if response.is_redirect and _origin(urljoin(response.url, response.headers["location"])) != _origin(url):
                raise OSError(
                    f"expected an answer of {_origin(url)}; found a redirect to {response.headers['location']}"
                )
            if response.status_code == 200:  # 206 would be the range asked for
                output.truncate(0)

        # identity: a range of a compressed stream is no range of the file
        headers = {"Range": f"bytes={output.tell()}-", "Accept-Encoding": "identity"}
        download = pooch.HTTPDownloader(
            progressbar=True, chunk_size=CHUNK_BYTES, headers=headers, hooks={"response": check}
        )
        download(url, _Capped(output, size_bytes), None)


def _origin(url: str) -> str:
    """Return scheme, host and port of an address."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc}"


def _fault(path: Path, file: RawFile) -> str | None:
    """Return the difference of the file at ``path`` from the catalogued one in words, or None."""
    with path.open("rb") as content:
        found = file_digest(content, "sha256").hexdigest()
    if found == file.sha256:
        return None
    return f"expected sha256 {file.sha256}, {file.size_bytes} bytes; found {found}, {path.stat().st_size} bytes"


def _by_hand(file: RawFile, folder: str | Path, reason: str) -> str:
    return (
        f"{file.name}: {reason}. To place it by hand, get {file.url} "
        f"({file.size_bytes} bytes, sha256 {file.sha256}) and put it at {file.place(folder)}"
    )


def _rows(table: Path, schema_path: Path) -> Iterator[tuple[str, dict]]:
    """Yield (table and line, row) for each row, validated against its schema; empty cells are omitted."""
    # most that import this module load no table
    from imugap.io.configuration import explain
    from imugap.io.json_schema import Draft202012Validator

    schema = yaml.safe_load(schema_path.read_text(encoding="utf-8"))
    validator = Draft202012Validator(schema)
    with table.open(newline="", encoding="utf-8", errors="replace") as handle:
        reader = csv.DictReader(handle, restkey="", restval="")
        try:
            for cells in reader:
                place = f"{table}: line {reader.line_num}"
                _require_text(cells, place)
                row = {name: _typed(text, schema["properties"].get(name, {})) for name, text in cells.items() if text}
                for error in validator.iter_errors(row):
                    for column, expected, found in explain(error):
                        raise CatalogueError(
                            f"{place}{f', column {column}' if column else ''}: expected {expected}; found {found}"
                        )
                yield place, row
        except csv.Error as error:
            raise CatalogueError(
                f"{table}: line {reader.line_num}: expected a table; found a fault: {error}"
            ) from error


def _require_text(cells: dict, place: str) -> None:
    """Raise a CatalogueError for a cell too many, or one that is no plain text of one line."""
    for name, text in cells.items():
        if isinstance(text, list):
            raise CatalogueError(f"{place}: expected {len(cells) - 1} cells; found {len(text)} more")
        if not text.isprintable() or "\ufffd" in text:  # of what is no UTF-8
            raise CatalogueError(f"{place}, column {name}: expected plain text of one line; found {excerpt(text)}")


def _typed(text: str, schema: dict) -> str | int | float:
    try:
        return {"integer": int, "number": float}.get(schema.get("type"), str)(text)
    except ValueError:
        return text  # the validator says what was expected


def _raw_file(row: dict, folder: str) -> RawFile:
    first, _, last = row["run"].partition("-")
    runs = tuple(range(int(first), int(last or first) + 1))
    return RawFile(folder, row["file"], runs, row["bytes"], row["sha256"], row["url"], row.get("content", LOG))


def _data_set(row: dict) -> DataSet:
    return DataSet(
        name=row["dataset"],
        title=row["title"],
        kind=row["kind"],
        rate_hz=row["rate_hz"],
        columns=tuple(row.get("columns", "").split()),
        arrays=tuple(row.get("arrays", "").split()),
        reference=tuple(row.get("reference", "").split()),
        gyro_unit=row.get("gyro_unit"),
        accel_unit=row.get("accel_unit"),
        frame=row["frame"],
        licence=row["licence"],
        source=row["source"],
        remarks=row["remarks"],
        positions=tuple(row.get("positions", "").split()),
        position_axes=tuple(row.get("position_axes", "").split()),
        position_unit=row.get("position_unit"),
        position_rate_hz=row.get("position_rate_hz"),
        full_scale=to_si(row.get("accel_full_scale_g", inf), "g"),
        continues=row.get("continues"),
    )
