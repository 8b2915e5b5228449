"""Figures of the chapter on walks: each function draws one figure from tables and returns it."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from imugap.figures import static
from imugap.figures.style import label_lowest, legend_below, panels_of

TITLES = {"none": "None", "stand": "Mean at the stand"} | static.TITLES
TITLES |= {"fitted": "Fitted composite", "truth": "True model"}
"""One name per compensation in every table and figure."""
SETS = {"openshoe_kth": "OpenShoe", "xio_gait_tracking": "xio", "gaitmap_2x20m": "gaitmap", "pyshoe_vicon": "PyShoe"}
"""Data set of real walks to its name."""
COLOURS = {"none": "black", "stand": "#7F3C8D"} | static.COLOURS | {"fitted": "#8B4513", "truth": "black"}
PRINTED = "#D55E00"
"""Colour of the values printed in the source."""


def tracks(table: pd.DataFrame, truth: pd.DataFrame, shown: Mapping[str, str]) -> Figure:
    """Draw the navigated walk under several compensations (He et al. 2023, figures 4 and 6), across it enlarged.

    Parameters
    ----------
    table
        Columns ``contender``, ``trial``, ``north``, ``east`` [m]; the first trial is drawn as a line, of all the end.
    truth
        True Trajectory.
    shown
        Contender to title of its panel.
    """
    columns = 3
    figure, grid = panels_of(-(-len(shown) // columns), columns, 1.4 * (-(-len(shown) // columns)) + 0.4, sharex=True)
    for panel, (name, title) in zip(grid.flat, shown.items(), strict=False):
        one = table[table["contender"] == name]
        panel.plot(truth["north"], truth["east"], color="#bbbbbb", lw=2.5, label="true path")
        for trial, path in one.groupby("trial"):
            if trial == 0:
                panel.plot(path["north"], path["east"], color=COLOURS[name], lw=0.8, label="navigated, first trial")
            panel.plot(*path[["north", "east"]].iloc[-1], "x", color=PRINTED, ms=5, mew=1.2, label="navigated ends")
        panel.plot(0, 0, "o", color="black", ms=4, label="begin and true end", zorder=5)
        panel.set_title(title)
    _outer_labels(grid, len(shown), "north [m]", "east [m]")
    legend_below(figure, 4)
    return figure


def ends(
    table: pd.DataFrame, printed: Mapping[str, Mapping[str, float]], units: Mapping[str, tuple[str, str]]
) -> Figure:
    """Draw the errors of the ends over devices, a panel for each quantity and a row of points for each compensation.

    Parameters
    ----------
    table
        Columns ``use``, ``contender`` and the quantities, in the units shown.
    printed
        Quantity to contender to the value that the source prints.
    units
        Quantity to its title and unit.
    """
    uses = list(table["use"].unique())
    counts = [table[table["use"] == use]["contender"].nunique() for use in uses]
    figure, grid = panels_of(
        len(uses), len(units), 0.19 * sum(counts) + 1.3, sharex="col", gridspec_kw={"height_ratios": counts}
    )
    for row, use in zip(grid, uses, strict=True):
        one = table[table["use"] == use]
        names = list(one["contender"].unique())
        for panel, (quantity, (title, unit)) in zip(row, units.items(), strict=True):
            for place, name in enumerate(names):
                _strip(panel, one[one["contender"] == name][quantity].to_numpy(), place, COLOURS[name])
                if use == uses[0] and name in printed[quantity]:
                    panel.plot(printed[quantity][name], place, "D", color=PRINTED, ms=4.5, label="printed")
            panel.set(xscale="log", ylim=(len(names) - 0.4, -0.6), title=use)
            panel.set_xlabel(f"{title} [{unit}]" if use == uses[-1] else "")
            panel.set_yticks(range(len(names)), [TITLES[name] for name in names] if panel is row[0] else [])
            panel.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    legend_below(figure, 3)
    return figure


def _strip(panel, values: np.ndarray, place: float, colour: str) -> None:
    """Draw values as points around a row, and their mean as a bar."""
    spread = place + 0.3 * np.linspace(-1, 1, len(values))
    panel.plot(values, spread, ".", color=colour, ms=2.5, alpha=0.7, label="a device each")
    panel.plot([values.mean()] * 2, [place - 0.42, place + 0.42], color="black", lw=1.6, label="mean", zorder=4)


FOUND, SEEN = "#0072B2", "black"
"""Colours of a navigated walk and of its camera track."""


def walks(tracks: pd.DataFrame, titles: Mapping[tuple[str, int], str]) -> Figure:
    """Draw every real walk from above, each to the scale of its bar, with its camera track.

    Parameters
    ----------
    tracks
        Columns ``dataset``, ``run``, ``north``, ``east`` [m], and ``north_seen``, ``east_seen``, NaN where nothing was.
    titles
        Walk to its title.
    """
    columns = 7
    rows = -(-len(titles) // columns)
    figure, grid = panels_of(rows, columns, 1.25 * rows + 0.3)
    for panel, ((name, run), title) in zip(grid.flat, titles.items(), strict=False):
        one = tracks[(tracks["dataset"] == name) & (tracks["run"] == run)]
        panel.plot(one["east"], one["north"], color=FOUND, lw=0.9, label="navigated")
        panel.plot(one["east_seen"], one["north_seen"], color=SEEN, lw=0.5, label="seen by cameras")
        panel.plot(*one[["east", "north"]].iloc[0], "o", color="black", ms=3, label="begin")
        panel.plot(*one[["east", "north"]].iloc[-1], "x", color=PRINTED, ms=5, mew=1.2, label="end", zorder=5)
        panel.set_title(title)
        panel.set_aspect("equal", "datalim")
        panel.add_artist(_scale_bar(panel, np.ptp(one[["east", "north"]].to_numpy(), axis=0).max()))
    for panel in grid.flat:
        panel.set_axis_off()
    legend_below(figure, 4)
    return figure


def _scale_bar(panel, extent: float) -> AnchoredSizeBar:
    """Return a bar below a plan of an ``extent`` [m]: the longest of 1, 2, 5 times a power of ten up to half of it."""
    decade = 10 ** np.floor(np.log10(extent / 2))
    length = decade * max(step for step in (1, 2, 5) if step * decade <= extent / 2)
    return AnchoredSizeBar(
        panel.transData, length, f"{length:g} m", "upper center", pad=0, sep=2, frameon=False,
        bbox_to_anchor=(0.5, 0), bbox_transform=panel.transAxes,
    )  # fmt: skip


def against_cameras(tracks: pd.DataFrame, titles: Mapping[str, str]) -> Figure:
    """Draw the horizontal and vertical errors of the navigated walks over time, a column for each data set.

    Parameters
    ----------
    tracks
        Columns ``dataset``, ``run``, ``time`` and the positions, navigated and seen [m].
    titles
        Data set to its title.
    """
    figure, grid = panels_of(2, len(titles), 3.6, sharex="col", sharey="row")
    for (upper, lower), (name, title) in zip(grid.T, titles.items(), strict=True):
        for run, one in tracks[tracks["dataset"] == name].groupby("run"):
            off = {axis: one[axis] - one[f"{axis}_seen"] for axis in ("north", "east", "down")}
            upper.plot(one["time"], np.hypot(off["north"], off["east"]), lw=0.8, label=f"{run}")
            lower.plot(one["time"], -off["down"], lw=0.8)
        upper.set_title(title)
        upper.legend(title="walk", ncols=2, title_fontsize=7)
        lower.axhline(0, color="#888888", lw=0.5)
        lower.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("horizontal error [m]")
    grid[1, 0].set_ylabel("height too much [m]")
    return figure


SHARES = ("#D55E00", "#E69F00", "#F0E442", "#009E73", "#56B4E9", "#0072B2", "#CC79A7", "#999999", "#8B4513", "#7F3C8D")


def budget(shares: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw the error budget of the end: shares of the sum of the variances, a bar for each set of walks.

    Parameters
    ----------
    shares
        Title of the panel to shares, index effect, a column for each set; the effects in the order of the legend.
    """
    figure, grid = panels_of(1, len(shares), 2.6, sharey=True)
    for panel, (title, table) in zip(grid[0], shares.items(), strict=True):
        left = np.zeros(len(table.columns))
        for place, (effect, row) in enumerate(table.iterrows()):
            panel.barh(
                table.columns, 100 * row, left=left, color=SHARES[place % len(SHARES)], label=effect, height=0.7,
                hatch="////" if place >= len(SHARES) else None, edgecolor="white", lw=0.4,
            )  # fmt: skip
            left += 100 * row.to_numpy()
        panel.set(title=title, xlabel="share of the variance [%]", xlim=(0, 100))
        panel.set_axisbelow(True)
    grid[0, 0].invert_yaxis()
    legend_below(figure, 4)
    return figure


