"""Tables with the prompt of a serial monitor, ``12:34:56.789 -> ``, before each line; its time is that of the row."""

import re
from collections.abc import Iterator
from pathlib import Path

from imugap.io.formats import text
from imugap.io.formats.source import Source

PROMPT = re.compile(r"(\d{1,2}:\d\d:\d\d\.\d+) -> ?")
SEPARATORS = (",", ";", "\t")


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins with such a prompt."""
    return PROMPT.match(head.decode("utf-8", errors="replace").lstrip("\ufeff")) is not None


def open_source(path: Path, settings) -> Source:
    """Return the columns of the table, and the times of the prompts as a column ``time``."""
    with path.open(encoding="utf-8-sig", errors="replace") as handle:
        return text.of_lines(path, _lines(handle))


def _lines(lines) -> Iterator[str]:
    """Yield the lines of the table, the time first; the first line is of names if it is not of numbers."""
    separator = None
    for line in lines:
        found = PROMPT.match(line)
        if found is None:
            continue
        rest = line[found.end() :]
        if separator is None:
            separator = next((one for one in SEPARATORS if one in rest), " ")
            names = not any(text.NUMBER.fullmatch(cell.strip()) for cell in rest.split(separator))
            yield f"time{separator}{rest}" if names else f"{found[1]}{separator}{rest}"
        else:
            yield f"{found[1]}{separator}{rest}"
