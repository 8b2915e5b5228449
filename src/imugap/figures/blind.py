"""Figures of the blind benchmark: each function draws one figure from the tables of the scores and returns it."""

from math import ceil
from textwrap import fill

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator, PercentFormatter
from scipy.stats import binom

from imu_benchmark.scores import ALL, DISTANCES, LEVEL, NONE, UNKNOWN
from imugap.effects import title_of
from imugap.figures.discovery import AFTER, BEFORE, NAMES, PLAIN
from imugap.figures.style import legend_below, panels_of, text_figure
from imugap.figures.views import VIEWS

FOUND, NAMED, BAND = "#0072B2", "#D55E00", "#cccccc"
SCORES = {"detected": ("found", FOUND, 0.94), "named": ("rightly named", NAMED, 1.06)}
"""Title, colour, and factor by which the points are moved aside."""
FARTHEST = 3.0
"""Error, in half widths of the interval, beyond which it is drawn at the edge."""
DRAWN = ("before", "after", "floor_low", "floor_high")
HIGHEST = 1e3
"""Largest distance over the floor drawn; from a model that does not scatter it has no bound."""
TITLE_WIDTH = 22
"""Characters in a line of the title of a small panel."""
LOWEST = 1e-3
"""Smallest p-value drawn."""


def detection(rates: pd.DataFrame, clear: float) -> Figure:
    """Draw how often effects hidden singly are found and rightly named over their size: all together, and by name.

    The area of a disc is the share of the cases that are rightly named, that of its ring the share that is found.

    Parameters
    ----------
    rates
        Columns ``name`` (one of them all effects together), ``size`` [detection limits], ``score``, ``rate``, ``low``,
        ``high``.
    clear
        Size from which an effect counts as clear.
    """
    if rates.empty:
        return text_figure("No case hides one effect alone.")
    names = sorted(set(rates["name"]) - {ALL})
    figure, grid = panels_of(1, 2, max(0.155 * len(names) + 1.0, 2.8), width_ratios=[1, 1.1])
    left, right = grid[0]
    for panel in (left, right):
        panel.axvspan(clear / 1.5, 10 * rates["size"].max(), color="#f2f2f2", lw=0)
        panel.set(xscale="log", xlim=(rates["size"].min() / 2, rates["size"].max() * 2), xlabel="size [limits]")
        panel.set_xticks(sorted(set(rates["size"])))
        panel.xaxis.set_major_formatter(PLAIN)
        panel.xaxis.set_minor_locator(NullLocator())
    for score, (title, colour, aside) in SCORES.items():
        one = rates[(rates["name"] == ALL) & (rates["score"] == score)].sort_values("size")
        ends = one["rate"] - one["low"], one["high"] - one["rate"]
        left.errorbar(aside * one["size"], one["rate"], ends, fmt="o-", ms=4, color=colour, label=title)
        by_name = rates[(rates["name"] != ALL) & (rates["score"] == score)]
        rows = [names.index(name) for name in by_name["name"]]
        look = {"facecolors": "none", "edgecolors": colour} if score == "detected" else {"color": colour, "lw": 0}
        right.scatter(by_name["size"], rows, 55 * by_name["rate"], zorder=3, **look)
    left.set(title="all effects", ylim=(-0.05, 1.05))
    left.yaxis.set_major_formatter(PercentFormatter(1.0, 0))
    right.set_yticks(range(len(names)), map(title_of, names))
    right.set(title="each effect", ylim=(len(names) - 0.3, -0.7))
    legend_below(figure, 2)
    return figure


def confusion(counts: pd.DataFrame) -> Figure:
    """Draw how often each hidden name (index) gets each answer (columns); the shade is the share of its row."""
    rows = [name for name in counts.index if counts.loc[name].any()]
    columns = [name for name in counts.columns if counts[name].any() or name in (NONE, UNKNOWN)]
    shown = counts.loc[rows, columns].to_numpy()
    figure, grid = panels_of(1, 1, 0.19 * len(rows) + 1.4)
    panel = grid[0, 0]
    panel.imshow(shown / shown.sum(axis=1, keepdims=True), cmap="Blues", vmin=0, vmax=1.6, aspect="auto")
    for (row, column), count in np.ndenumerate(shown):
        if count:
            panel.text(column, row, str(count), ha="center", va="center", fontsize=7)
    for row, name in enumerate(rows):
        if name in columns:
            at = columns.index(name)
            panel.plot(at + 0.5 * np.array([-1, 1, 1, -1, -1]), row + 0.5 * np.array([-1, -1, 1, 1, -1]), color=NAMED,
                       lw=0.8)  # fmt: skip
    panel.set_xticks(range(len(columns)), [title_of(name) for name in columns], rotation=60, ha="right")
    panel.set_yticks(range(len(rows)), [title_of(name) for name in rows])
    panel.set(xlabel="answer", ylabel="hidden")
    panel.grid(False)
    return figure


def rates(table: pd.DataFrame) -> Figure:
    """Draw rates with their intervals: columns ``title``, ``count``, ``rate``, ``low``, ``high``."""
    figure, grid = panels_of(1, 1, 0.165 * len(table) + 0.6)
    panel = grid[0, 0]
    places = np.arange(len(table))
    _intervals(panel, table, places)
    panel.set_yticks(places, [f"{one.title} ({one.count})" for one in table.itertuples(index=False)])
    panel.invert_yaxis()
    panel.set(xlim=(-0.02, 1.02), xlabel=f"share of the cases, with {LEVEL:.0%} interval")
    panel.xaxis.set_major_formatter(PercentFormatter(1.0, 0))
    return figure


