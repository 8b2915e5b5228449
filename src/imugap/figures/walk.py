"""Figures of a walk: each function draws one figure from a solution and returns it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from imugap.figures.style import WIDTH, NotebookFigure, card, few_ticks, legend_below, panels_of, time_axis
from imugap.filters.zero_velocity import MOVING
from imugap.navigation.walk.pedestrian import WalkSolution
from imugap.numerics.samples.chi_square import squared_radius

COLOUR = "#0072B2"
STANCE = "#D55E00"
LEVEL = 0.99
"""Probability that the ellipse of the end holds."""
SEEN = 0.05
"""Least width of that ellipse, relative to the walk, at which it is larger than a marker."""
POINTS = 4000
"""Points of a curve: more than a page shows."""
OVER_TIME = {"height": "height [m]", "heading": "heading [°]", "speed": "speed [m/s]"}
"""What is drawn over time, and its label."""


def plan(solution: WalkSolution, width: float = WIDTH) -> Figure:
    """Draw the walk from above, ``width`` [inch] wide: path, stances, begin, and the end with its ellipse."""
    figure = NotebookFigure(figsize=(width, 0.8 * width), layout="constrained")
    panel = figure.subplots()
    path = solution.trajectory[["east", "north"]].to_numpy()
    panel.plot(*path[:: _every(solution)].T, color=COLOUR, lw=0.7, label="path")
    panel.plot(*path[solution.stances()].T, ".", color=STANCE, ms=4, label="stances")
    panel.plot(*path[0], "o", color="black", mfc="none", ms=6, label="begin")
    edge = ellipse(path[-1], solution.horizontal[-1][::-1, ::-1])
    seen = np.ptp(edge, axis=0).max() > SEEN * np.ptp(path, axis=0).max()
    if seen:
        panel.plot(*edge.T, color="black", lw=0.8, label=f"end, {LEVEL:.0%}")
    panel.plot(*path[-1], "x", color="black", ms=4, label=None if seen else "end")
    panel.set(xlabel="right of the heading at the begin [m]", ylabel="along that heading [m]", aspect="equal")
    few_ticks(panel)
    panel.set_adjustable("datalim")
    legend_below(figure, 4)
    return figure


def ellipse(middle: np.ndarray, covariance: np.ndarray, level: float = LEVEL) -> np.ndarray:
    """Return points, shape (n, 2), of the ellipse that holds a normal variable with this probability."""
    angle = np.linspace(0, 2 * np.pi, 181)
    values, vectors = np.linalg.eigh(covariance)
    circle = np.column_stack([np.cos(angle), np.sin(angle)]) * np.sqrt(squared_radius(level))
    return middle + circle * np.sqrt(np.maximum(values, 0)) @ vectors.T


def all_over_time(solution: WalkSolution) -> Figure:
    """Draw height and heading over time, with their standard deviations, and the speed with the stances."""
    figure, grid = panels_of(3, 1, 5.0, sharex=True)
    for panel, name in zip(grid[:, 0], OVER_TIME, strict=True):
        _over_time(panel, solution, name)
    grid[2, 0].set_xlabel(_clock(solution)[1])
    legend_below(figure, 2)
    return figure


def over_time(solution: WalkSolution, name: str) -> Figure:
    """Draw one of :data:`OVER_TIME` over time, as wide as a phone."""
    figure, (panel,) = card(2.0)
    _over_time(panel, solution, name)
    panel.set_xlabel(_clock(solution)[1])
    if name == "speed":
        legend_below(figure, 2)
    return figure


def _over_time(panel: Axes, solution: WalkSolution, name: str) -> None:
    """Draw height or heading with its standard deviation, or the speed with the stances."""
    every = _every(solution)
    table, std = solution.trajectory[::every], solution.trajectory_std[::every]
    time = table.index.to_numpy() - _clock(solution)[0]
    if name == "speed":
        values = np.linalg.norm(table[["vel_n", "vel_e", "vel_d"]], axis=1)
        panel.plot(time, values, color=COLOUR, lw=0.6, label="speed")
        stands = np.where(solution.phase[::every] > MOVING, values, np.nan)
        panel.plot(time, stands, color=STANCE, lw=1.2, label="stance")
    else:
        heading = np.degrees(np.unwrap(table["heading"])), np.degrees(std["heading"])
        values, spread = (-table["down"], std["down"]) if name == "height" else heading
        panel.fill_between(time, values - spread, values + spread, color=COLOUR, lw=0, alpha=0.25)
        panel.plot(time, values, color=COLOUR, lw=0.7)
    panel.set(ylabel=OVER_TIME[name], xlim=(time[0], time[-1]))


def _clock(solution: WalkSolution) -> tuple[float, str]:
    return time_axis(*solution.trajectory.index[[0, -1]])


def _every(solution: WalkSolution) -> int:
    return -(-len(solution.phase) // POINTS)
