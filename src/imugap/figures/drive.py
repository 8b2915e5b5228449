"""Figures of a drive: each function draws one figure from solutions or tables and returns it."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from imugap.figures.style import (
    WIDTH,
    NotebookFigure,
    card,
    decades,
    few_ticks,
    label_lowest,
    legend_below,
    panels_of,
    time_axis,
)
from imugap.filters.innovation_gate import (
    ACCEPTED,
    EXCLUDED,
    FAILED,
    REMOVED,
    RESET,
    SET_ASIDE,
    WEIGHED,
    InnovationRecord,
)
from imugap.io import gnss
from imugap.log import AXES
from imugap.navigation.drive.vehicle import DriveSolution

FILTER, SMOOTHER, FIX = "#0072B2", "#009E73", "#999999"
COLOURS = {WEIGHED: "#E69F00", REMOVED: "#D55E00", FAILED: "#D55E00", SET_ASIDE: "#CC79A7", RESET: "black"}
"""Colours of the events of the quality control, by their names."""
TAKEN, SHIFTED = "taken as it is", "with an offset"
"""Names of fixes without an event, and of those whose place has an offset of its own."""
PLACE = 3
"""Components of a place, the first ones of a fix."""
LINEAR = 5.0
"""Innovations, in their standard deviations, up to which an axis is linear."""
POINTS = 4000
"""Points of a curve: more than a page shows."""
OVER_TIME = {
    "speed": ("speed [m/s]", "σ of velocity [m/s]"),
    "height": ("height [m]", "σ of position [m]"),
    "heading": ("heading [°]", "σ of heading [°]"),
}
"""What is drawn over time, its title, and that of the standard deviation beside it."""
UNITS = {"gyro": ("°/h", np.degrees(3600.0)), "accel": ("mg", 1e3 / 9.80665), "scale": ("10⁻³", 1e3)}


def track(filtered: DriveSolution, smoothed: DriveSolution, fixes: pd.DataFrame, width: float = WIDTH) -> Figure:
    """Draw the drive from above, like a map ``width`` [inch] wide: fixes, those that did not fit, filter, smoother."""
    figure = NotebookFigure(figsize=(width, 0.85 * width), layout="constrained")
    panel = figure.subplots()
    seen, record = gnss.local(fixes, filtered.ellipsoid), filtered.record
    panel.plot(seen[:, 1], seen[:, 0], ".", color=FIX, ms=2.5, label="fixes", zorder=1)
    offered = np.searchsorted(fixes.index, filtered.fix_time)
    share, aside = np.nanmin(record.share, axis=1, initial=1.0), record.position_use == EXCLUDED
    for label, rows in _used(share, aside).items():
        if rows.any():
            panel.plot(*seen[offered[rows]][:, [1, 0]].T, "x", color=COLOURS[label], ms=4, label=label, zorder=2)
    for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
        path = one.history.navigation[:: _every(one), :2]
        panel.plot(path[:, 1], path[:, 0], color=colour, lw=0.8, label=label, zorder=3)
    begin = filtered.history.navigation[0]
    panel.plot(begin[1], begin[0], "o", color="black", ms=4, label="begin", zorder=4)
    panel.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    few_ticks(panel)
    panel.set_adjustable("datalim")
    legend_below(figure, 3 if width < WIDTH else 6)
    return figure


def motion(filtered: DriveSolution, smoothed: DriveSolution) -> Figure:
    """Draw speed, height and heading over time, and the standard deviations of filter and smoother."""
    figure, grid = panels_of(3, 2, 5.4, sharex=True)
    for panels, (name, titles) in zip(grid, OVER_TIME.items(), strict=True):
        for panel, title in zip(panels, titles, strict=True):
            panel.set_title(title)
        _over_time(panels, filtered, smoothed, name)
    label_lowest(grid, _clock(filtered)[1])
    legend_below(figure, 2)
    return figure


def over_time(filtered: DriveSolution, smoothed: DriveSolution, name: str) -> Figure:
    """Draw one of :data:`OVER_TIME` and the standard deviation beside it over time, as wide as a phone."""
    figure, panels = card(3.0, rows=2, sharex=True)
    _over_time(panels, filtered, smoothed, name)
    for panel, title in zip(panels, OVER_TIME[name], strict=True):
        panel.set_ylabel(title)
    panels[-1].set_xlabel(_clock(filtered)[1])
    legend_below(figure, 2)
    return figure


def _over_time(panels: Sequence[Axes], filtered: DriveSolution, smoothed: DriveSolution, name: str) -> None:
    """Draw values in the first panel, and standard deviations in the second, of filter and smoother."""
    for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
        every = _every(one)
        table, std = one.trajectory[::every], one.trajectory_std[::every]
        drawn = {
            "speed": (
                np.linalg.norm(table[["vel_n", "vel_e", "vel_d"]], axis=1),
                np.linalg.norm(std[["vel_n", "vel_e"]], axis=1),
            ),
            "height": (one.geodetic["height"].to_numpy()[::every], np.linalg.norm(std[["north", "east"]], axis=1)),
            "heading": (np.degrees(np.unwrap(table["heading"])), np.degrees(std["heading"])),
        }
        for panel, values in zip(panels, drawn[name], strict=True):
            panel.plot(table.index.to_numpy() - _clock(filtered)[0], values, color=colour, lw=0.8, label=label)
    decades(panels[1])


def sensors(filtered: DriveSolution, smoothed: DriveSolution) -> Figure:
    """Draw the estimated errors of the six axes over time, with their standard deviations."""
    figure, grid = panels_of(2, 3, 3.8, sharex=True)
    for axis, panel in zip(AXES, grid.flat, strict=True):
        panel.set_title(_error_title(axis))
        _sensor(panel, filtered, smoothed, axis)
    label_lowest(grid, _clock(filtered)[1])
    legend_below(figure, 2)
    return figure


def sensor(filtered: DriveSolution, smoothed: DriveSolution, axis: str) -> Figure:
    """Draw the estimated error of one axis over time, with its standard deviation, as wide as a phone."""
    figure, (panel,) = card(2.0)
    _sensor(panel, filtered, smoothed, axis)
    panel.set(ylabel=_error_title(axis), xlabel=_clock(filtered)[1])
    legend_below(figure, 2)
    return figure


def _error_title(axis: str) -> str:
    return f"{axis.replace('_', ' ')} [{UNITS[axis.split('_')[0]][0]}]"


def _sensor(panel: Axes, filtered: DriveSolution, smoothed: DriveSolution, axis: str) -> None:
    if axis not in filtered.names:
        return
    _, factor = UNITS[axis.split("_")[0]]
    for one, colour, label in ((filtered, FILTER, "filter"), (smoothed, SMOOTHER, "smoother")):
        every = _every(one)
        time = one.time.to_numpy()[::every] - _clock(filtered)[0]
        values, spread = (factor * table[axis].to_numpy()[::every] for table in (one.sensors, one.sensors_std))
        panel.fill_between(time, values - spread, values + spread, color=colour, lw=0, alpha=0.25)
        panel.plot(time, values, color=colour, lw=0.8, label=label)


def quality(solution: DriveSolution) -> Figure:
    """Draw the innovations of the components over their standard deviations, and the global test, over time."""
    record = solution.record
    shown = np.flatnonzero(np.isfinite(record.innovation).any(axis=0))
    figure, grid = panels_of(len(shown) + 1, 1, 0.85 * len(shown) + 1.6, sharex=True)
    for panel, i in zip(grid[:, 0], shown, strict=False):
        _component(panel, solution.fix_time - _clock(solution)[0], record, int(i))
        if solution.quality.component is not None:
            for sign in (-1, 1):
                panel.axhline(sign * solution.quality.component, color="black", lw=0.6, ls=":")
    _global_test(grid[-1, 0], solution)
    legend_below(figure, 5)
    return figure


def global_test(solution: DriveSolution) -> Figure:
    """Draw the global test of the innovations over time, as wide as a phone."""
    figure, (panel,) = card(2.4)
    _global_test(panel, solution)
    panel.set_ylabel("squared innovations / variance")
    legend_below(figure, 2)
    return figure


def _global_test(panel: Axes, solution: DriveSolution) -> None:
    record, limits = solution.record, solution.quality.limits(len(gnss.COMPONENTS))
    time = solution.fix_time - _clock(solution)[0]
    aside = record.position_use == EXCLUDED
    shifted = (record.position_use != ACCEPTED) & ~aside
    panel.plot(time, limits[record.freedom], color="black", lw=0.6, ls=":")
    for rows, colour, look, label in (
        (record.passed & ~aside & ~shifted, FILTER, ".", "global test passed"),
        (~record.passed, COLOURS[FAILED], "x", FAILED), (aside, COLOURS[SET_ASIDE], "o", SET_ASIDE),
        (shifted, SMOOTHER, ".", SHIFTED), (record.reset, COLOURS[RESET], "v", RESET),
    ):  # fmt: skip
        if rows.any():
            size = 2.5 if look == "." else 4
            panel.plot(time[rows], record.statistic[rows], look, color=colour, ms=size, mfc="none", label=label)
    panel.set(ylabel="global", yscale="log", xlabel=_clock(solution)[1])


def _used(share: np.ndarray, aside: np.ndarray) -> dict[str, np.ndarray]:
    """Return by name of the event which fixes had it, from their least share and whether their place is set aside."""
    return {
        WEIGHED: (share < 1) & (share > 0) & ~aside,
        REMOVED: (share == 0) & ~aside,
        SET_ASIDE: aside,
    }


def _component(panel, time: np.ndarray, record: InnovationRecord, number: int) -> None:
    """Draw one component of the innovations over its standard deviation; the axis is linear up to 5."""
    size = record.innovation[:, number] / np.sqrt(record.variance[:, number])
    aside = (record.position_use == EXCLUDED) & (number < PLACE)
    used = _used(record.share[:, number], aside)
    taken = {TAKEN: (record.share[:, number] == 1) & ~aside}
    for label, rows in (taken | used).items():
        if rows.any():
            panel.plot(time[rows], size[rows], ".", color=COLOURS.get(label, FILTER), ms=2.5, label=label)
    panel.set_yscale("symlog", linthresh=LINEAR)
    limit = max(LINEAR, 1.2 * np.nanmax(np.abs(size), initial=0.0))
    ticks = [sign * tick for tick in (3, 10, 100) if tick <= limit for sign in (-1, 1)]
    panel.set(ylabel=gnss.COMPONENTS[number].replace("_", " "), ylim=(-limit, limit))
    panel.set_yticks([0, *ticks], [str(tick) for tick in (0, *ticks)], minor=False)
    panel.minorticks_off()


def _every(solution: DriveSolution) -> int:
    return -(-len(solution.time) // POINTS)


def _clock(solution: DriveSolution) -> tuple[float, str]:
    """Return the instant from which time is drawn [s], and the label of the axis."""
    return time_axis(*solution.trajectory.index[[0, -1]])