def coverage(parameters: pd.DataFrame, covered: pd.DataFrame) -> Figure:
    """Draw the errors of the parameters of rightly named effects, and how often the interval holds the truth.

    Parameters
    ----------
    parameters
        Columns ``name``, ``parameter``, ``error`` [half widths of the interval].
    covered
        Columns ``name``, ``parameter``, ``count``, ``rate``, ``low``, ``high``.
    """
    figure, grid = panels_of(1, 2, 0.145 * len(covered) + 0.9, sharey=True)
    errors, shares = grid[0]
    places = np.arange(len(covered))
    every = covered["name"] == ALL
    for place, one in zip(places, covered.itertuples(index=False), strict=True):
        same = (parameters["name"] == one.name) & (parameters["parameter"] == one.parameter)
        error = parameters["error"][same | (one.name == ALL)].dropna().clip(-FARTHEST, FARTHEST)
        errors.plot(error, np.full(len(error), place), "|", ms=4, mew=0.7, color=FOUND)
    errors.axvspan(-1, 1, color=BAND, alpha=0.5, lw=0)
    errors.set(xlim=(-1.05 * FARTHEST, 1.05 * FARTHEST), xlabel="error [half widths of the interval]")
    titles = covered["name"].map(title_of) + ", " + covered["parameter"].map(title_of)
    errors.set_yticks(places, titles.mask(every, "all"))
    errors.set_ylim(len(covered) - 0.4, -0.6)
    _intervals(shares, covered, places)
    shares.axvline(LEVEL, color="black", lw=0.6)
    shares.set(xlim=(-0.02, 1.02), xlabel="intervals that hold the truth")
    shares.xaxis.set_major_formatter(PercentFormatter(1.0, 0))
    return figure


def distances(cases: pd.DataFrame) -> Figure:
    """Draw the held-out distances of each case before and after over the floor, the largest first.

    What is beyond :data:`HIGHEST` is at the edge.

    ``cases`` has the columns of :attr:`imu_benchmark.scores.Scores.cases`.
    """
    figure, grid = panels_of(1, len(DISTANCES), 2.6)
    for name, title, panel in zip(DISTANCES, NAMES.values(), grid[0], strict=True):
        known = cases.dropna(subset=[f"{name}_after", f"{name}_floor"])
        over = pd.DataFrame({state: known[f"{name}_{state}"] / known[f"{name}_floor"] for state in DRAWN})
        over = over.sort_values("before", ascending=False).clip(upper=HIGHEST)
        at = np.arange(1, len(over) + 1)
        panel.vlines(at, over["floor_low"], over["floor_high"], color=BAND, lw=4, label=f"floor ({LEVEL:.0%})")
        panel.vlines(at, over["after"], over["before"], color="#888888", lw=0.5)
        panel.plot(at, over["before"], "o", ms=3, color=BEFORE, label="start model")
        panel.plot(at, over["after"], "o", ms=3, color=AFTER, label="final model")
        panel.set(title=title, xlabel="case", yscale="log")
        panel.xaxis.get_major_locator().set_params(integer=True)
        panel.yaxis.set_major_formatter(PLAIN)
        panel.yaxis.set_minor_formatter(NullFormatter())
    grid[0, 0].set_ylabel("distance over floor")
    legend_below(figure, 3)
    return figure


def calibration(p_values: pd.DataFrame) -> Figure:
    """Draw how many views of logs that hide nothing have a p-value up to a level, against the level.

    ``p_values`` has the columns ``view``, ``p_value``. The band holds 95 % of such shares of independent, uniform ones.
    """
    if p_values.empty:
        return text_figure("No case hides nothing.")
    groups = dict(tuple(p_values.groupby("view", sort=False)["p_value"]))
    columns = 4
    rows = ceil(len(groups) / columns)
    figure, grid = panels_of(rows, columns, 1.5 * rows + 0.6, sharex=True, sharey=True)
    level = np.geomspace(LOWEST, 1, 200)
    for (view, found), panel in zip(groups.items(), grid.flat, strict=False):
        count = len(found)
        low, high = (binom.ppf(edge, count, level) / count for edge in ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
        panel.fill_between(level, np.maximum(low, LOWEST / 10), high, color=BAND, lw=0, label=f"{LEVEL:.0%} if uniform")
        panel.plot(level, level, color="black", lw=0.5)
        ordered = np.sort(found.to_numpy())
        panel.step(np.concatenate([[LOWEST], ordered, [1.0]]), np.append(np.arange(count + 1), count) / count,
                   where="post", color=FOUND, label="p-values of logs that hide nothing")  # fmt: skip
        panel.text(0.95, 0.05, f"{count} p-values", ha="right", transform=panel.transAxes, fontsize=7)
        title = fill(VIEWS[view].title, TITLE_WIDTH)
        panel.set(title=title, xscale="log", yscale="log", xlim=(LOWEST, 1), ylim=(LOWEST, 1.2))
    for panel in grid.flat[len(groups) :]:
        panel.remove()
    for panel in grid.flat[max(len(groups) - columns, 0) : len(groups)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("p-value")
    for panel in grid[:, 0]:
        panel.set_ylabel("share up to it")
    legend_below(figure, 2)
    return figure


def _intervals(panel: Axes, table: pd.DataFrame, places: np.ndarray) -> None:
    """Draw rates with their intervals, one below the other; those of no case at all are not drawn."""
    known = (table["count"] > 0).to_numpy()
    some = table[known]
    ends = some["rate"] - some["low"], some["high"] - some["rate"]
    panel.errorbar(some["rate"], places[known], xerr=ends, fmt="o", ms=3, elinewidth=0.8, color=FOUND)
