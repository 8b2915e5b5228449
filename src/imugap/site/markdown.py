"""Markdown from plain values."""

import re
from collections.abc import Iterable, Sequence

MARKS = re.compile(r"([\\`*_{}\[\]<>|$#])")
"""Characters that Markdown takes for marks."""


def plain(text: str) -> str:
    """Return a text in one line, with no character that Markdown takes for a mark."""
    return MARKS.sub(r"\\\1", " ".join(text.split()))


def prose(docstring: str) -> str:
    """Return a docstring in one line, its marks for code and for other names as those of Markdown."""
    pieces = re.split(r"(?::\w+:|`)`~?([^`]+)`+", " ".join(docstring.split()))
    return "".join(code(one) if number % 2 else MARKS.sub(r"\\\1", one) for number, one in enumerate(pieces))


def code(text: str) -> str:
    """Return a text in one line as code, also within a table."""
    shown = " ".join(text.split()).replace("|", r"\|")
    return f"``{shown}``" if "`" in shown else f"`{shown}`"


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of cells that are Markdown."""
    lines = [titles, ["---"] * len(titles), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
