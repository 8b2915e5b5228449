"""Figures of recorded drives and flights: each function draws one figure from tables or a solution and returns it."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from imugap.figures.fault_ablation import COLOURS, TITLES
from imugap.figures.style import decades, label_lowest, legend_below, panels_of
from imugap.kinematics.strapdown import ATTITUDE
from imugap.navigation.drive.vehicle import DriveSolution
from imugap.study.drive.fault_ablation import SMOOTHED, WHEELS, WHOLE

GROUPS = (("none", "gate", "remove"), ("robust", "gated", "reset", "separation"),
          (WHEELS[WHOLE], SMOOTHED, WHEELS[SMOOTHED]))  # fmt: skip
"""Schemes that share a panel."""
MODELS = {"rest": ("model of the rest", "#D55E00"), "tuned": ("tuned model", "#0072B2"),
          "wheels": ("tuned model, wheels", "#882255")}  # fmt: skip


def outages(table: pd.DataFrame) -> Figure:
    """Draw the drift over the time since the begin of every outage, and its predicted deviation, a panel per model.

    Parameters
    ----------
    table
        Columns ``model``, ``draw``, ``begin``, ``since`` [s], ``horizontal``, ``predicted`` [m].
    """
    figure, grid = panels_of(1, len(MODELS), 2.9, sharey=True)
    for panel, (name, (title, colour)) in zip(grid[0], MODELS.items(), strict=True):
        one = table[table["model"] == name]
        first = one[one["draw"] == one["draw"].min()]
        for _, drift in first.groupby("begin"):
            panel.plot(drift["since"], drift["horizontal"], color=colour, lw=0.7, alpha=0.8, label="drift in an outage")
        grid_s = np.arange(1.0, one["since"].max())
        of = one.groupby(["draw", "begin"])
        for column, style, label in (
            ("horizontal", "-", "drift, root mean square"),
            ("predicted", "--", "predicted σ"),
        ):
            curves = [np.interp(grid_s, drift["since"], drift[column]) for _, drift in of]
            panel.plot(
                grid_s, np.sqrt(np.mean(np.square(curves), axis=0)), color="black", ls=style, lw=1.4, label=label
            )
        panel.set(title=title, xlabel="time since the last fix [s]")
        decades(panel)
    grid[0, 0].set_ylabel("horizontal [m]")
    legend_below(figure, 3)
    return figure


def track(table: pd.DataFrame) -> Figure:
    """Draw the drive from above, with the fixes as spoilt, and the horizontal error of every scheme over time.

    Parameters
    ----------
    table
        Columns ``time``, ``north``, ``east``, ``scheme``: positions of ``fixes`` and ``truth``, errors of the others.
    """
    figure, grid = panels_of(2, 2, 5.4)
    above = {"loc": "lower left", "bbox_to_anchor": (0, 1), "ncols": 2, "borderaxespad": 0.1}
    first, *others = grid.flat
    of = dict(list(table.groupby("scheme")))
    first.plot(of["fixes"]["east"], of["fixes"]["north"], ".", color="#D55E00", ms=2.5, label="fixes, degraded and bad")
    first.plot(of["truth"]["east"], of["truth"]["north"], color="black", lw=0.8, label="truth (RTK)")
    first.set(xlabel="east [m]", ylabel="north [m]")
    first.set_aspect("equal", adjustable="datalim")
    first.legend(**above)
    for panel, group in zip(others, GROUPS, strict=True):
        for name, look in zip((name for name in group if name in of), ("-", "--", ":", "-."), strict=False):
            error = np.hypot(of[name]["north"], of[name]["east"])
            panel.plot(of[name]["time"], error, look, color=COLOURS[name], lw=0.9, label=TITLES[name])
        decades(panel)
        panel.set(xlabel="time [s]", ylabel="horizontal error [m]", ylim=(0.05, 30))
        panel.legend(**above)
    return figure


def attitude(solution: DriveSolution, aboard: pd.DataFrame) -> Figure:
    """Draw roll, pitch and heading over time, and how far those of the filter aboard are from them."""
    figure, grid = panels_of(3, 2, 4.2, sharex=True)
    table, std = solution.trajectory[::10], solution.trajectory_std[::10]
    for (left, right), name in zip(grid, ATTITUDE, strict=True):
        theirs = np.interp(table.index, aboard.index, np.unwrap(aboard[name]))
        difference = np.angle(np.exp(1j * (table[name] - theirs)))
        left.plot(table.index, np.degrees(table[name]), color="#0072B2", lw=0.6, label="filter here")
        left.set_ylabel(f"{name} [°]")
        spread = np.degrees(std[name])
        right.fill_between(table.index, -spread, spread, color="#0072B2", lw=0, alpha=0.3, label="σ, filter here")
        right.plot(table.index, np.degrees(difference), color="black", lw=0.7, label="filter here less filter aboard")
        limit = max(3 * float(np.median(np.abs(np.degrees(difference)))), 3 * float(np.median(spread)))
        right.set(ylim=(-2 * limit, 2 * limit))
    label_lowest(grid, "time [s]")
    legend_below(figure, 3)
    return figure
