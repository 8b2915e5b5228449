"""Folder of a result: tables, models, texts and figures by name, written completely or not at all."""

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from os import PathLike, fspath
from pathlib import Path

from imugap import atomic
from imugap.workflow.products import METADATA, write_figure

FIGURE = ".svg"
"""Ending of the name of a figure of any format."""


def _write_json(data: object, path: Path) -> None:
    path.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n")


def _write_text(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


WRITERS: Mapping[str, Callable[..., object]] = {
    ".parquet": lambda table, path: table.to_parquet(path),
    ".csv": lambda table, path: table.to_csv(path, index=False),
    ".json": _write_json,
    ".geojson": _write_json,
    ".kml": _write_text,
    ".md": _write_text,
    ".html": lambda render, path: _write_text(render(), path),
    ".yaml": lambda one, path: _write_text(one, path) if isinstance(one, str) else one.write(path),
}
"""Writer of each ending of the name of a file; that of a page renders it."""


def write_folder(folder: str | PathLike[str], files: Mapping[str, object], formats: Sequence[str] = ("svg",)) -> None:
    """Write files into a folder, in one step.

    Parameters
    ----------
    files
        Name to content; the suffix of the name selects the format (:data:`WRITERS`), ``.svg`` for a figure.
    formats
        Formats in which each figure is written; those of an earlier output in others are gone.
    """
    figures = {Path(name).stem: one for name, one in files.items() if name.endswith(FIGURE)}
    drawn: dict[str, Callable[[Path], object]] = {
        f"{name}.{kind}": partial(write_figure, one, kind=kind) for name, one in figures.items() for kind in formats
    }
    others: dict[str, Callable[[Path], object]] = {
        name: partial(WRITERS[Path(name).suffix], one) for name, one in files.items() if not name.endswith(FIGURE)
    }
    outdated = {f"{name}.{kind}" for name in figures for kind in METADATA} - set(drawn)
    atomic.write_folder(fspath(folder), drawn | others, outdated)
