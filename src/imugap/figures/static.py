"""Figures of the static chapter: each function draws one figure from tables and returns it."""

from collections.abc import Container, Mapping

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from imugap.estimation.indices import INDICES
from imugap.estimation.variances.allan import LAWS
from imugap.figures.style import AXIS_TITLES, allan_panels, allan_unit, decades, label_lowest, legend_below, panels_of
from imugap.units import from_si

TITLES = {
    "bias_only": "Bias only",
    "white": "White noise",
    "white_turn_on": "White + turn-on",
    "rate_random_walk": "RRW + white",
    "method_a": "Method A",
    "method_b": "Method B",
    "restoration": "Restoration",
    "nbk": "N + B + K",
}
"""One name per contender in every table and figure."""

COLOURS = {
    "bias_only": "#999999",
    "white": "#56B4E9",
    "white_turn_on": "#999933",
    "rate_random_walk": "#E69F00",
    "method_a": "#D55E00",
    "method_b": "#CC79A7",
    "restoration": "#0072B2",
    "nbk": "#009E73",
}
"""One colour per contender in every figure (Okabe and Ito's palette); the device is black."""
LAW_COLOURS = {"N": "#D55E00", "B": "#0072B2", "K": "#009E73"}


def titled(bounds: Container[str]) -> dict[str, str]:
    """Return the titles of the contenders; those built with an upper bound in place of a value are marked (≤)."""
    return {name: f"{title} (≤)" if name in bounds else title for name, title in TITLES.items()}


def allan(curves: pd.DataFrame, tangents: pd.DataFrame) -> Figure:
    """Draw the Allan deviations of all runs with the tangents that were read.

    Parameters
    ----------
    curves
        Columns ``run``, ``axis``, ``tau``, ``deviation``, ``low``, ``high``; SI.
    tangents
        Rows of :func:`imugap.estimation.indices.of_run` with a column ``run``; readings of the first run are drawn.
    """
    figure, panels = allan_panels()
    runs = sorted(curves["run"].unique())
    for axis, panel in panels.items():
        unit = allan_unit(axis)
        for run in runs:
            one = curves[(curves["axis"] == axis) & (curves["run"] == run)]
            tau, deviation, low, high = (one[c].to_numpy() for c in ("tau", "deviation", "low", "high"))
            first = run == runs[0]
            style = {"color": "black"} if first else {"color": "#888888", "lw": 0.6}
            panel.plot(tau, from_si(deviation, unit), **style, zorder=3 if first else 2)
            if first:
                panel.fill_between(tau, from_si(low, unit), from_si(high, unit), color="#bbbbbb", lw=0, zorder=1)
        read = tangents[(tangents["axis"] == axis) & (tangents["run"] == runs[0])]
        for row in read[read["symbol"].isin(LAW_COLOURS)].itertuples():
            _draw_tangent(panel, row, LAW_COLOURS[row.symbol], unit)
    legend_below(figure, 5)
    return figure


def _draw_tangent(panel: mpl.axes.Axes, row, colour: str, unit: str) -> None:
    """Draw a reading thick over its range, prolonged thin by half a decade; a bound as a dotted line with its point."""
    law = LAWS[row.symbol]
    reach = np.array([row.tau_low / 10**0.5, row.tau_high * 10**0.5])
    label = f"{law.symbol}, slope {law.slope:+.1f}".replace("+0.0", "0")
    if row.holds:
        panel.plot(reach, from_si(law.deviation(row.value, reach), unit), color=colour, lw=0.8, ls="--", zorder=4)
        span = np.array([row.tau_low, row.tau_high])
        panel.plot(span, from_si(law.deviation(row.value, span), unit), color=colour, lw=2.5, alpha=0.6, label=label)
    else:
        panel.plot(reach, from_si(law.deviation(row.value, reach), unit), color=colour, lw=0.9, ls=":", zorder=4)
        touch = law.deviation(row.value, row.tau_low)
        panel.plot(row.tau_low, from_si(touch, unit), ".", color=colour, ms=5, zorder=5, label=f"{label} (bound)")


