"""Numbers and tables as commands print them: four significant digits."""

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path


def number(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits."""
    return f"{value:.{digits}g}" if isfinite(value) else "inf" if value > 0 else "-inf"


def interval_text(low: float, high: float) -> str:
    """Return an interval with three significant digits."""
    return f"{low:.3g} .. {high:.3g}"


def table_text(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows under titles in columns, to the left."""
    widths = [max(map(len, column)) for column in zip(titles, *rows, strict=True)]
    padded = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (titles, *rows))
    return "\n".join("  ".join(row).rstrip() for row in padded)


def summary_text(verdict: str, rows: Iterable[tuple[str, str]], report: Path) -> str:
    """Return a verdict, a table of what and value, and where the page is."""
    return "\n".join([verdict, "", table_text(("", "value"), list(rows)), "", f"More: {report}"])
