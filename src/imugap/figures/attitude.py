"""Figures of the chapter on attitude: each function draws one figure from tables and returns it."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from imugap.figures.style import label_lowest, legend_below, panels_of

TITLES = {
    "allan": "scheme 1 (Allan)",
    "indirect": "scheme 2 (indirect)",
    "likelihood": "likelihood",
    "truth": "true parameters",
}
COLOURS = {"allan": "black", "indirect": "#0072B2", "likelihood": "#009E73", "truth": "#E69F00"}
"""One colour per scheme; the reference is red, as in the source."""
WIDTHS = {"likelihood": 1.8, "truth": 1.8, "indirect": 1.1, "allan": 0.6}
"""Widths of the lines, in the order in which they are drawn: none hides another."""
REFERENCE = "#D55E00"
SHADE = {"color": "#eeeeee", "lw": 0, "zorder": 0}
ANGLES = {"heading": "yaw", "pitch": "pitch", "roll": "roll"}
"""Angle to its name in the source, in the order of its figures 6 to 8."""
SMALLEST_GAP = 0.5
"""Time [s] without a reference from which on a line is interrupted."""


def flight(truth: pd.DataFrame, errors: pd.DataFrame, disturbance: tuple[float, float]) -> Figure:
    """Draw attitude and error of one flight (Liu, Ren, Li 2016, figures 6 to 8).

    Parameters
    ----------
    truth
        Index ``time`` [s], columns :data:`imugap.kinematics.strapdown.ATTITUDE` [rad].
    errors
        Columns ``time``, ``scheme`` and the same angles: estimated - true [rad].
    disturbance
        Begin and end [s].
    """
    figure, grid = panels_of(2, 3, 3.8, sharex=True)
    for (upper, lower), (angle, title) in zip(grid.T, ANGLES.items(), strict=True):
        time = errors["time"].unique()
        true = np.interp(time, truth.index, np.unwrap(truth[angle]))
        for panel in (upper, lower):
            panel.axvspan(*disturbance, **SHADE)
        for one, style in _of_schemes(errors):
            upper.plot(one["time"], np.degrees(true + one[angle].to_numpy()), **style)
            lower.plot(one["time"], np.degrees(one[angle]), **style)
        upper.plot(time, np.degrees(true), color=REFERENCE, lw=0.9, ls="--", label="true attitude")
        lower.axhline(0, color="#888888", lw=0.5)
        upper.set(title=title, xlim=(time[0], time[-1]))
        lower.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("attitude [°]")
    grid[1, 0].set_ylabel("error [°]")
    legend_below(figure, 5)
    return figure


def runs(scores: pd.DataFrame) -> Figure:
    """Draw the error variance of every scheme over that with the true parameters, flight by flight.

    Parameters
    ----------
    scores
        Columns ``run``, ``minutes`` (0 with the true parameters), ``scheme``, ``angle``, ``variance``.
    """
    lengths = sorted(set(scores["minutes"]) - {0})
    figure, grid = panels_of(1, 3, 2.7, sharey=True)
    table = scores.set_index(["angle", "minutes", "scheme", "run"])["variance"]
    for panel, (angle, title) in zip(grid[0], ANGLES.items(), strict=True):
        marks = []
        for k, minutes in enumerate(lengths):
            for j, scheme in enumerate(("allan", "indirect", "likelihood")):
                ratio = (table[angle, minutes, scheme] / table[angle, 0, "truth"]).sort_index()
                place = 4 * k + j
                scatter = place + 0.5 * (np.arange(len(ratio)) / len(ratio) - 0.5)
                panel.plot(scatter, ratio, ".", ms=3, alpha=0.6, color=COLOURS[scheme], label=TITLES[scheme])
                panel.plot([place - 0.35, place + 0.35], [ratio.median()] * 2, color=COLOURS[scheme], lw=1.6)
            marks.append((4 * k + 1, f"{minutes} min"))
        panel.axhline(1, color="#888888", lw=0.6)
        panel.set(title=title, yscale="log", xlabel="static log")
        panel.set_xticks(*zip(*marks, strict=True))
        panel.yaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 5, 7), numticks=12))
        panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        panel.yaxis.set_minor_formatter(NullFormatter())
    grid[0, 0].set_ylabel("variance / that with\ntrue parameters")
    legend_below(figure, 3)
    return figure


def trials(errors: pd.DataFrame, titles: dict[int, str], models: Sequence[str]) -> Figure:
    """Draw the errors of the trials: a row per trial, columns tilt and heading for each model.

    Parameters
    ----------
    errors
        Columns ``trial``, ``model``, ``scheme``, ``time`` [s], ``north``, ``east``, ``down`` [rad].
    titles
        Trial to its name.
    models
        The models, in order: from the rest, and with a margin.
    """
    heads = {"tilt": "tilt", "down": "heading"}
    labels = {"rest": "model of the rest", "margin": "with a margin for motion"}
    figure, grid = panels_of(len(titles), 2 * len(models), 1.35 * len(titles) + 0.7, sharex="row")
    errors = errors.assign(tilt=np.hypot(errors["north"], errors["east"]))
    for row, (trial, title) in zip(grid, titles.items(), strict=True):
        for panels, model in zip((row[:2], row[2:]), models, strict=False):
            one = errors[(errors["trial"] == trial) & (errors["model"] == model)]
            for line, style in _of_schemes(one):
                gaps = line["time"].diff() > SMALLEST_GAP
                for panel, angle in zip(panels, heads, strict=True):
                    panel.plot(line["time"], np.degrees(line[angle]).mask(gaps), **style)
        row[0].set_ylabel(f"{title}\nerror [°]")
    for k, model in enumerate(models):
        for j, head in enumerate(heads.values()):
            grid[0, 2 * k + j].set_title(f"{head},\n{labels[model]}")
    label_lowest(grid, "time [s]")
    legend_below(figure, 3)
    return figure


def _of_schemes(errors: pd.DataFrame) -> Iterator[tuple[pd.DataFrame, dict]]:
    """Yield the rows of each scheme that has any, and the style of its line."""
    for scheme, width in WIDTHS.items():
        rows = errors[errors["scheme"] == scheme]
        if len(rows):
            yield rows, {"color": COLOURS[scheme], "lw": width, "label": TITLES[scheme]}
