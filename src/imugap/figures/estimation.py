"""Figures of the chapter on estimation: each function draws one figure from tables and returns it."""

from collections.abc import Mapping, Sequence
from math import ceil
from types import MappingProxyType

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from imugap.figures.style import AXIS_TITLES, allan_label, allan_unit, card, label_lowest, legend_below, panels_of
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.units import from_si

TITLES = {
    "allan": "Allan, piecewise",
    "allan_separated": "Allan, white taken off",
    "indirect_interval": "indirect, interval weights",
    "indirect_diagonal": "indirect, diagonal weights",
    "indirect_full": "indirect, full weights",
    "indirect_simulated": "indirect, by simulation",
    "indirect_robust": "indirect, robust",
    "likelihood": "likelihood",
}
COLOURS = {
    "allan": "#D55E00",
    "allan_separated": "#999933",
    "indirect_interval": "#56B4E9",
    "indirect_diagonal": "#0072B2",
    "indirect_full": "#009E73",
    "indirect_simulated": "#CC79A7",
    "indirect_robust": "#E69F00",
    "likelihood": "#000000",
}
SYMBOLS = {
    ("white_noise", "density"): "N",
    ("gauss_markov", "std"): "σ",
    ("gauss_markov", "correlation_time"): "T",
    ("gauss_markov", "driving_psd"): "S_B",
    ("random_walk", "density_k"): "K",
    ("bias_instability", "density_b"): "B",
    ("quantization", "q"): "Q",
    ("rate_ramp", "slope"): "R",
}
"""Symbol of each parameter, by effect and name."""
MARKERS = {"indirect_interval": "o", "indirect_diagonal": "s", "indirect_full": "^", "indirect_simulated": "x"}
TIMES = {"ls": ("-", "--", ":"), "marker": ("o", "s", "^")}
"""Looks of the correlation times, from the shortest."""
LARGEST = 3.0
"""Ratio to the truth beyond which an estimate is drawn at the edge."""


MISFIT = "#E69F00"
HALF = np.sqrt(2)
"""Half an octave, by which the mark of a misfit is wider than its averaging times on either side."""
Misfits = Mapping[str, Sequence[tuple[float, float]]]


def distributions(estimates: pd.DataFrame, truth: dict[int, pd.Series], bounds: dict[int, pd.Series]) -> Figure:
    """Draw the estimates over the truth: a column per correlation time, a row per parameter, a box per method.

    Boxes hold half of the runs, whiskers nine tenths; the grey band is the truth with two Cramer-Rao deviations.

    Parameters
    ----------
    estimates
        Columns ``time``, ``method``, ``effect``, ``parameter``, ``value``.
    truth, bounds
        By correlation time [s]: values and relative bounds, index ``effect``, ``ordinal``, ``parameter``.
    """
    rows = [key for key in SYMBOLS if key in {(e, p) for e, _, p in truth[next(iter(truth))].index}]
    figure, grid = panels_of(len(rows), len(truth), 1.35 * len(rows) + 0.4, sharex="row", sharey=True)
    methods = list(estimates["method"].unique())
    for time, column in zip(truth, grid.T, strict=True):
        for (effect, parameter), panel in zip(rows, column, strict=True):
            of = estimates[
                (estimates["time"] == time) & (estimates["effect"] == effect) & (estimates["parameter"] == parameter)
            ]
            ratio = (of["value"] / truth[time][effect, 1, parameter]).clip(0, LARGEST)
            drawn = [ratio[of["method"] == name].dropna() for name in methods]
            boxes = panel.boxplot(drawn, orientation="horizontal", whis=(5, 95), showfliers=False, widths=0.6)
            for k, name in enumerate(methods):
                for part in (boxes["boxes"][k], boxes["medians"][k], *boxes["whiskers"][2 * k : 2 * k + 2]):
                    part.set(color=COLOURS[name], lw=1.2)
            width = 2 * bounds[time][effect, 1, parameter]
            panel.axvspan(max(1 - width, 0), min(1 + width, LARGEST), color="#dddddd", lw=0, zorder=0)
            panel.axvline(1, color="black", lw=0.6)
            panel.set(yticks=range(1, len(methods) + 1), yticklabels=[TITLES[name] for name in methods])
        column[0].set_title(f"T = {time} s")
    grid[0, 0].invert_yaxis()
    for row, (effect, parameter) in zip(grid, rows, strict=True):
        for panel in row:
            panel.set_xlabel(f"{_symbol(effect, parameter)} estimated / true")
            panel.xaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 4, 5, 10]))
    return figure


