"""Columns of a file before they have a meaning: names, and batches of numbers."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from hashlib import file_digest, sha256
from pathlib import Path

import numpy as np

from imugap.log import LogError

CAUSE = 240
"""Longest cause of a damage that is shown."""
SEPARATED = re.compile(r"^[_\-/ ]+")
"""What stands between the word of a group and the name of a column."""


@dataclass(frozen=True, eq=False)
class Source:
    """Columns of a file of a known format.

    Attributes
    ----------
    path
        The file.
    names
        Name of each column, from left to right; empty texts where the file has none.
    rows
        Number of rows, or a larger one.
    batches
        From the positions of columns, an iterator over the rows: one array of each column per batch, shape (n,).
    place
        From the number of a row, where it is in the file.
    canonical
        Whether the package wrote the file, so that the columns are what their names say.
    notes
        Sentences on what was chosen in the file.
    heading
        Where the names are in the file.
    topic
        Message, run or group of columns that was asked for and is all that there is here.
    whole
        Names of the columns that are written as whole numbers.
    clocks
        Positions of the columns of times as texts; as numbers these are nanoseconds.
    rate
        Sampling rate that the file states [Hz], and the name of the value; None where there is none.
    cells
        From the position of a column, an iterator over its cells as texts, in the rows of ``batches``; None where all
        columns are numbers.
    """

    path: Path
    names: tuple[str, ...]
    rows: int
    batches: Callable[[Sequence[int]], Iterator[list[np.ndarray]]]
    place: Callable[[int], str] = "row {}".format
    canonical: bool = False
    notes: tuple[str, ...] = ()
    heading: str = "columns"
    topic: str | None = None
    whole: frozenset[str] = frozenset()
    clocks: frozenset[int] = frozenset()
    rate: tuple[float, str] | None = None
    cells: Callable[[int], Iterator[np.ndarray]] | None = None

    def texts(self, column: int) -> Iterator[np.ndarray]:
        """Return an iterator over the cells of a column as texts, in the rows of ``batches``."""
        if self.cells is not None:
            return self.cells(column)
        return (values.astype(str) for (values,) in self.batches([column]))

    def group(self, topic: str) -> "Source":
        """Return the columns with names ``topic.name``, without the topic; LogError where there are none.

        Where none has a dot, those with names ``topic_name`` are taken, and those that no other group has, as its time.
        """
        parts = [name.rpartition(".")[::2] for name in self.names]
        own = {k: name for k, (group, name) in enumerate(parts) if group == topic} or self._beginning_with(topic)
        if not own:
            known = ", ".join(dict.fromkeys(group for group, _ in parts if group))
            expected = f"a group of columns that there is (--topic): {known or 'the word with which their names begin'}"
            raise LogError(self.path, self.heading, expected, topic)
        kept, names = list(own), tuple(own.values())
        notes = (*self.notes, f"columns of {topic}")
        return replace(
            self,
            names=names,
            batches=lambda columns: self.batches([kept[k] for k in columns]),
            notes=notes,
            topic=topic,
            whole=frozenset(name for k, name in own.items() if self.names[k] in self.whole),
            clocks=frozenset(place for place, k in enumerate(kept) if k in self.clocks),
            cells=lambda column: self.texts(kept[column]),
        )

    def _beginning_with(self, word: str) -> dict[int, str]:
        """Return the names that begin with a word, without it, and those of columns of no group, by position."""
        begun = {k: SEPARATED.sub("", name.removeprefix(word)) for k, name in enumerate(self.names)
                 if name.startswith(word) and SEPARATED.match(name.removeprefix(word))}  # fmt: skip
        alone = {k: name for k, name in enumerate(self.names) if not name.endswith(tuple(begun.values()))}
        return dict(sorted((begun | alone).items())) if begun else {}

    def load(self, columns: Sequence[int], stamp: int | None) -> tuple[np.ndarray, np.ndarray | None]:
        """Return whole columns, shape (columns, n), and the stamps, shape (n,), in one pass and one block of memory."""
        with whole_file(self.path):
            block = np.empty((len(columns), self.rows))
            stamps: list[np.ndarray] = []
            end = 0
            for batch in self.all_batches(columns, stamp):
                begin, end = end, end + len(batch[0])
                for k in range(len(columns)):
                    block[k, begin:end] = batch[k]
                stamps += [] if stamp is None else [batch[-1]]
            return block[:, :end], np.concatenate(stamps) if stamps else None

    def all_batches(self, columns: Sequence[int], stamp: int | None) -> Iterator[list[np.ndarray]]:
        """Return an iterator over the rows of columns, with the stamps as the last where there are any."""
        return self.batches([*columns, *([] if stamp is None else [stamp])])

    def head(self, columns: Sequence[int], rows: int) -> list[np.ndarray]:
        """Return the first rows of columns."""
        with whole_file(self.path):
            first = next(self.batches(columns), [np.empty(0)] * len(columns))
        return [values[:rows] for values in first]


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file, or of the names and contents of all files of a folder."""
    if not path.is_dir():
        with path.open("rb") as file:
            return file_digest(file, "sha256").hexdigest()
    whole = sha256()
    for one in sorted(one for one in path.rglob("*") if one.is_file()):
        whole.update(f"{one.relative_to(path).as_posix()} {sha256_of(one)}\n".encode())
    return whole.hexdigest()


@contextmanager
def extra(path: Path, name: str, package: str) -> Iterator[None]:
    """Turn a missing package, which an extra of this one installs, into a LogError that says how to get it."""
    try:
        yield
    except ImportError as error:
        raise LogError(path, "file", f"the package {package} (pip install 'imugap[{name}]')", "none") from error


def require_file(path: Path, expected: str) -> None:
    """Raise a LogError unless a path is a file or a folder, which can be read more than once."""
    if not path.exists():
        raise LogError(path, "file", expected, "no such file")
    if not (path.is_file() or path.is_dir()):
        raise LogError(path, "file", f"{expected} (a file, which is read more than once)", "a pipe or a device")


@contextmanager
def whole_file(path: Path) -> Iterator[None]:
    """Turn any exception within into a LogError: decoders raise all kinds of them on a damaged file."""
    try:
        yield
    except (LogError, MemoryError):
        raise
    except Exception as error:
        cause = f"{type(error).__name__}: {error}".splitlines()[0][:CAUSE]
        found = f"{path.stat().st_size} bytes that cannot be read ({cause})"
        raise LogError(path, "file", "a whole file of its format", found) from error
