"""Numbers and tables as commands print them: four significant digits, units in the habit of data sheets."""

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path

from imugap.units import from_si

HABITS = {
    "rad/s/sqrt(Hz)": "deg/sqrt(h)",
    "m/s^2/sqrt(Hz)": "m/s/sqrt(h)",
    "rad/s": "deg/h",
    "m/s^2": "ug",
    "rad/s/s/sqrt(Hz)": "deg/h/sqrt(h)",
    "m/s^2/s/sqrt(Hz)": "m/s/h/sqrt(h)",
}
"""Unit of data sheets of each SI unit."""


def number(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits."""
    return f"{value:.{digits}g}" if isfinite(value) else "inf" if value > 0 else "-inf"


def interval_text(low: float, high: float) -> str:
    """Return an interval with three significant digits."""
    return f"{low:.3g} .. {high:.3g}"


def habit(value: float, unit: str) -> str:
    """Return a value of a SI unit in the unit of data sheets, or nothing where there is none."""
    if unit not in HABITS:
        return ""
    return f"{number(from_si(value, HABITS[unit]))} {HABITS[unit]}"


def table_text(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows under titles in columns, to the left."""
    widths = [max(map(len, column)) for column in zip(titles, *rows, strict=True)]
    padded = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (titles, *rows))
    return "\n".join("  ".join(row).rstrip() for row in padded)


def summary_text(verdict: str, rows: Iterable[tuple[str, str]], report: Path) -> str:
    """Return a verdict, a table of what and value, and where the page is."""
    return "\n".join([verdict, "", table_text(("", "value"), list(rows)), "", f"More: {report}"])
