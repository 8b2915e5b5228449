"""Tables of the paper: the numbers as CSV, and what the page shows as LaTeX and as JSON for Typst."""

import json
import re
from collections.abc import Sequence
from math import floor, isfinite, log10, nan
from pathlib import Path

import pandas as pd

from imugap.units import with_unit

TEX = {
    "√h": r"$\sqrt{\mathrm{h}}$",
    "√Hz": r"$\sqrt{\mathrm{Hz}}$",
    "≤": r"$\le$",
    "≥": r"$\ge$",
    "²": r"$^2$",
    "°": r"$^\circ$",
}
TEX |= {
    "σ": r"$\sigma$",
    "τ": r"$\tau$",
    "–": "--",
    "—": "---",
    "µ": r"$\mu$",
    "±": r"$\pm$",
    "×": r"$\times$",
    "−": "$-$",
}
TEX |= {"√": r"$\surd$", "³": r"$^3$", "Δ": r"$\Delta$", "₀": r"$_0$"}
UNITS = {"sqrt(h)": "√h", "sqrt(Hz)": "√Hz", "ug": "µg", "deg": "°", "^2": "²", "^3": "³"}
DIGITS = 12
"""Most significant digits of a value with an interval."""
DECIMALS = 6
"""Most decimals of a value with a standard deviation."""
SHOWN = re.compile("|".join(map(re.escape, UNITS)))
ESCAPED = {character: "\\" + character for character in "%_&#${}"}
ESCAPED |= {"\\": r"\textbackslash{}", "^": r"\^{}", "~": r"\~{}"}
SPECIAL = re.compile("|".join(map(re.escape, TEX | ESCAPED)))


def write(stem: str | Path, data: pd.DataFrame, shown: pd.DataFrame) -> None:
    """Write ``stem.csv`` (``data``: tidy numbers, full precision), ``stem.tex`` and ``stem.json`` (``shown``: text)."""
    stem = Path(stem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    data.to_csv(f"{stem}.csv", index=False)
    cells = [[str(cell) for cell in row] for row in shown.itertuples(index=False)]
    heads = [str(head) for head in shown.columns]
    page = {"columns": heads, "rows": cells}
    Path(f"{stem}.json").write_text(json.dumps(page, ensure_ascii=False, indent=1) + "\n")
    Path(f"{stem}.tex").write_text(_tabular(heads, cells))


def unit(name: str) -> str:
    """Return the unit ``name`` (of :data:`imugap.units.FACTORS`) as a page shows it."""
    return SHOWN.sub(lambda found: UNITS[found.group()], name)


def number(value: float, digits: int = 3) -> str:
    """Return ``value`` with ``digits`` significant digits, but all before the point; an exponent where it gets long."""
    if not isfinite(value):
        return "—"
    if value == 0:
        return "0"
    magnitude = floor(log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -4 <= magnitude <= 6:
        return f"{value:.{digits - 1}e}"
    return fixed(value, max(digits - 1 - magnitude, 0))


def fixed(value: float, decimals: int) -> str:
    """Return ``value`` rounded to ``decimals`` places, which may be negative."""
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}"


def measured(value: float, std: float) -> tuple[str, str]:
    """Return a value and its standard deviation, both to two digits of the latter; a dash for one that is exact."""
    if not (isfinite(std) and std > 0):
        return f"{value:.5g}", "–"
    decimals = min(max(1 - floor(log10(float(f"{std:.1e}"))), 0), DECIMALS)
    return fixed(value, decimals), fixed(std, decimals)


def with_interval(value: float, low: float, high: float) -> tuple[str, str]:
    """Return a value, and its interval in words, with the digits that two digits of the half width need.

    A value that has more than :data:`DIGITS` of them is exact, and has a dash for its interval.
    """
    digits = 3
    if isfinite(low) and isfinite(high) and high - low <= max(abs(low), abs(high)) * 10.0**-DIGITS:
        return f"{value:.6g}", "–"
    if isfinite(low) and isfinite(high) and high > low:
        largest = max(abs(low), abs(high))
        digits = min(max(floor(log10(largest)) - floor(log10((high - low) / 2)) + 2, 3), DIGITS)
    value, low, high = (number(one, digits) for one in (value, low, high))
    return value, f"{low} to {high}"


def interval(value: float, low: float, high: float) -> str:
    """Return ``value [low, high]``, all to two significant digits of the interval's half width.

    A positive lower end has one significant digit at least, where up to two digits more are enough for it.
    """
    if not (isfinite(low) and isfinite(high)) or high <= low:
        return number(value)
    decimals = 1 - floor(log10((high - low) / 2))
    if low > 0 and -floor(log10(low)) <= min(decimals + 2, 8):
        decimals = max(decimals, -floor(log10(low)))
    if decimals > 8:
        return f"{value:.2e} [{low:.2e}, {high:.2e}]"
    return f"{fixed(value, decimals)} [{fixed(low, decimals)}, {fixed(high, decimals)}]"


def share(value: float, interval: tuple[float, float]) -> str:
    """Return a share with its interval, in whole per cent without the sign: ``36 [22, 53]``."""
    return f"{100 * value:.0f} [{100 * interval[0]:.0f}, {100 * interval[1]:.0f}]"


def parameter(value: float, low: float | None, high: float | None, unit: str = "1") -> str:
    """Return a parameter with its interval and unit; [—] where an end is not known.

    A value that is known to its last digit stands alone.
    """
    ends = [nan if end is None else end for end in (value, low, high)]
    alike = len({number(end) for end in ends}) == 1
    shown = number(value) if alike else interval(*ends)
    shown_unit = SHOWN.sub(lambda found: UNITS[found.group()], unit)
    open_ended = "" if all(map(isfinite, ends)) else " [—]"
    return with_unit(f"{shown}{open_ended}", shown_unit)


def _tabular(heads: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    lines = [r"\begin{tabular}{l" + "r" * (len(heads) - 1) + "}", r"\toprule", _line(heads), r"\midrule"]
    return "\n".join([*lines, *map(_line, cells), r"\bottomrule", r"\end{tabular}"]) + "\n"


def _line(cells: Sequence[str]) -> str:
    return " & ".join(map(tex, cells)) + r" \\"


def tex(text: str) -> str:
    """Return ``text`` in LaTeX: special characters escaped, signs beyond ASCII as commands."""
    return SPECIAL.sub(lambda found: (TEX | ESCAPED)[found.group()], text)
