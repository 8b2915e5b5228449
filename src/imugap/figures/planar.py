"""Figures of the chapter on augmentation: each function draws one figure from tables and returns it."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from imugap.figures.style import WIDTH, NotebookFigure, decades, label_lowest, legend_below, panels_of
from imugap.navigation.planar import SCOPES, PlanarDrive
from imugap.units import from_si

COLOURS = {"N": "#56B4E9", "N + K": "#E69F00", "N + B": "#CC79A7", "N + B + K": "#009E73"}
"""One colour per model of a filter in every figure."""
UNITS = {"position": "m", "velocity": "m/s", "heading": "deg", "gyro bias": "deg/h", "accel bias": "mg"}
"""Unit in which a quantity is shown."""
CASES = {"gauss_markov": "truth: Gauss-Markov", "flicker": "truth: flicker"}


def spread(table: pd.DataFrame, outages: Sequence[tuple[float, float]]) -> Figure:
    """Draw predicted and actual standard deviation over time, a row per filter and a column per quantity.

    Parameters
    ----------
    table
        Columns ``filter``, ``quantity``, ``time``, ``predicted``, ``actual``, ``low``, ``high``, ``computed``; SI.
    outages
        Start and end of each stretch without fixes [s].
    """
    filters = list(table["filter"].unique())
    figure, grid = panels_of(len(filters), len(UNITS), 1.35 * len(filters) + 0.6, sharex=True, sharey="col")
    for row, (title, of_filter) in zip(grid, table.groupby("filter", sort=False), strict=True):
        for panel, (quantity, unit) in zip(row, UNITS.items(), strict=True):
            one = of_filter[of_filter["quantity"] == quantity]
            time = one["time"].to_numpy()
            predicted, actual, low, high, computed = (
                from_si(one[name].to_numpy(), unit) for name in ("predicted", "actual", "low", "high", "computed")
            )
            for start, stop in outages:
                panel.axvspan(start, stop, color="#eeeeee", lw=0, zorder=0)
            panel.fill_between(time, low, high, color="#999999", lw=0, alpha=0.6, label="actual, 95 % interval")
            panel.plot(time, actual, color="black", lw=0.7, label="actual (Monte Carlo)")
            if np.isfinite(computed).any():
                panel.plot(time, computed, color="#D55E00", lw=0.7, ls=":", label="actual (covariance analysis)")
            panel.plot(time, predicted, color=COLOURS[title], lw=1.2, label=f"predicted, {title}")
            panel.set(xlim=(0, time[-1]))
        row[0].set_ylabel(title)
    for panel, (quantity, unit) in zip(grid[0], UNITS.items(), strict=True):
        panel.set_title(f"{quantity} [{unit.replace('deg', '°')}]")
        decades(panel)
    label_lowest(grid, "time [s]")
    legend_below(figure, 4)
    return figure


def consistency(table: pd.DataFrame, drive: PlanarDrive) -> Figure:
    """Draw the drive, and the NEES of every filter over time with its two-sided band.

    Parameters
    ----------
    table
        Columns ``case``, ``filter``, ``scope``, ``states``, ``time``, ``nees``, ``low``, ``high``.
    """
    figure = NotebookFigure(figsize=(WIDTH, 4.6), layout="constrained")
    titles = [[f"{scope}, {case}" for case in CASES.values()] for scope in SCOPES]
    panels = figure.subplot_mosaic([["drive", *row] for row in titles], width_ratios=[0.9, *[1] * len(CASES)])
    _draw_drive(panels["drive"], drive)
    for (scope, case), one in table.groupby(["scope", "case"], sort=False):
        title, states = f"{scope}, {CASES[case]}", one["states"].iloc[0]
        panel, band = panels[title], one[one["filter"] == one["filter"].iloc[0]]
        panel.fill_between(
            band["time"], band["low"] / states, band["high"] / states, color="#bbbbbb", lw=0, zorder=5,
            label="95 % band of a consistent filter",
        )  # fmt: skip
        for name, lines in one.groupby("filter", sort=False):
            panel.plot(lines["time"], lines["nees"] / states, color=COLOURS[name], lw=0.8, label=name, zorder=6)
        panel.set(title=title, xlim=(0, band["time"].max()))
        decades(panel)
    for row in titles:
        panels[row[0]].set_ylabel("mean NEES / states")
        panels[row[0]].sharey(panels[row[1]])
    for title in titles[-1]:
        panels[title].set_xlabel("time [s]")
    legend_below(figure, 4)
    return figure


def _draw_drive(panel, drive: PlanarDrive) -> None:
    """Draw the drive from above, stretches without fixes thick."""
    north, east = drive.states[:: drive.every, 0][1:], drive.states[:: drive.every, 1][1:]
    north, east = north[: len(drive.aided)], east[: len(drive.aided)]
    panel.plot(east / 1e3, north / 1e3, color="black", lw=0.5, label="with fixes")
    gap = np.where(drive.aided, np.nan, north)
    panel.plot(east / 1e3, gap / 1e3, color="#D55E00", lw=1.8, label="outage")
    panel.set(xlabel="east [km]", ylabel="north [km]", title="drive", aspect="equal")
