"""Figures of sealed cases of few axes: how often a probable name is right, and what a search loses."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, NullLocator, PercentFormatter

from imugap.effects import title_of
from imugap.figures.discovery import PLAIN
from imugap.figures.style import legend_below, panels_of
from imugap.study.discovery.detection_loss import bonferroni_half_size, oracle_power

FOUND, ORACLE, EDGE = "#0072B2", "#555555", 0.03


def reliability(bins: pd.DataFrame) -> Figure:
    """Draw how often the likeliest explanation is right, beside the probability that was stated, in bins of it.

    Parameters
    ----------
    bins
        Columns ``bin`` (number of the tenth), ``confidence`` (mean probability of a bin), ``count``, ``rate`` with
        ``low`` and ``high``.
    """
    figure, grid = panels_of(1, 1, 2.3)
    panel, places = grid[0, 0], np.arange(len(bins))
    ends = bins["rate"] - bins["low"], bins["high"] - bins["rate"]
    panel.hlines(bins["confidence"], places - 0.3, places + 0.3, color=ORACLE, ls="--", label="stated probability")
    panel.errorbar(places, bins["rate"], ends, fmt="o", ms=4, color=FOUND, label="share that is right, 95 % interval")
    ticks = [f"{10 * one.bin} to {10 * one.bin + 10} %\n({one.count})" for one in bins.itertuples()]
    panel.set_xticks(places, ticks)
    panel.set(xlabel="probability of the likeliest explanation (number of answers)", ylim=(-EDGE, 1 + EDGE))
    panel.set_ylabel("share of answers")
    panel.yaxis.set_major_formatter(PercentFormatter(1.0, 0))
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
    figure, grid = panels_of(1, 2, max(0.13 * len(table) + 1.0, 2.8), width_ratios=[1, 1.1])
    left, right = grid[0]
    size = np.geomspace(0.5, 8, 200)
    shift = bonferroni_half_size(choices) - 1
    left.plot(size, oracle_power(size), color=ORACLE, label="test that knows the effect")
    left.plot(size, oracle_power(size - shift), color=ORACLE, ls=":", label=f"the same among {choices} names and axes")
    ends = curve["rate"] - curve["low"], curve["high"] - curve["rate"]
    left.errorbar(curve["size"], curve["rate"], ends, fmt="o-", ms=4, color=FOUND, label="search, 95 % interval")
    left.set(
        title="all effects",
        xscale="log",
        xlabel="size [detection limits]",
        ylabel="share found",
        ylim=(-EDGE, 1 + EDGE),
    )
    left.set_xticks(curve["size"])
    left.yaxis.set_major_formatter(PercentFormatter(1.0, 0))
    rows, farthest = np.arange(len(table)), 2 * curve["size"].max()
    half, low, high = (table[end].clip(size[0], farthest) for end in ("half", "low", "high"))
    right.hlines(rows, low, high, color=FOUND, lw=1.2)
    below, beyond = (table["half"] < size[0]).to_numpy(), (table["half"] > farthest).to_numpy()
    kinds = ((~below & ~beyond, "o"), (below, "<"), (beyond, ">"))
    for shown, marker in (one for one in kinds if one[0].any()):  # one without points would stretch the layout
        right.plot(half[shown], rows[shown], marker, ms=3.5, color=FOUND, clip_on=False)
    right.axvline(1.0, color=ORACLE)
    right.axvline(1 + shift, color=ORACLE, ls=":")
    right.set(
        title="size at which one half is found",
        xscale="log",
        xlabel="size [detection limits]",
        ylim=(len(rows) - 0.3, -0.7),
    )
    right.set_yticks(rows, table["name"].map(title_of), fontsize=7)
    right.set_xticks([0.5, 1, 2, 4, 8])
    for panel in (left, right):
        panel.xaxis.set_major_formatter(PLAIN)
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.xaxis.set_minor_locator(NullLocator())
    legend_below(figure, 3)
    return figure
