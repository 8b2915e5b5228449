"""Compressed files (``.gz``, ``.bz2``, ``.xz``): the log in one is read as if it lay beside it."""

import bz2
import gzip
import lzma
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from imugap.io.formats.source import Source
from imugap.log import LogError

OPENERS: dict[bytes, Callable] = {b"\x1f\x8b": gzip.open, b"BZh": bz2.open, b"\xfd7zXZ": lzma.open}
"""How a file with this begin is opened."""


def recognises(head: bytes) -> bool:
    """Return whether a file begins as one that is compressed."""
    return head.startswith(tuple(OPENERS))


def opened(path: Path, head: bytes, open_source: Callable[[Path], Source]) -> Source:
    """Return the columns of the log in a compressed file, which exists as long as they do."""
    opener = next(one for begin, one in OPENERS.items() if head.startswith(begin))
    folder = TemporaryDirectory()
    part = Path(folder.name) / path.stem
    with opener(path) as packed, part.open("wb") as plain:
        shutil.copyfileobj(packed, plain)
    try:
        source = open_source(part)
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error

    def batches(columns, kept=folder):
        return source.batches(columns)

    return replace(source, path=path, batches=batches)
