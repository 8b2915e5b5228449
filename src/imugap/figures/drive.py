"""Figures of a drive: each function draws one figure from solutions or tables and returns it."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from imugap.figures.style import WIDTH, decades, legend_below, panels_of
from imugap.filters.innovation_gate import ACCEPTED, InnovationRecord
from imugap.io import gnss
from imugap.log import AXES
from imugap.navigation.vehicle import DriveSolution

FILTER, SMOOTHER, FIX, WEIGHED, REMOVED = "#0072B2", "#009E73", "#999999", "#E69F00", "#D55E00"
OFFSET = "#CC79A7"
LINEAR = 5.0
"""Innovations, in their standard deviations, up to which an axis is linear."""
POINTS = 4000
"""Points of a curve: more than a page shows."""
UNITS = {"gyro": ("°/h", np.degrees(3600.0)), "accel": ("mg", 1e3 / 9.80665), "scale": ("10⁻³", 1e3)}


def track(filtered: DriveSolution, smoothed: DriveSolution, fixes: pd.DataFrame) -> Figure:
    """Draw the drive from above, like a map: fixes, those that did not fit, filter and smoother."""
    figure = Figure(figsize=(WIDTH, 0.75 * WIDTH), layout="constrained")
    panel = figure.subplots()
    seen, record = gnss.local(fixes, filtered.ellipsoid), filtered.record
    panel.plot(seen[:, 1], seen[:, 0], ".", color=FIX, ms=2.5, label="fixes", zorder=1)
    offered = np.searchsorted(fixes.index, filtered.fix_time)
    share = np.nanmin(record.share, axis=1, initial=1.0)
    for rows, colour, label in (
        ((share < 1) & (share > 0), WEIGHED, "weighed down"), (share == 0, REMOVED, "a component removed"),
    ):  # fmt: skip
        if rows.any():
            panel.plot(*seen[offered[rows]][:, [1, 0]].T, "x", color=colour, ms=4, label=label, zorder=2)
    for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
        path = one.history.navigation[:: _every(one), :2]
        panel.plot(path[:, 1], path[:, 0], color=colour, lw=0.8, label=label, zorder=3)
    begin = filtered.history.navigation[0]
    panel.plot(begin[1], begin[0], "o", color="black", ms=4, label="begin", zorder=4)
    panel.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    panel.legend(loc="best")
    return figure


def motion(filtered: DriveSolution, smoothed: DriveSolution) -> Figure:
    """Draw speed, height and heading over time, and the standard deviations of filter and smoother."""
    figure, grid = panels_of(3, 2, 5.4, sharex=True)
    for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
        every = _every(one)
        table, std = one.trajectory[::every], one.trajectory_std[::every]
        time = table.index.to_numpy()
        speed = np.linalg.norm(table[["vel_n", "vel_e", "vel_d"]], axis=1)
        rows = (
            (speed, np.linalg.norm(std[["vel_n", "vel_e"]], axis=1)),
            (one.geodetic["height"].to_numpy()[::every], np.linalg.norm(std[["north", "east"]], axis=1)),
            (np.degrees(np.unwrap(table["heading"])), np.degrees(std["heading"])),
        )
        for panels, (values, spread) in zip(grid, rows, strict=True):
            panels[0].plot(time, values, color=colour, lw=0.8, label=label)
            panels[1].plot(time, spread, color=colour, lw=0.8, label=label)
    titles = (
        ("speed [m/s]", "σ of velocity [m/s]"),
        ("height [m]", "σ of position [m]"),
        ("heading [°]", "σ of heading [°]"),
    )
    for panels, pair in zip(grid, titles, strict=True):
        for panel, title in zip(panels, pair, strict=True):
            panel.set_title(title)
        decades(panels[1])
    for panel in grid[-1]:
        panel.set_xlabel("time [s]")
    legend_below(figure, 2)
    return figure


def sensors(filtered: DriveSolution, smoothed: DriveSolution) -> Figure:
    """Draw the estimated errors of the six axes over time, with their standard deviations."""
    figure, grid = panels_of(2, 3, 3.8, sharex=True)
    for axis, panel in zip(AXES, grid.flat, strict=True):
        unit, factor = UNITS[axis.split("_")[0]]
        panel.set_title(f"{axis.replace('_', ' ')} [{unit}]")
        if axis not in filtered.names:
            continue
        for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
            every = _every(one)
            time = one.time.to_numpy()[::every]
            values, spread = (factor * table[axis].to_numpy()[::every] for table in (one.sensors, one.sensors_std))
            panel.fill_between(time, values - spread, values + spread, color=colour, lw=0, alpha=0.25)
            panel.plot(time, values, color=colour, lw=0.8, label=label)
    for panel in grid[-1]:
        panel.set_xlabel("time [s]")
    legend_below(figure, 2)
    return figure


def quality(solution: DriveSolution) -> Figure:
    """Draw the innovations of the components over their standard deviations, and the global test, over time."""
    record, limits = solution.record, solution.quality.limits(len(gnss.COMPONENTS))
    shown = np.flatnonzero(np.isfinite(record.innovation).any(axis=0))
    figure, grid = panels_of(len(shown) + 1, 1, 0.85 * len(shown) + 1.6, sharex=True)
    for panel, i in zip(grid[:, 0], shown, strict=False):
        _component(panel, solution.fix_time, record, int(i))
        if solution.quality.component is not None:
            for sign in (-1, 1):
                panel.axhline(sign * solution.quality.component, color="black", lw=0.6, ls=":")
    panel = grid[-1, 0]
    panel.plot(solution.fix_time, record.statistic, ".", color=FILTER, ms=2.5, label="taken as it is")
    panel.plot(solution.fix_time, limits[record.freedom], color="black", lw=0.6, ls=":")
    panel.plot(
        solution.fix_time[record.reset], record.statistic[record.reset], "v", color="black", ms=5, label="soft reset"
    )
    doubted = record.position_use != ACCEPTED
    panel.plot(
        solution.fix_time[doubted], record.statistic[doubted], ".", color=OFFSET, ms=4, label="place not trusted"
    )
    panel.set(ylabel="global", yscale="log", xlabel="time [s]")
    legend_below(figure, 5)
    return figure


def _component(panel, time: np.ndarray, record: InnovationRecord, number: int) -> None:
    """Draw one component of the innovations over its standard deviation; the axis is linear up to 5."""
    size = record.innovation[:, number] / np.sqrt(record.variance[:, number])
    share = record.share[:, number]
    for rows, colour, label in (
        (share == 1, FILTER, "taken as it is"), ((share < 1) & (share > 0), WEIGHED, "weighed down"),
        (share == 0, REMOVED, "removed"),
    ):  # fmt: skip
        if rows.any():
            panel.plot(time[rows], size[rows], ".", color=colour, ms=2.5, label=label)
    panel.set_yscale("symlog", linthresh=LINEAR)
    limit = max(LINEAR, 1.2 * np.nanmax(np.abs(size), initial=0.0))
    ticks = [sign * tick for tick in (3, 10, 30, 100, 300) if tick <= limit for sign in (-1, 1)]
    panel.set(ylabel=gnss.COMPONENTS[number].replace("_", " "), ylim=(-limit, limit))
    panel.set_yticks([0, *ticks], [str(tick) for tick in (0, *ticks)], minor=False)
    panel.minorticks_off()


def _every(solution: DriveSolution) -> int:
    return -(-len(solution.time) // POINTS)