def models(device: pd.DataFrame, simulated: pd.DataFrame) -> Figure:
    """Draw the Allan deviation of every contender against the device.

    Parameters
    ----------
    device
        Curves of the runs: columns ``run``, ``axis``, ``tau``, ``deviation``; SI.
    simulated
        Curves of simulated runs: columns ``contender``, ``axis``, ``tau``, ``low``, ``median``, ``high``; SI.
    """
    figure, panels = allan_panels()
    for axis, panel in panels.items():
        unit = allan_unit(axis)
        for name, one in simulated[simulated["axis"] == axis].groupby("contender", sort=False):
            tau, low, median, high = (one[c].to_numpy() for c in ("tau", "low", "median", "high"))
            panel.plot(tau, from_si(median, unit), color=COLOURS[name], label=TITLES[name])
            panel.fill_between(tau, from_si(low, unit), from_si(high, unit), color=COLOURS[name], alpha=0.15, lw=0)
        for run, one in device[device["axis"] == axis].groupby("run"):
            label = "device (each run)" if run == device["run"].min() else None
            panel.plot(one["tau"], from_si(one["deviation"], unit), color="black", lw=0.6, label=label, zorder=5)
    legend_below(figure, 4)
    return figure


def drift(time: np.ndarray, paths: Mapping[str, np.ndarray]) -> Figure:
    """Draw attitude, velocity and position drift of measured runs (He et al. 2023, figure 2).

    Parameters
    ----------
    time
        Epochs [s], shape (epochs,).
    paths
        Start to drifts, shape (runs, epochs, 9), columns of :data:`imugap.kinematics.strapdown.COLUMNS`.
    """
    groups = {
        "attitude [°]": (6, np.rad2deg),
        "velocity [m/s]": (3, np.asarray),
        "position [m]": (0, np.asarray),
    }
    colours = {"roll; north": "#D55E00", "pitch; east": "#0072B2", "heading; down": "#009E73"}
    figure, grid = panels_of(len(paths), 3, 2.1 * len(paths), sharex=True)
    for row, (start, path) in zip(grid, paths.items(), strict=True):
        for panel, (title, (first, convert)) in zip(row, groups.items(), strict=True):
            for k, (name, colour) in enumerate(colours.items()):
                shown = convert(path[:, :, first + k])
                panel.plot(time, shown[0], color=colour, label=name)
                panel.plot(time, shown[1:].T, color=colour, lw=0.4, alpha=0.6)
            panel.set(title=f"{start}: {title}", xlim=(0, time[-1]))
    label_lowest(grid, "time [s]")
    legend_below(figure, 3)
    return figure


def differences(time: np.ndarray, differences: Mapping[str, np.ndarray], drawn: int) -> Figure:
    """Draw measured minus simulated drift of each contender (He et al. 2023, figure 3).

    Parameters
    ----------
    time
        Epochs [s], shape (epochs,).
    differences
        Contender to d of one run, shape (trials, epochs, 3): east [m], north [m], heading [rad].
    drawn
        Number of trials drawn as lines; the band holds 90 % of all.
    """
    rows = {"east [m]": np.asarray, "north [m]": np.asarray, "heading [°]": np.rad2deg}
    figure, grid = panels_of(3, len(differences), 4.6, sharex=True, sharey="row")
    for k, (row, (label, convert)) in enumerate(zip(grid, rows.items(), strict=True)):
        row[0].set_ylabel(f"measured − simulated,\n{label}")
        usual = convert(np.median([np.abs(difference[:, -1, k]).max() for difference in differences.values()]))
        for panel in row:
            panel.set_yscale("symlog", linthresh=10.0 ** np.floor(np.log10(usual)), linscale=0.7)
    for column, (name, difference) in zip(grid.T, differences.items(), strict=True):
        for k, (panel, convert) in enumerate(zip(column, rows.values(), strict=True)):
            shown = convert(difference[:, :, k])
            low, high = np.quantile(shown, [0.05, 0.95], axis=0)
            panel.fill_between(time, low, high, color=COLOURS[name], alpha=0.3, lw=0)
            panel.plot(time, shown[:drawn].T, color=COLOURS[name], lw=0.6)
            panel.axhline(0, color="black", lw=0.5)
        column[0].set_title(TITLES[name])
        column[-1].set(xlabel="time [s]", xlim=(0, time[-1]), xticks=[0, time[-1] / 2])
    return figure


