"""Figures of the simulated drives: each function draws one figure from runs or tables and returns it."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from imugap.figures.style import WIDTH, NotebookFigure, decades, label_lowest, legend_below, panels_of
from imugap.io import gnss
from imugap.simulation.gnss_faults import OUTAGE, OUTLIER, RAMP, STRETCH, FaultEvent, event_kinds
from imugap.study.drive.fault_ablation import (
    CLEAN,
    CONTAMINATED,
    ORACLE,
    SMOOTHED,
    WHEELS,
    WHOLE,
    Ablation,
    AblationRun,
)
from imugap.units import from_si

TITLES = {
    "none": "no control", "gate": "gate alone", "remove": "test and remove", "robust": "weigh down",
    "gated": "weigh down, gate", "reset": "and soft reset", "separation": "and solution separation",
    SMOOTHED: "all, smoothed", ORACLE: "bad fixes known", WHEELS[WHOLE]: "all, wheels",
    WHEELS[SMOOTHED]: "all, wheels, smoothed", WHEELS[ORACLE]: "bad fixes known, wheels",
}  # fmt: skip
COLOURS = {"none": "#999999", "gate": "#CC79A7", "remove": "#E69F00", "robust": "#56B4E9", "gated": "#0072B2",
           "reset": "#009E73", "separation": "#D55E00", SMOOTHED: "#8C564B", ORACLE: "black",
           WHEELS[WHOLE]: "#882255", WHEELS[SMOOTHED]: "#44AA99", WHEELS[ORACLE]: "#555555"}  # fmt: skip
SHADES = {STRETCH: "#f4cccc", RAMP: "#fce5cd", OUTAGE: "#dddddd"}
EVERY = 20
"""Epochs between two points of a path."""
SHOWN = {"gyro_x": ("gyro x [°/h]", "deg/h"), "gyro_z": ("gyro z [°/h]", "deg/h"), "accel_x": ("accel x [mg]", "mg"),
         "accel_y": ("accel y [mg]", "mg")}  # fmt: skip


def drive(study: Ablation, one: AblationRun, errors: Mapping[str, pd.DataFrame]) -> Figure:
    """Draw a drive from above, with its bad fixes, and the horizontal error of every scheme over time."""
    figure = NotebookFigure(figsize=(WIDTH, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1, 2.1])
    truth = study.drive.path[0]
    every = round(study.drive.rate_hz)
    left.plot(truth["east"][::every], truth["north"][::every], color="black", lw=0.7, label="truth")
    seen = gnss.local(one.fixes, one.solution.ellipsoid)
    kinds = event_kinds(one.fixes.index.to_numpy(), one.events)
    for kind, colour in ((STRETCH, "#CC0000"), (RAMP, "#E69F00"), (OUTLIER, "#0072B2")):
        rows = kinds == kind
        left.plot(seen[rows, 1], seen[rows, 0], ".", color=colour, ms=3, label=f"fixes, {kind}")
    left.set(xlabel="east [m]", ylabel="north [m]", aspect="equal")
    handles = list(left.lines)
    _shade(right, one.events)
    for name, table in errors.items():
        handles += right.plot(table["time"], table["horizontal"], color=COLOURS[name], lw=0.9, label=TITLES[name])
    decades(right)
    right.set(xlabel="time [s]", ylabel="horizontal error [m]", ylim=(0.1, None), xlim=(0, study.drive.duration_s))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def sensors(runs: Mapping[str, AblationRun]) -> Figure:
    """Draw estimated errors of sensors over time under every scheme, and the true ones."""
    figure, grid = panels_of(2, 2, 4.2, sharex=True)
    true = next(iter(runs.values())).true
    for panel, (axis, (title, unit)) in zip(grid.flat, SHOWN.items(), strict=True):
        _shade(panel, next(iter(runs.values())).events)
        panel.plot(true.index[::100], from_si(true[axis].to_numpy()[::100], unit), color="black", lw=1.2, label="truth")
        for name, one in runs.items():
            table = one.solution.sensors[axis]
            panel.plot(table.index[::EVERY], from_si(table.to_numpy()[::EVERY], unit), color=COLOURS[name], lw=0.9,
                       label=TITLES[name])  # fmt: skip
        panel.set(title=title, xlim=(0, true.index[-1]))
    label_lowest(grid, "time [s]")
    legend_below(figure, 4)
    return figure


def schemes(scores: pd.DataFrame) -> Figure:
    """Draw the 95th percentile of the horizontal error of all runs, and the effect of the gate on bias estimates."""
    figure = NotebookFigure(figsize=(WIDTH, 4.4), layout="constrained")
    left, *others = figure.subplot_mosaic([["left", "gyro"], ["left", "accel"]], width_ratios=[1.7, 1]).values()
    spread = np.linspace(-0.12, 0.12, scores["run"].nunique())
    for k, name in enumerate(TITLES):
        for case, shift, colour in ((CLEAN, -0.2, "#999999"), (CONTAMINATED, 0.2, COLOURS[name])):
            values = scores[(scores["scheme"] == name) & (scores["case"] == case)]["horizontal_95"].to_numpy()
            if not len(values):
                continue
            left.plot(values, k + shift + spread, ".", color=colour, ms=3.5)
            left.plot([np.median(values)] * 2, [k + shift - 0.2, k + shift + 0.2], color="black", lw=1.2)
    left.set_yticks(range(len(TITLES)), TITLES.values())
    left.set_xlabel("95th percentile of the horizontal error [m]")
    left.invert_yaxis()
    left.set_xscale("log")
    left.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    left.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    left.xaxis.set_minor_formatter(NullFormatter())
    bad = scores[scores["case"] == CONTAMINATED]
    for panel, name, title, unit in ((others[0], "gyro_bad", "Gyroscope bias [°/h]", "deg/h"),
                                     (others[1], "accel_bad", "Accelerometer bias [mg]", "mg")):  # fmt: skip
        of = from_si(bad.pivot(index="run", columns="scheme", values=name), unit)
        panel.plot(of["none"], of["gate"], "o", color=COLOURS["gate"], ms=3.5, label="gate alone")
        panel.plot(of["robust"], of["gated"], "^", color=COLOURS["gated"], ms=3.5, label="beside down-weighting")
        end = 1.05 * of[["none", "gate", "robust", "gated"]].max().max()
        panel.plot([0, end], [0, end], color="black", lw=0.6)
        panel.set(xlabel="error without gate", ylabel="error with gate", title=title, xlim=(0, end), ylim=(0, end))
    figure.legend(*others[0].get_legend_handles_labels(), loc="outside lower right", ncols=2)
    return figure


def _shade(panel, events: tuple[FaultEvent, ...]) -> None:
    for one in events:
        if one.end > one.begin:
            panel.axvspan(one.begin, one.end, color=SHADES[one.kind], lw=0, zorder=0)
        else:
            panel.axvline(one.begin, color="#0072B2", lw=0.4, alpha=0.5, zorder=0)
