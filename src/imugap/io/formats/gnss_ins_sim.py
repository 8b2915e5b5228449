"""Logs of the simulator gnss-ins-sim: ``time.csv``, ``gyro-K.csv`` and ``accel-K.csv`` of run K, side by side.

The folder is given, or one of the files; the names may share a prefix. The columns and units are in the headers.
Format: github.com/Aceinna/gnss-ins-sim, ``Sim_data.save_to_file``.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from imugap.io.formats import text
from imugap.io.formats.source import Source
from imugap.log import LogError

CLOCK, SENSORS = "time", ("gyro", "accel")
"""Names of the file of stamps, and of the files of samples."""
HEAD_BYTES = 64


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a folder or a file is output of the simulator with samples and their stamps."""
    return bool(runs(path, CLOCK, SENSORS))


def open_source(path: Path, settings) -> Source:
    """Return the columns of all files of one run; LogError where one of several is meant."""
    found = runs(path, CLOCK, SENSORS)
    run = run_of(path, found, settings.topic)
    return replace(joined(path, found[run]), topic=run)


def files(path: Path) -> list[Path]:
    """Return all files that are read where one of them, or their folder, is given; none for another path."""
    return [file for some in runs(path, CLOCK, SENSORS).values() for file in some]


def runs(path: Path, clock: str, sensors: Sequence[str]) -> dict[str, list[Path]]:
    """Return the files of each run, that of the stamps first; of all runs that a file belongs to, or of a folder."""
    folder = path if path.is_dir() else path.parent
    pattern = re.compile(rf"(.*?)({'|'.join(sensors)})-(\d+)\.csv")
    if not path.is_dir() and not (pattern.fullmatch(path.name) or path.name.endswith(f"{clock}.csv")):
        return {}
    found: dict[str, list[Path]] = {}
    for file in sorted(folder.glob("*-*.csv")):
        parts = pattern.fullmatch(file.name)
        stamps = None if parts is None else folder / f"{parts[1]}{clock}.csv"
        if stamps is not None and _begins(file, f"{parts[2]}_") and _begins(stamps, f"{clock} ("):
            found.setdefault(parts[1] + parts[3], [stamps]).append(file)
    return {run: some for run, some in found.items() if path.is_dir() or path in some}


def run_of(path: Path, found: dict[str, list[Path]], asked: str | None) -> str:
    """Return the run that is asked for, or the only one; LogError where there is none or one of several."""
    run = next(iter(found)) if asked is None and len(found) == 1 else asked
    if run not in found:
        expected, unknown = "one run (--topic decides)", "" if asked is None else f", not {asked}"
        raise LogError(path, "files", expected, f"runs {', '.join(found)}{unknown}")
    return run


def joined(path: Path, parts: Sequence[Path]) -> Source:
    """Return the columns of text files of the same rows as those of one file."""
    sources = [text.open_source(part, None) for part in parts]
    names = tuple(name for source in sources for name in source.names)
    notes = (f"{', '.join(part.name for part in parts)} read as one", *(note for one in sources for note in one.notes))
    rows = max(source.rows for source in sources)
    return Source(path, names, rows, lambda columns: _batches(path, sources, columns), sources[0].place, notes=notes)


def _begins(file: Path, name: str) -> bool:
    if not file.is_file():
        return False
    with file.open("rb") as handle:
        return handle.read(HEAD_BYTES).startswith(name.encode())


def _batches(path: Path, sources: Sequence[Source], columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
    """Yield the rows of columns of several sources; LogError where one ends before another."""
    owners = [(source, k) for source in sources for k in range(len(source.names))]
    chosen = [owners[column] for column in columns]
    used = [source for source in sources if any(owner is source for owner, _ in chosen)]
    streams = [_columns(source, [k for owner, k in chosen if owner is source]) for source in used]
    held: list = [[np.empty(0)]] * len(used)
    row = 0
    while True:
        held = [next(stream, None) if not rest[0].size else rest for rest, stream in zip(held, streams, strict=True)]
        ended = [source.path.name for source, rest in zip(used, held, strict=True) if rest is None]
        if ended and len(ended) < len(used):
            raise LogError(path, "rows", "as many in each file", f"the end of {', '.join(ended)} after {row} rows")
        if ended:
            return
        count = min(len(rest[0]) for rest in held)
        given = {source.path: iter(rest) for source, rest in zip(used, held, strict=True)}
        yield [next(given[owner.path])[:count] for owner, _ in chosen]
        held = [[values[count:] for values in rest] for rest in held]
        row += count


def _columns(source: Source, columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
    """Yield the rows of a part; its errors name it."""
    try:
        yield from source.batches(columns)
    except LogError as error:
        raise LogError(source.path, f"{source.path.name}, {error.place}", error.expected, error.found) from error
