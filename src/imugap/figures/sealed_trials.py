"""Figures of sealed cases of few axes: how often a probable name is right, and what a search loses."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator, PercentFormatter

from imugap.figures.discovery import PLAIN
from imugap.figures.style import legend_below, panels_of
from imugap.study.detection_loss import bonferroni_half_size, oracle_power

FOUND, ORACLE, EDGE = "#0072B2", "#555555", 0.03


def reliability(bins: pd.DataFrame) -> Figure:
    """Draw how often the likeliest explanation is right over its probability.

    Parameters
    ----------
    bins
        Columns ``confidence`` (mean probability of a bin), ``count``, ``rate`` with ``low`` and ``high``.
    """
    figure, grid = panels_of(1, 2, 2.6, width_ratios=[1.2, 1])
    panel, counts = grid[0]
    ends = bins["rate"] - bins["low"], bins["high"] - bins["rate"]
    panel.plot([0, 1], [0, 1], color=ORACLE, ls="--", label="probability = share")
    panel.errorbar(bins["confidence"], bins["rate"], ends, fmt="o", ms=4, color=FOUND, label="answers, 95 % interval")
    panel.set(xlabel="probability of the likeliest explanation", ylabel="share that is right")
    panel.set(xlim=(-EDGE, 1 + EDGE), ylim=(-EDGE, 1 + EDGE))
    counts.bar(bins["confidence"], bins["count"], width=0.06, color=FOUND)
    counts.set(
        xlabel="probability of the likeliest explanation", ylabel="answers", yscale="log", xlim=(-EDGE, 1 + EDGE)
    )
    for axis in (panel.xaxis, panel.yaxis, counts.xaxis):
        axis.set_major_formatter(PercentFormatter(1.0, 0))
    legend_below(figure, 2)
    return figure


def losses(curve: pd.DataFrame, table: pd.DataFrame, choices: int) -> Figure:
    """Draw the share that is found over the size, beside the test that knows the effect, and the half size of each.

    Parameters
    ----------
    curve
        All names together: ``size`` [detection limits], ``rate``, ``low``, ``high``.
    table
        Of each name: ``name``, ``half``, ``low``, ``high`` [detection limits].
    choices
        Number of names times axes among which the search chooses.
    """
    figure, grid = panels_of(1, 2, max(0.155 * len(table) + 1.0, 2.8), width_ratios=[1, 1.1])
    left, right = grid[0]
    size = np.geomspace(0.5, 8, 200)
    shift = bonferroni_half_size(choices) - 1
    left.plot(size, oracle_power(size), color=ORACLE, label="test that knows the effect")
    left.plot(size, oracle_power(size - shift), color=ORACLE, ls=":", label=f"the same among {choices} names and axes")
    ends = curve["rate"] - curve["low"], curve["high"] - curve["rate"]
    left.errorbar(curve["size"], curve["rate"], ends, fmt="o-", ms=4, color=FOUND, label="search, 95 % interval")
    left.set(title="all effects", xscale="log", xlabel="size [detection limits]", ylim=(-EDGE, 1 + EDGE))
    left.set_xticks(curve["size"])
    left.yaxis.set_major_formatter(PercentFormatter(1.0, 0))
    rows, farthest = np.arange(len(table)), 2 * curve["size"].max()
    half, low, high = (table[end].clip(size[0], farthest) for end in ("half", "low", "high"))
    right.hlines(rows, low, high, color=FOUND, lw=1.2)
    below, beyond = (table["half"] < size[0]).to_numpy(), (table["half"] > farthest).to_numpy()
    for shown, marker in ((~below & ~beyond, "o"), (below, "<"), (beyond, ">")):
        right.plot(half[shown], rows[shown], marker, ms=3.5, color=FOUND, clip_on=False)
    right.axvline(1.0, color=ORACLE)
    right.axvline(1 + shift, color=ORACLE, ls=":")
    right.set(
        title="size at which one half is found",
        xscale="log",
        xlabel="size [detection limits]",
        ylim=(len(rows) - 0.3, -0.7),
    )
    right.set_yticks(rows, table["name"].str.replace("_", " "))
    right.set_xticks([0.5, 1, 2, 4, 8])
    for panel in (left, right):
        panel.xaxis.set_major_formatter(PLAIN)
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.xaxis.set_minor_locator(NullLocator())
    legend_below(figure, 3)
    return figure
