"""Figures of the estimation chapter: each function draws one figure from tables and returns it."""

from math import ceil

import pandas as pd
from matplotlib.figure import Figure

from imugap.figures.style import AXIS_TITLES, allan_label, allan_unit, legend_below, panels_of
from imugap.units import from_si

MOST_COLUMNS = 3
DEVICE, MODEL = "black", "#0072B2"


def fitted(curves: pd.DataFrame) -> Figure:
    """Draw the Allan deviation of each axis against the curve and the band of its fitted model.

    Parameters
    ----------
    curves
        Columns ``axis``, ``tau`` [s], ``deviation`` (of the log), ``model``, ``low``, ``high`` (where the model expects
        the deviation of so long a log); SI.
    """
    axes = list(curves["axis"].unique())
    columns = min(len(axes), MOST_COLUMNS)
    rows = ceil(len(axes) / columns)
    figure, grid = panels_of(rows, columns, 2.2 * rows + 0.4, sharex=True)
    for axis, panel in zip(axes, grid.flat, strict=False):
        unit = allan_unit(axis)
        one = curves[curves["axis"] == axis]
        tau = one["tau"].to_numpy()
        deviation, model, low, high = (from_si(one[c].to_numpy(), unit) for c in ("deviation", "model", "low", "high"))
        panel.fill_between(tau, low, high, color=MODEL, alpha=0.2, lw=0, label="95 % of logs of this length under it")
        panel.plot(tau, model, color=MODEL, label="fitted model")
        panel.plot(tau, deviation, color=DEVICE, marker=".", ms=2.5, lw=0.6, label="log")
        panel.set(title=AXIS_TITLES[axis], xscale="log", yscale="log")
        panel.set(xlabel="averaging time τ [s]", ylabel=allan_label(axis))
        panel.tick_params(labelbottom=True)
    for panel in grid.flat[len(axes) :]:
        panel.remove()
    legend_below(figure, 3)
    return figure
