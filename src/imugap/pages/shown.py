"""Numbers and tables as text: four significant digits, and of a number with an interval as many as this needs."""

from collections.abc import Iterable, Sequence
from math import floor, isfinite, log10
from pathlib import Path

MOST = 12
"""Most significant digits."""


def number(value: float, digits: int = 4) -> str:
    """Return a number with so many significant digits."""
    return f"{value:.{digits}g}" if isfinite(value) else "inf" if value > 0 else "-inf"


def interval_text(low: float, high: float) -> str:
    """Return an interval with the digits that two digits of its half width need, three at least."""
    digits = _digits(low, high)
    return f"{_padded(low, digits)} .. {_padded(high, digits)}"


def with_interval(value: float, low: float, high: float) -> tuple[str, str]:
    """Return a number and its interval, both with the digits of the interval."""
    return _padded(value, _digits(low, high)), interval_text(low, high)


def _padded(value: float, digits: int) -> str:
    """Return a number with so many significant digits, zeros at its end included."""
    return f"{value:#.{digits}g}".removesuffix(".") if value and isfinite(value) else number(value)


def _digits(low: float, high: float) -> int:
    if not (isfinite(low) and isfinite(high) and high > low):
        return 3
    return min(max(floor(log10(max(abs(low), abs(high)))) - floor(log10((high - low) / 2)) + 2, 3), MOST)


def table_text(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows under titles in columns, to the left."""
    widths = [max(map(len, column)) for column in zip(titles, *rows, strict=True)]
    padded = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (titles, *rows))
    return "\n".join("  ".join(row).rstrip() for row in padded)


def summary_text(verdict: str, rows: Iterable[tuple[str, str]], report: Path) -> str:
    """Return a verdict, a table of what and value, and where the page is."""
    return "\n".join([verdict, "", table_text(("", "value"), list(rows)), "", f"More: {report}"])