def iterations(histories: dict[str, pd.DataFrame], truth: pd.Series) -> Figure:
    """Draw every parameter over the iterations (figure 2 of Liu, Ren and Li 2016), relative to the truth.

    Parameters
    ----------
    histories
        By method: index iteration; a column per parameter, named ``effect ordinal parameter``.
    truth
        Values, index ``effect``, ``ordinal``, ``parameter``.
    """
    keys = [key for key in truth.index if (key[0], key[2]) in SYMBOLS and key[2] != "driving_psd"]
    figure, grid = panels_of(1, len(keys), 2.1, sharex=True)
    for key, panel in zip(keys, grid[0], strict=True):
        for name, history in histories.items():
            ratio = history[" ".join(map(str, key))] / truth[key]
            panel.plot(history.index, ratio, marker=MARKERS[name], ms=4, mfc="none", color=COLOURS[name],
                       label=TITLES[name])  # fmt: skip
        panel.axhline(1, color="black", lw=0.6)
        panel.set(title=_symbol(key[0], key[2]), xlabel="iteration")
        panel.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    grid[0, 0].set_ylabel("estimate / truth")
    legend_below(figure, 4)
    return figure


def bounds(table: pd.DataFrame) -> Figure:
    """Draw the Cramer-Rao bound of each parameter over the length of the log.

    Parameters
    ----------
    table
        Columns ``model``, ``time`` [s] (NaN without Gauss-Markov process), ``length`` [s], ``effect``, ``parameter``,
        ``bound`` (relative).
    """
    keys = [key for key in SYMBOLS if key in set(zip(table["effect"], table["parameter"], strict=True))]
    figure, grid = panels_of(1, len(keys), 2.6, sharex=True, sharey=True)
    colours = dict(zip(table["model"].unique(), ("black", "#999999", "#56B4E9", "#0072B2"), strict=False))
    times = sorted(table["time"].dropna().unique())
    for (effect, parameter), panel in zip(keys, grid[0], strict=True):
        of = table[(table["effect"] == effect) & (table["parameter"] == parameter)]
        for (model, time), line in of.groupby(["model", "time"], dropna=False, sort=False):
            place = 0 if np.isnan(time) else times.index(time)
            panel.plot(
                line["length"] / 3600,
                100 * line["bound"],
                color=colours[model],
                ms=3,
                label=model if np.isnan(time) else f"{model}, T = {time:g} s",
                **{key: looks[place] for key, looks in TIMES.items()},
            )
        panel.axhline(20, color="black", lw=1, ls=":")
        panel.set(title=_symbol(effect, parameter), xscale="log", yscale="log", xlabel="length [h]")
        panel.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    grid[0, 0].set_ylabel("bound [%]")
    grid[0, 0].text(0.03, 22, "20 %", transform=grid[0, 0].get_yaxis_transform(), fontsize=7)
    legend_below(figure, 4)
    return figure


def contamination(summary: pd.DataFrame) -> Figure:
    """Draw bias and root-mean-square error of each parameter, with and without outliers.

    Parameters
    ----------
    summary
        Rows of :func:`imugap.study.static.monte_carlo.summary` with a column ``log`` (``clean`` or ``contaminated``).
    """
    keys = [key for key in SYMBOLS if key in set(zip(summary["effect"], summary["parameter"], strict=True))]
    keys = [key for key in keys if key[1] != "driving_psd"]
    logs, methods = list(summary["log"].unique()), list(summary["method"].unique())
    figure, grid = panels_of(1, len(keys), 2.2, sharey=False)
    for (effect, parameter), panel in zip(keys, grid[0], strict=True):
        of = summary[(summary["effect"] == effect) & (summary["parameter"] == parameter)]
        for k, name in enumerate(methods):
            one = of[of["method"] == name].set_index("log").loc[logs]
            place = np.arange(len(logs)) + (k - (len(methods) - 1) / 2) * 0.8 / len(methods)
            panel.bar(place, 100 * one["rmse"], 0.8 / len(methods), color=COLOURS[name], label=TITLES[name])
            ends = 100 * np.abs(one[["rmse_low", "rmse_high"]].to_numpy().T - one["rmse"].to_numpy())
            panel.errorbar(place, 100 * one["rmse"], ends, fmt="none", color="black", lw=0.8)
        panel.set(title=_symbol(effect, parameter), yscale="log", xticks=range(len(logs)), xticklabels=logs)
    grid[0, 0].set_ylabel("error (RMS) [%]")
    legend_below(figure, 4)
    return figure


