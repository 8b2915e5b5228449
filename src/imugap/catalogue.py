"""The catalogue of raw logs: which data sets exist, where their files come from, and how to get them unharmed.

Two tables, ``datasets.csv`` and ``files.csv``, say it all; every row is validated against its JSON schema. Raw files
live in ``<folder>/<dataset>/<file>`` and are named by their SHA-256 checksum: they are copied from a mirror of the
same layout where there is one, downloaded otherwise, and appear under their name only once they are whole.
"""

import csv
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pooch
import yaml
from jsonschema import Draft202012Validator

from imugap.log import ACCEL, GYRO, TEMPERATURE


class CatalogueError(ValueError):
    """A catalogue that contradicts its schema or itself: which table, line and column, and why."""


class FetchError(RuntimeError):
    """A raw file that cannot be had, or is not what the catalogue says; the message tells how to place it by hand."""


@dataclass(frozen=True)
class RawFile:
    """One raw file: ``runs`` are those that it holds, in the order in which it holds them."""

    dataset: str
    name: str
    runs: tuple[int, ...]
    size_bytes: int
    sha256: str
    url: str

    def place(self, folder: str | Path) -> Path:
        """Return where the file belongs in ``folder`` (``data/raw`` or a mirror)."""
        return Path(folder) / self.dataset / self.name


@dataclass(frozen=True)
class DataSet:
    """A set of raw logs that share rate, columns, units, frame and licence; one row of ``datasets.csv``."""

    name: str
    title: str
    kind: str
    rate_hz: float
    columns: tuple[str, ...]
    gyro_unit: str | None
    accel_unit: str | None
    frame: str
    licence: str
    source: str
    remarks: str
    files: tuple[RawFile, ...]

    @property
    def runs(self) -> tuple[int, ...]:
        """All runs of the set, in increasing order."""
        return tuple(sorted(run for file in self.files for run in file.runs))

    @property
    def units(self) -> tuple[str | None, ...]:
        """The unit of each column as the files hold it."""
        known = {"time": "s", TEMPERATURE: "degC"}
        known |= dict.fromkeys(GYRO, self.gyro_unit) | dict.fromkeys(ACCEL, self.accel_unit)
        return tuple(known[column] for column in self.columns)

    def file(self, run: int) -> RawFile:
        """Return the file that holds ``run``."""
        for file in self.files:
            if run in file.runs:
                return file
        raise CatalogueError(f"{self.name}: expected a run among {', '.join(map(str, self.runs))}; found {run!r}")


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
    files: dict[str, list[RawFile]] = {}
    table = Path(tables) / "datasets.csv"
    for line, row in _rows(table, Path(schemas) / "datasets.schema.yaml"):
        if row["dataset"] in files:
            raise CatalogueError(f"{table}: line {line}, column dataset: {row['dataset']!r} is there twice")
        files[row["dataset"]] = []
    rows = [row for _, row in _rows(table, Path(schemas) / "datasets.schema.yaml")]
    table = Path(tables) / "files.csv"
    for line, row in _rows(table, Path(schemas) / "files.schema.yaml"):
        if row["dataset"] not in files:
            raise CatalogueError(f"{table}: line {line}, column dataset: {row['dataset']!r} is not in datasets.csv")
        file = RawFile(row["dataset"], row["file"], _runs(row["run"]), row["bytes"], row["sha256"], row["url"])
        taken = {run for other in files[file.dataset] for run in other.runs}
        if not file.runs or taken & set(file.runs):
            raise CatalogueError(f"{table}: line {line}, column run: expected runs not yet taken; found {row['run']!r}")
        files[file.dataset].append(file)
    return {row["dataset"]: _data_set(row, tuple(files[row["dataset"]])) for row in rows}
