"""Text in which the first word of each line names a sensor, as GNSS Logger and many loggers of phones write it.

The names of the columns of a sensor stand in a comment behind its name; a line without them is a time, x, y and z.
"""

import re
from collections import Counter
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from imugap.io.formats import sensor_tables, text
from imugap.io.formats.source import Source
from imugap.log import LogError

HEAD_BYTES = 1 << 16
COMMENT = ("#", "%", "//", "!")
TAG = re.compile(r"\s*\$?([A-Za-z]\w*)([,;\t ])\s*(?=[-+.\d])")
"""Name of a sensor, the separator, and the begin of a number."""
NAMED = 4
"""Values of a line without names: a time and three axes."""
SHARE = 0.5
"""Share of the lines at the begin that are of this form."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether most lines of a text begin with the name of a sensor, and there are several names."""
    if path.is_dir() or b"\x00" in head:
        return False
    with path.open("rb") as handle:
        lines = handle.read(HEAD_BYTES).decode("utf-8", errors="replace").splitlines()
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith(COMMENT)]
    tags = [found[1] for line in rows if (found := TAG.match(line))]
    recurring = [tag for tag, count in Counter(tags).items() if count > 1]
    several = len(recurring) > 1 or any(_named(lines, tag) for tag in recurring)
    return len(tags) > SHARE * len(rows) and several and sensor_tables.has_sensors(recurring)


def open_source(path: Path, settings) -> Source:
    """Return the samples of the gyroscopes and accelerometers; LogError where there are none, or no names of columns.

    The lines of each sensor are read as a table of their own.
    """
    with TemporaryDirectory() as folder, path.open(encoding="utf-8", errors="replace") as handle:
        comments = _split(path, handle, Path(folder))
        parts = {one.stem: one for one in sorted(Path(folder).glob("*.csv"))}
        for tag, part in parts.items():
            if sensor_tables.has_sensors([tag]):
                _head(path, part, _named(comments, tag))
        tables = {tag: partial(text.open_source, part, None) for tag, part in parts.items()}
        try:
            return sensor_tables.joined(path, tables, {}, "lines")
        except LogError as error:
            where = f"lines of {Path(error.source).stem}, {error.place}" if Path(error.source) != path else error.place
            raise LogError(path, where, error.expected, error.found) from error


def _split(path: Path, lines, folder: Path) -> list[str]:
    """Write the lines of each sensor, without its name, to a file of it; return the comments."""
    comments = []
    with ExitStack() as stack:
        parts = {}
        for line in lines:
            if line.lstrip().startswith(COMMENT):
                comments.append(line)
            elif found := TAG.match(line):
                tag = found[1]
                if tag not in parts:
                    parts[tag] = stack.enter_context((folder / f"{tag}.csv").open("w", encoding="utf-8"))
                parts[tag].write(line[found.end() :])
    return comments


def _named(comments: list[str], tag: str) -> str | None:
    """Return the names of the columns of a sensor in a comment, None where there are none."""
    pattern = re.compile(rf"(?:^|['\"#%/!\s]){re.escape(tag)}[,;\t]\s*([A-Za-z][^'\"\n]*)")
    found = (pattern.search(line) for line in comments if line.lstrip().startswith(COMMENT))
    return next((one[1].rstrip(";, \n") for one in found if one), None)


def _head(path: Path, part: Path, names: str | None) -> None:
    """Write the names of the columns before the lines of a sensor; LogError where they are not known."""
    body = part.read_text(encoding="utf-8")
    first = body.partition("\n")[0]
    separator = next((one for one in (",", ";", "\t") if one in first), " ")
    cells = first.split(separator) if separator != " " else first.split()
    if names is None and len(cells) != NAMED:
        expected = f"a comment with the names of the columns (# {part.stem},time,x,y,z)"
        raise LogError(path, f"lines of {part.stem}", expected, f"{len(cells)} values without names")
    header = names or separator.join(("time", "x", "y", "z"))
    part.write_text(f"{header}\n{body}", encoding="utf-8")