def sensitivity(table: pd.DataFrame, sets: Mapping[str, str], detectors: Sequence[str]) -> Figure:
    """Draw the end error over the threshold of the detector, for four detectors, and the height over a delay.

    Parameters
    ----------
    table
        Columns ``dataset``, ``run``, ``varied``, ``value``, ``share`` [%], ``height`` [m].
    sets
        Data set to its title.
    detectors
        Titles of the detectors in the order of their numbers.
    """
    figure, grid = panels_of(1, 3, 2.8)
    colours = dict(zip(sets, ("#0072B2", "#D55E00", "#009E73", "#CC79A7"), strict=False))
    quantities = {"threshold": "share", "detector": "share", "delay": "height"}
    for panel, (varied, quantity) in zip(grid[0], quantities.items(), strict=True):
        chosen = table[table["varied"] == varied]
        for (name, _), one in chosen.groupby(["dataset", "run"]):
            style = {"ls": "", "marker": ".", "ms": 4} if varied == "detector" else {"lw": 0.6, "alpha": 0.6}
            shift = 0.06 * (list(sets).index(name) - 1.5) if varied == "detector" else 0
            panel.plot(one["value"] + shift, one[quantity], color=colours[name], label=sets[name], **style)
        middle = chosen.groupby("value")[quantity].median()
        panel.plot(
            middle.index, middle, "k_" if varied == "detector" else "k-", ms=22, lw=2, zorder=3, label="median of all"
        )
    grid[0, 0].set(xscale="log", yscale="log", xlabel="threshold / usual one", ylabel="end error [% of distance]")
    grid[0, 1].set(yscale="log", ylabel="end error [% of distance]", xlabel="detector")
    grid[0, 1].set_xticks(range(len(detectors)), detectors)
    grid[0, 2].set(xlabel="accelerometers later by [ms]", ylabel="height too much [m]")
    for panel in grid[0, :2]:
        panel.axhline(1, color="#888888", lw=0.5)
        panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    grid[0, 0].xaxis.set_major_locator(LogLocator(base=2))
    grid[0, 0].xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    grid[0, 0].xaxis.set_minor_locator(NullLocator())
    legend_below(figure, 5)
    return figure


