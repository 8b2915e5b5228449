"""Figures of a walk: each function draws one figure from a solution and returns it."""

import numpy as np
from matplotlib.figure import Figure

from imugap.figures.style import WIDTH, panels_of
from imugap.filters.zero_velocity import MOVING
from imugap.navigation.pedestrian import WalkSolution

COLOUR = "#0072B2"
STANCE = "#D55E00"
LEVEL = 0.99
"""Probability that the ellipse of the end holds."""
POINTS = 4000
"""Points of a curve: more than a page shows."""


def plan(solution: WalkSolution) -> Figure:
    """Draw the walk from above: path, stances, begin, and the end with its ellipse."""
    figure = Figure(figsize=(WIDTH, 0.7 * WIDTH), layout="constrained")
    panel = figure.subplots()
    path = solution.trajectory[["east", "north"]].to_numpy()
    panel.plot(*path[:: _every(solution)].T, color=COLOUR, lw=0.7, label="path")
    panel.plot(*path[solution.stances()].T, ".", color=STANCE, ms=4, label="stances")
    panel.plot(*path[0], "o", color="black", ms=5, label="begin")
    panel.plot(*ellipse(path[-1], solution.horizontal[-1][::-1, ::-1]).T, color="black", lw=0.8,
               label=f"end, {LEVEL:.0%}")  # fmt: skip
    panel.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    panel.legend()
    return figure


def ellipse(middle: np.ndarray, covariance: np.ndarray, level: float = LEVEL) -> np.ndarray:
    """Return points, shape (n, 2), of the ellipse that holds a normal variable with this probability.

    The squared radius is that of chi-square with two degrees of freedom, -2 ln(1 - level).
    """
    angle = np.linspace(0, 2 * np.pi, 181)
    values, vectors = np.linalg.eigh(covariance)
    circle = np.column_stack([np.cos(angle), np.sin(angle)]) * np.sqrt(-2 * np.log(1 - level))
    return middle + circle * np.sqrt(np.maximum(values, 0)) @ vectors.T


def height(solution: WalkSolution) -> Figure:
    """Draw height and heading over time, with their standard deviations, and the speed with the stances."""
    figure, grid = panels_of(3, 1, 5.0, sharex=True)
    every = _every(solution)
    table, std = solution.trajectory[::every], solution.trajectory_std[::every]
    time = table.index.to_numpy()
    heading = np.degrees(np.unwrap(table["heading"]))
    for panel, title, values, spread in (
        (grid[0, 0], "height [m]", -table["down"], std["down"]),
        (grid[1, 0], "heading [°]", heading, np.degrees(std["heading"])),
    ):
        panel.fill_between(time, values - spread, values + spread, color=COLOUR, lw=0, alpha=0.25)
        panel.plot(time, values, color=COLOUR, lw=0.7)
        panel.set_ylabel(title)
    speed = np.linalg.norm(table[["vel_n", "vel_e", "vel_d"]], axis=1)
    grid[2, 0].plot(time, speed, color=COLOUR, lw=0.6)
    grid[2, 0].plot(
        time, np.where(solution.phase[::every] > MOVING, speed, np.nan), color=STANCE, lw=1.2, label="stance"
    )
    grid[2, 0].set(xlabel="time [s]", ylabel="speed [m/s]", xlim=(time[0], time[-1]))
    grid[2, 0].legend()
    return figure


def _every(solution: WalkSolution) -> int:
    return -(-len(solution.phase) // POINTS)
