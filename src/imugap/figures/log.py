"""Figures of a log: its samples over time."""

from collections.abc import Sequence
from itertools import islice

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from imugap.figures.style import card, panels_of, time_axis
from imugap.log import ACCEL, AXES, GYRO, TEMPERATURE

STRETCHES = 600
"""Stretches of a long log; the extremes of each are drawn."""
COLOUR = "#0072B2"
QUANTITIES = (
    (GYRO, "angular rate [°/s]", float(np.degrees(1.0))),
    (ACCEL, "specific force [m/s²]", 1.0),
    ((TEMPERATURE,), "temperature [°C]", 1.0),
)
"""Columns that share a panel, its label, and by what the values are multiplied."""


def samples(log: pd.DataFrame) -> Figure:
    """Draw all columns over time, a panel for each."""
    shown = _quantities(log)
    count = sum(len(names) for names, *_ in shown)
    figure, grid = panels_of(count, 1, 0.9 * count + 0.5, sharex=True)
    panels = iter(grid[:, 0])
    for one in shown:
        _quantity(list(islice(panels, len(one[0]))), log, *one)
    grid[-1, 0].set_xlabel(time_axis(*log.index[[0, -1]])[1])
    return figure


def quantities(log: pd.DataFrame) -> list[tuple[str, Figure]]:
    """Return each quantity with a figure of its columns over time, as wide as a phone."""
    found = []
    for names, label, factor in _quantities(log):
        figure, panels = card(0.8 * len(names) + 0.6, rows=len(names), sharex=True)
        _quantity(panels, log, names, label, factor)
        panels[-1].set_xlabel(time_axis(*log.index[[0, -1]])[1])
        found.append((label.partition(" [")[0], figure))
    return found


def _quantities(log: pd.DataFrame) -> list[tuple[Sequence[str], str, float]]:
    """Return the quantities of which the log has a column with values, with these columns."""
    some = [([name for name in names if name in log and log[name].notna().any()], *rest) for names, *rest in QUANTITIES]
    return [(names, label, factor) for names, label, factor in some if names]


def _quantity(panels: Sequence[Axes], log: pd.DataFrame, names: Sequence[str], label: str, factor: float) -> None:
    time = log.index.to_numpy(float)
    time = time - time_axis(time[0], time[-1])[0]
    for panel, name in zip(panels, names, strict=True):
        panel.plot(*_extremes(time, factor * log[name].to_numpy(float)), color=COLOUR, lw=0.5)
        panel.set(ylabel=name[-1] if name in AXES else "", xlim=(time[0], time[-1]))
    panels[0].set_title(label, loc="left")


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
