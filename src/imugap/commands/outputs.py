"""Outputs of a command, checked before the work."""

import argparse
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from tempfile import gettempdir

from imugap import atomic, spelling
from imugap.interchange.export import ExportedFile
from imugap.io.formats.gnss_ins_sim import files as files_of
from imugap.workflow.products import METADATA

FOLDER_HELP = "folder for the page report.html, {}"
"""Help of an option for a folder."""


def add_format(parser: argparse.ArgumentParser) -> None:
    """Add ``--format``: the formats of the figures."""
    parser.add_argument(
        "--format", type=_formats, default=("svg",), metavar="FORMATS",
        help=f"formats of the figures, separated by commas, among {', '.join(METADATA)} (default svg)",
    )  # fmt: skip


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``: all facts in place of the verdict and a short table."""
    parser.add_argument("--json", action="store_true", help="print all facts as JSON")


def json_text(facts: object) -> str:
    """Return facts as JSON without NaN or infinity."""
    return json.dumps(facts, indent=1, allow_nan=False)


def format_of(path: str | Path) -> str:
    """Return the format of a figure by the ending of its name; ValueError where there is none such."""
    kind = Path(path).suffix.removeprefix(".").lower()
    if kind not in METADATA:
        raise ValueError(f"{path}: file name: expected one that ends in .{', .'.join(METADATA)}; found another")
    return kind


def _formats(text: str) -> tuple[str, ...]:
    given = tuple(dict.fromkeys(text.lower().split(",")))
    for one in given:
        if one not in METADATA:
            raise argparse.ArgumentTypeError(f"expected {spelling.expected(one, METADATA)}; found {one!r}")
    return given


def require_files(outputs: Mapping[str, str | None], inputs: Iterable[str | Path | None]) -> None:
    """Raise a ValueError unless every output file can be written and is neither an input nor another output.

    Parameters
    ----------
    outputs
        Path of each option, or None where it is not given.
    inputs
        Paths that the command reads; None where one is not given.
    """
    taken: dict[str, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        _require_no_input(path, Path(path), inputs)
        if Path(path).is_dir():
            raise ValueError(f"{path}: {option}: expected a file; found a folder")
        if atomic.is_stream(path):
            continue
        _require_writable(path, option)
        place = os.path.realpath(path)
        if place in taken:
            raise ValueError(f"{path}: {option}: expected a file of its own; found that of {taken[place]}")
        taken[place] = option


def room(path: str | Path) -> int:
    """Return the bytes that are free where a file is written; those of a stream are complete before they are sent."""
    place = Path(gettempdir()) if atomic.is_stream(path) else Path(os.path.realpath(path))
    return shutil.disk_usage(next(one for one in (place, *place.parents) if one.is_dir())).free


def require_folder(path: str | Path, names: Iterable[str], inputs: Iterable[str | Path | None]) -> Path:
    """Return the path of a folder that can be written as a whole; raise a ValueError otherwise.

    Parameters
    ----------
    names
        Names of the files that are written into it; an input among them is refused.
    inputs
        Paths that the command reads; None where one is not given.
    """
    path = Path(path)
    if path.exists() and not path.is_dir():
        raise ValueError(f"{path}: expected a folder; found a file")
    place = Path(os.path.realpath(path))
    if place == Path.cwd() or place in Path.cwd().parents or place.is_mount():
        raise ValueError(
            f"{path}: expected a folder that can be replaced as a whole; found the working folder, one above it or a "
            "mount point (name a folder within it)"
        )
    for name in names:
        _require_no_input(path, place / name, inputs)
    _require_writable(path, "folder")
    return path


def _require_no_input(shown: str | Path, path: Path, inputs: Iterable[str | Path | None]) -> None:
    if not path.exists() or atomic.is_stream(path):
        return
    for one in inputs:
        if one is None or not Path(one).exists():
            continue
        if path.samefile(one) or Path(os.path.realpath(path)).is_relative_to(os.path.realpath(one)):
            raise ValueError(f"{shown}: expected an output that is no input; found the input {one}")
        if any(path.samefile(file) for file in files_of(Path(one))):
            raise ValueError(f"{shown}: expected an output that is no input; found a file that is read with {one}")


def _require_writable(path: str | Path, what: str) -> None:
    """Raise a ValueError unless a file or folder can be written, or made in the nearest folder that exists."""
    place = Path(os.path.realpath(path))
    if place.is_file() and not os.access(place, os.W_OK):
        raise ValueError(f"{path}: {what}: expected one that can be written; found one that is read-only")
    folder = next(one for one in place.parents if one.exists())
    if not folder.is_dir():
        raise ValueError(f"{path}: {what}: expected a folder at {folder}; found a file")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise ValueError(f"{path}: {what}: expected a folder that can be written; found {folder} to be read-only")


def say_left_out(file: ExportedFile) -> None:
    """Print what an exported file leaves out on the standard error, a line for each effect."""
    for one in file.left_out:
        print(f"imugap: left out: {one}", file=sys.stderr)


def text_writers(texts: Mapping[str | Path, str]) -> dict[str | Path, Callable[[Path], object]]:
    """Return the writer of each of some texts."""
    return {path: partial(Path.write_text, data=text) for path, text in texts.items()}
