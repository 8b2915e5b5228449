"""Figure of the performance indices of a device."""

import pandas as pd
from matplotlib.figure import Figure

from imugap import log
from imugap.estimation.indices import INDICES
from imugap.figures.style import CARD, panels_of
from imugap.units import from_si

TRIADS = {"gyroscopes": log.GYRO, "accelerometers": log.ACCEL}
READING, BOUND = "black", "#888888"
"""Colours of a value that was read, and of an upper bound."""


def intervals(table: pd.DataFrame) -> Figure:
    """Draw each index of each axis with its interval; an upper bound is a grey triangle.

    Parameters
    ----------
    table
        Columns of :func:`imugap.estimation.indices.over_runs`; SI.
    """
    triads = {name: table[table["axis"].isin(axes)] for name, axes in TRIADS.items()}
    triads = {name: part for name, part in triads.items() if len(part)}
    symbols = [symbol for symbol in INDICES if symbol in set(table["symbol"])]
    figure, grid = panels_of(len(symbols), len(triads), 1.5 * len(symbols))
    figure.set_size_inches(CARD * len(triads), 1.5 * len(symbols))
    for row, symbol in zip(grid, symbols, strict=True):
        for panel, (name, part) in zip(row, triads.items(), strict=True):
            _draw(panel, part[part["symbol"] == symbol], symbol)
            if row is grid[0]:
                panel.set_title(name)
    return figure


def _draw(panel, rows: pd.DataFrame, symbol: str) -> None:
    for at, one in enumerate(rows.itertuples()):
        unit = INDICES[symbol].unit(one.axis)
        value, low, high = (from_si(number, unit) for number in (one.value, one.low, one.high))
        colour, marker = (READING, "o") if one.holds else (BOUND, "v")
        panel.vlines(at, low, high, color=colour)
        panel.plot(at, value, marker, color=colour, markersize=4)
        panel.set_ylabel(f"{symbol} [{unit}]")
    panel.set_xticks(range(len(rows)), rows["axis"])
    panel.margins(x=0.2)