def _symbol(effect: str, parameter: str) -> str:
    """Return the symbol of a parameter as a formula."""
    return f"${SYMBOLS[effect, parameter]}$"


def goodness(table: pd.DataFrame) -> Figure:
    """Draw the wavelet variance of a log over that of the model chosen for it.

    Parameters
    ----------
    table
        Columns ``axis``, ``tau`` [s], ``ratio`` and ``error`` (relative standard deviation under the model).
    """
    axes = list(table["axis"].unique())
    figure, grid = panels_of(-(-len(axes) // 3), 3, 2.1 * -(-len(axes) // 3), sharex=True, sharey=True)
    for axis, panel in zip(axes, grid.flat, strict=False):
        one = table[table["axis"] == axis]
        low, high = (np.maximum(1 + sign * NORMAL_QUANTILE * one["error"], 1e-2) for sign in (-1, 1))
        panel.fill_between(one["tau"], low, high, color="#cccccc", lw=0, label="95 % under the model")
        panel.plot(one["tau"], one["ratio"], color="#D55E00", marker=".", label="device / model")
        panel.axhline(1, color="black", lw=0.6)
        panel.set(title=AXIS_TITLES[axis], xscale="log", yscale="log")
    label_lowest(grid, "averaging time τ [s]")
    for panel in grid[:, 0]:
        panel.set_ylabel("wavelet variance ratio")
    legend_below(figure, 2)
    return figure


def fitted(curves: pd.DataFrame, misfits: Misfits = MappingProxyType({})) -> Figure:
    """Draw the Allan deviation of each axis against the curve and the band of its fitted model.

    Parameters
    ----------
    curves
        Columns ``axis``, ``tau`` [s], ``deviation`` (of the log), ``model``, ``low``, ``high`` (where the model expects
        the deviation of so long a log); SI.
    misfits
        Ranges of averaging times [s] in which the model does not fit, by axis; they are marked.
    """
    axes = list(curves["axis"].unique())
    columns = min(len(axes), 3)
    rows = ceil(len(axes) / columns)
    figure, grid = panels_of(rows, columns, 2.2 * rows + 0.4, sharex=True)
    for axis, panel in zip(axes, grid.flat, strict=False):
        _fitted(panel, axis, curves[curves["axis"] == axis], misfits.get(axis, ()))
        panel.set_title(AXIS_TITLES[axis])
        panel.tick_params(labelbottom=True)
    for panel in grid.flat[len(axes) :]:
        panel.remove()
    legend_below(figure, 3)
    return figure


def fitted_axis(axis: str, curve: pd.DataFrame, misfits: Sequence[tuple[float, float]] = ()) -> Figure:
    """Draw what :func:`fitted` draws of one axis, as wide as a phone."""
    figure, (panel,) = card(2.6)
    _fitted(panel, axis, curve, misfits)
    legend_below(figure, 2)
    return figure


def _fitted(panel: Axes, axis: str, curve: pd.DataFrame, misfits: Sequence[tuple[float, float]]) -> None:
    unit, tau = allan_unit(axis), curve["tau"].to_numpy()
    deviation, model, low, high = (from_si(curve[c].to_numpy(), unit) for c in ("deviation", "model", "low", "high"))
    panel.fill_between(tau, low, high, color="#0072B2", alpha=0.2, lw=0, label="95 % of the logs that the model makes")
    for first, last in misfits:
        panel.axvspan(
            first / HALF, last * HALF, color=MISFIT, alpha=0.2, lw=0, label="the model does not fit", zorder=0
        )
    panel.plot(tau, model, color="#0072B2", label="fitted model")
    panel.plot(tau, deviation, color="black", marker=".", ms=2.5, lw=0.6, label="log")
    panel.set(xscale="log", yscale="log", xlabel="averaging time τ [s]", ylabel=allan_label(axis))
