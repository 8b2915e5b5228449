"""Figures of the chapter from Allan deviation to state space: each function draws one figure from tables."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from imugap.figures.style import allan_panels, allan_unit, legend_below, panels_of
from imugap.study.static.farrell2022 import COMPOSED, TITLES
from imugap.units import from_si

COLOURS = {
    "n": "#999999",
    "k": "#999999",
    "gm": "#999999",
    "nk": "#E69F00",
    "nbk": "#D55E00",
    "nbk_freed": "#0072B2",
    "nbk_bank": "#009E73",
}
DASHES = {"n": (0, (1, 1)), "k": (0, (4, 1)), "gm": (0, (4, 1, 1, 1))}


def models(device: pd.DataFrame, models: pd.DataFrame) -> Figure:
    """Draw the Allan deviations of continuous models and of their samples over that of the device.

    Parameters
    ----------
    device
        Columns ``axis``, ``tau``, ``deviation``, ``low``, ``high``; SI.
    models
        Columns ``model``, ``axis``, ``tau``, ``deviation`` (of the spectrum), ``low``, ``high`` (of samples); SI.
    """
    figure, panels = allan_panels()
    for axis, panel in panels.items():
        unit = allan_unit(axis)
        one = device[device["axis"] == axis]
        tau, deviation, low, high = (one[c].to_numpy() for c in ("tau", "deviation", "low", "high"))
        panel.fill_between(
            tau, from_si(low, unit), from_si(high, unit), color="#cccccc", lw=0, label="device, 95 % band"
        )
        panel.plot(tau, from_si(deviation, unit), color="black", lw=1.4, label="device")
        for name, title in TITLES.items():
            curve = models[(models["axis"] == axis) & (models["model"] == name)]
            tau, deviation, low, high = (curve[c].to_numpy() for c in ("tau", "deviation", "low", "high"))
            if not deviation.any():
                continue
            composed = name in COMPOSED
            style = {"lw": 1.0} if composed else {"lw": 0.7, "ls": DASHES[name]}
            panel.plot(tau, from_si(deviation, unit), color=COLOURS[name], label=title, **style)
            if composed:
                panel.fill_between(tau, from_si(low, unit), from_si(high, unit), color=COLOURS[name], alpha=0.25, lw=0)
        top, bottom = from_si(one["high"].max(), unit), from_si(one["low"].min(), unit)
        panel.set_ylim(bottom / 3, top * 3)
    legend_below(figure, 5)
    return figure


def worked_example(lines: Mapping[str, pd.Series], floor: tuple[float, float, float], digits: pd.DataFrame) -> Figure:
    """Draw the Allan deviations of the printed values of the worked example.

    Parameters
    ----------
    lines
        Title to Allan deviation [m/s^2], index ``tau`` [s].
    floor
        Printed averaging time, Allan deviation and half of its last digit.
    digits
        Lowest and highest Allan deviation of N and K within their digits: columns ``low``, ``high``, index ``tau``.
    """
    figure, grid = panels_of(1, 2, 2.9)
    colours = ("#D55E00", "#E69F00", "#0072B2", "#999999", "#999999", "#999999")
    dashes = ("-", "-", "--", *DASHES.values())
    place, height, half = floor
    for panel, span in zip(grid[0], ((0.1, 1000), (15, 150)), strict=True):
        shade = 1e3 * digits.loc[span[0] : span[1]]
        panel.fill_between(shade.index, shade["low"], shade["high"], color="#E69F00", alpha=0.25, lw=0)
        for (title, line), colour, dash in zip(lines.items(), colours, dashes, strict=True):
            part = line.loc[span[0] : span[1]]
            panel.plot(
                part.index, 1e3 * part, color=colour, ls=dash, lw=0.8 if colour == "#999999" else 1.2, label=title
            )
        panel.errorbar(
            [place], [1e3 * height], [1e3 * half], fmt="o", color="black", ms=4, label="printed floor", zorder=5
        )
        panel.set(xscale="log", xlabel="averaging time τ [s]", xlim=span)
    left, right = grid[0]
    left.set(yscale="log", ylabel="Allan deviation [mm/s²]", ylim=(0.1, 20))
    right.set(ylim=(0.55, 1.3), xticks=[20, 40, 60, 100], xticklabels=["20", "40", "60", "100"])
    right.minorticks_off()
    legend_below(figure, 4)
    return figure


def bank(ratios: Mapping[int, pd.Series], errors: pd.DataFrame) -> Figure:
    """Draw how flat banks of Gauss-Markov states are, and their largest error against their number.

    Parameters
    ----------
    ratios
        Number of states to Allan deviation over 0.664 B, index tau over the shortest.
    errors
        Columns ``decades``, ``states``, ``error``.
    """
    figure, grid = panels_of(1, 2, 2.6)
    left, right = grid[0]
    palette = ("#D55E00", "#E69F00", "#009E73", "#0072B2", "#CC79A7")
    for (count, ratio), colour in zip(ratios.items(), palette, strict=False):
        left.plot(ratio.index, ratio, color=colour, label=f"{count} state" + "s" * (count > 1))
    left.axhline(1, color="black", lw=0.6)
    left.set(xscale="log", xlabel="τ over the shortest of the range", ylabel="Allan deviation / 0.664 B")
    left.legend()
    for (decades, one), colour in zip(errors.groupby("decades"), palette, strict=True):
        right.plot(
            one["states"] / decades,
            100 * one["error"],
            color=colour,
            marker=".",
            label=f"{decades} decade" + "s" * (decades > 1),
        )
    right.set(yscale="log", xlabel="states per decade", ylabel="largest error [%]", xlim=(0, 2.1), ylim=(0.1, 100))
    right.legend()
    return figure
