"""Figures of a log: its samples over time."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from imugap.figures.style import card, legend_below, panels_of
from imugap.log import ACCEL, GYRO, TEMPERATURE

STRETCHES = 600
"""Stretches of a long log, of each of which the extremes are drawn."""
COLOURS = ("#0072B2", "#D55E00", "#009E73")
QUANTITIES = (
    (GYRO, "angular rate [°/s]", float(np.degrees(1.0))),
    (ACCEL, "specific force [m/s²]", 1.0),
    ((TEMPERATURE,), "temperature [°C]", 1.0),
)
"""Columns that share a panel, its label, and by what the values are multiplied."""


def samples(log: pd.DataFrame) -> Figure:
    """Draw all columns over time, a panel for each quantity."""
    shown = _quantities(log)
    figure, grid = panels_of(len(shown), 1, 1.7 * len(shown) + 0.4, sharex=True)
    for panel, one in zip(grid[:, 0], shown, strict=True):
        _quantity(panel, log, *one)
    grid[-1, 0].set_xlabel("time [s]")
    legend_below(figure, 4)
    return figure


def quantities(log: pd.DataFrame) -> list[tuple[str, Figure]]:
    """Return each quantity with a figure of its columns over time."""
    found = []
    for names, label, factor in _quantities(log):
        figure, (panel,) = card()
        _quantity(panel, log, names, label, factor)
        panel.set_xlabel("time [s]")
        if len(names) > 1:
            legend_below(figure, 3)
        found.append((label.partition(" [")[0], figure))
    return found


def _quantities(log: pd.DataFrame) -> list[tuple[Sequence[str], str, float]]:
    """Return the quantities of which the log has a column with values, with these columns."""
    some = [([name for name in names if name in log and log[name].notna().any()], *rest) for names, *rest in QUANTITIES]
    return [(names, label, factor) for names, label, factor in some if names]


def _quantity(panel: Axes, log: pd.DataFrame, names: Sequence[str], label: str, factor: float) -> None:
    for name, colour in zip(names, COLOURS, strict=False):
        time, values = _extremes(log.index.to_numpy(float), factor * log[name].to_numpy(float))
        panel.plot(time, values, color=colour, lw=0.6, label=name[-1] if len(names) > 1 else name)
    panel.set(ylabel=label, xlim=(log.index[0], log.index[-1]))


def _extremes(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return all samples of a short log, or smallest and largest value of each stretch of a long one."""
    width = len(values) // STRETCHES
    if width <= 2:
        return time, values
    whole = values[: len(values) // width * width].reshape(-1, width)
    known = np.isfinite(whole)
    low = np.where(known, whole, np.inf).min(axis=1)
    high = np.where(known, whole, -np.inf).max(axis=1)
    pairs = np.column_stack([low, high]).ravel()
    pairs[~np.isfinite(pairs)] = np.nan
    begins = time[: len(whole) * width : width]
    return np.repeat(begins, 2), pairs