PREDICTED = {"at rest": "#999999", "data sheet": "#56B4E9", "named": "#D55E00", "other sets": "#009E73"}
"""Colours of the sources of a prediction."""


def predictions(ends: pd.DataFrame, titles: Mapping[tuple[str, int], str], scores: pd.DataFrame) -> Figure:
    """Draw the predicted and measured ends of walks, and the rank of the measured end in the prediction.

    Parameters
    ----------
    ends
        Columns ``dataset``, ``run``, ``by`` and the error of the end, ``north``, ``east``, ``down`` [m]; a row for each
        draw, and for what was measured.
    titles
        Walk to its title.
    scores
        Columns ``by``, ``place_horizontal`` and ``place_height``: 0 in the middle of a prediction, 1 beyond it.
    """
    figure, grid = panels_of(2, 2, 4.6, width_ratios=[3.4, 1])
    table = ends.assign(height=-ends["down"], horizontal=np.hypot(ends["north"], ends["east"]))
    names = [name for name in PREDICTED if name in set(table["by"])]
    for row, quantity in zip(grid, ("height", "horizontal"), strict=True):
        for number, (dataset, run) in enumerate(titles):
            one = table[(table["dataset"] == dataset) & (table["run"] == run)].set_index("by")[quantity]
            for name, shift in zip(names, np.linspace(-0.3, 0.3, len(names)), strict=True):
                low, middle, high = np.quantile(one.loc[name], [0.05, 0.5, 0.95])
                row[0].plot([number + shift] * 2, [low, high], color=PREDICTED[name], lw=2.4, alpha=0.8, label=name)
                row[0].plot(number + shift, middle, "_", color="black", ms=4, mew=0.8)
            row[0].plot(number, one.loc["measured"], "D", color="black", ms=3.5, label="measured", zorder=5)
        row[0].set_xticks(range(len(titles)), titles.values() if quantity == "horizontal" else [], rotation=90)
        row[0].tick_params(axis="x", labelsize=7)
        row[0].grid(axis="x", visible=False)
        bins = np.linspace(0, 1, 6)
        for name, shift in zip(names, np.linspace(-0.06, 0.06, len(names)), strict=True):
            counts, _ = np.histogram(scores.loc[scores["by"] == name, f"place_{quantity}"], bins)
            row[1].bar((bins[1:] + bins[:-1]) / 2 + shift, counts, width=0.04, color=PREDICTED[name])
        row[1].axhline(len(titles) / 5, color="black", lw=0.8, ls="--")
        row[1].set(xlabel="place (1: beyond)" if quantity == "horizontal" else "", ylabel="walks")
        row[1].yaxis.set_major_locator(MaxNLocator(integer=True))
    grid[0, 0].set_ylabel("height too much [m]")
    grid[1, 0].set_ylabel("horizontal end error [m]")
    legend_below(figure, 5)
    return figure


def _outer_labels(grid: np.ndarray, used: int, x: str, y: str) -> None:
    """Label the panels at the left and at the bottom, and blank those that are not used."""
    for panel in grid.flat[used:]:
        panel.set_axis_off()
    label_lowest(grid, x)
    for row in grid:
        row[0].set_ylabel(y)
