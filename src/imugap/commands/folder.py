"""Folder of results of a command: all of its files, or none."""

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from imugap.atomic import write_together
from imugap.workflow.products import write_svg


def require_folder(path: str | Path) -> Path:
    """Return the path of a folder that exists or can be made; raise ValueError for a file."""
    path = Path(path)
    if path.exists() and not path.is_dir():
        raise ValueError(f"{path}: expected a folder; found a file")
    return path


def write_folder(folder: str | Path, files: Mapping[str, object]) -> None:
    """Write files into a folder, or none if one of them fails.

    Parameters
    ----------
    files
        Name to content; the suffix of the name selects the format: ``.parquet`` and ``.csv`` for a DataFrame, ``.json``
        for plain data, ``.svg`` for a figure.
    """
    writers = {
        ".parquet": lambda table, path: table.to_parquet(path),
        ".csv": lambda table, path: table.to_csv(path, index=False),
        ".json": lambda data, path: path.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n"),
        ".svg": write_svg,
    }
    write_together({
        Path(folder) / name: partial(writers[Path(name).suffix], content) for name, content in files.items()
    })  # fmt: skip