def ranking(scores: pd.DataFrame, column: str, label: str) -> Figure:
    """Draw a score of every contender over that of the bare bias, against the navigation length.

    Rows are starts, columns quantities; below 1 the model is better than no noise model at all.

    Parameters
    ----------
    scores
        Columns ``start``, ``contender``, ``quantity``, ``horizon`` [s] and ``column``.
    column, label
        The score and its name.
    """
    starts, quantities = scores["start"].unique(), scores["quantity"].unique()
    figure, grid = panels_of(len(starts), len(quantities), 2.1 * len(starts), sharex=True)
    for row, start in zip(grid, starts, strict=True):
        for panel, quantity in zip(row, quantities, strict=True):
            one = scores[(scores["start"] == start) & (scores["quantity"] == quantity)]
            lines = one.pivot(index="horizon", columns="contender", values=column)
            for name in one["contender"].unique():
                ratio = lines[name] / lines["bias_only"]
                panel.plot(lines.index, ratio, color=COLOURS[name], marker=".", ms=3, label=TITLES[name])
            panel.set(title=f"{start}: {quantity}", xscale="log")
            decades(panel)
    for panel in grid[:, 0]:
        panel.set_ylabel(f"{label} / that of bias only")
    label_lowest(grid, "navigation length [s]")
    legend_below(figure, 4)
    return figure


def repeatability(means: pd.DataFrame) -> Figure:
    """Draw the mean of every power cycle with its interval.

    Parameters
    ----------
    means
        Columns ``axis``, ``run``, ``value``, ``low``, ``high``; SI.
    """
    axes = means["axis"].unique()
    figure, grid = panels_of(1, len(axes), 2.2, sharex=True)
    for panel, axis in zip(grid[0], axes, strict=True):
        one = means[means["axis"] == axis]
        unit = INDICES["bias"].unit(axis)
        value, low, high = (from_si(one[c].to_numpy(), unit) for c in ("value", "low", "high"))
        panel.errorbar(one["run"], value, [value - low, high - value], fmt="o", ms=3, lw=0.8, color="#0072B2")
        panel.axhline(value.mean(), color="black", lw=0.6)
        panel.set(title=AXIS_TITLES[axis], xlabel="power cycle", ylabel=f"mean [{unit}]", xticks=one["run"].iloc[::2])
    return figure


def clock(clocks: pd.DataFrame, spread: pd.DataFrame) -> Figure:
    """Draw the relative sampling interval of each run by each kind of evidence, and the scatter of N it explains.

    Parameters
    ----------
    clocks
        One row of :meth:`imugap.integrity.sampling_clock.Clock.row` per run, with a column ``run``.
    spread
        Index axis; columns ``nominal``, ``corrected``: relative scatter of N over the runs.
    """
    figure, grid = panels_of(1, 2, 2.4, width_ratios=[2, 1])
    left, right = grid[0]
    kinds = {"lines": "spectral lines", "rolloff": "roll-off of the gyroscope noise", "combined": "combined"}
    for shift, (kind, label), colour in zip(
        (-0.15, 0, 0.15), kinds.items(), ("#D55E00", "#0072B2", "black"), strict=True
    ):
        value, low, high = (clocks[c].to_numpy(float) for c in (kind, f"{kind}_low", f"{kind}_high"))
        place = clocks["run"].to_numpy(float) + shift
        left.errorbar(place, value, [value - low, high - value], fmt="o", ms=3, lw=1, color=colour, label=label)
    left.axhline(1, color="black", lw=0.6)
    left.set(xlabel="run", ylabel="sampling interval / run 1", xticks=clocks["run"].to_list())
    place = np.arange(len(spread))
    right.bar(place - 0.2, 100 * spread["nominal"], 0.4, color="#999999", label="nominal interval")
    right.bar(place + 0.2, 100 * spread["corrected"], 0.4, color="#0072B2", label="measured interval")
    right.set(xticks=place, xticklabels=[axis[-1] for axis in spread.index], ylabel="scatter of N over runs [%]")
    right.set_xlabel("gyroscope")
    legend_below(figure, 5)
    return figure
