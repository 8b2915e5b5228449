"""Draw and tabulate how often a probable name is right, and what a search loses; write what the text says of both."""

import numpy as np
import pandas as pd

from imu_benchmark.forecasts import (
    OTHER,
    ambiguity_sets,
    brier_score,
    calibration_error,
    calibration_errors,
    log_score,
    reliability,
)
from imu_benchmark.scores import NONE, UNKNOWN, rate
from imugap.effects import CATALOGUE, title_of
from imugap.figures import sealed_trials as drawn
from imugap.log import AXES
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.discovery.detection_loss import bonferroni_half_size, half_size
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import record_of, save

CHOICES = len(CATALOGUE) * len(AXES)
RESAMPLES = 2000
"""Resamples of the cases for the interval of the calibration error."""
CALIBRATION_AIM = 0.03
"""What the calibration error is to be at most."""


def loss_table(curves):
    """Return the size at which one half of each effect is found, its loss over the test that knows it, and shares."""
    rows = []
    for name, group in curves.groupby("name"):
        one = half_size(group["size"], group["seen"])
        right = group.loc[group["seen"], "right"]
        rows.append({"name": name, "count": len(group), "half": one.value, "low": one.low, "high": one.high,
                     "loss": one.value - 1, "seen": len(right), "right": int(right.sum())})  # fmt: skip
    return pd.DataFrame(rows)


def loss_page(losses):
    """Lay the losses out, a row for each effect."""
    return pd.DataFrame({
        "hidden": losses["name"].map(title_of),
        "cases": losses["count"],
        "one half found at [limits]": [
            f"{one.half:.2f} [{one.low:.2f}, {one.high:.2f}]".replace("inf", "∞") for one in losses.itertuples()
        ],
        "loss [limits]": [f"{one:.2f}".replace("inf", "∞") for one in losses["loss"]],
        "rightly named of those found": [f"{one.right} of {one.seen}" for one in losses.itertuples()],
    })  # fmt: skip


def reliability_page(bins):
    """Lay the bins out, a row each."""
    return pd.DataFrame({
        "probability": [f"{10 * one.bin} to {10 * one.bin + 10} %" for one in bins.itertuples()],
        "mean": [f"{100 * one.confidence:.1f} %" for one in bins.itertuples()],
        "answers": bins["count"],
        "right": [f"{100 * one.rate:.0f} % [{100 * one.low:.0f}, {100 * one.high:.0f}]" for one in bins.itertuples()],
    })  # fmt: skip


def placed(table):
    """Return the forecasts of the questions that a place answers: those that list a name."""
    names = ~table["name"].isin([NONE, OTHER, UNKNOWN])
    return table[names.groupby([table["case"], table["question"]]).transform("any")]


def numbers(table, losses, tried):
    """Return what the text says; ``tried`` are the largest sizes [limits] of each effect."""
    sets, found = ambiguity_sets(table), losses[np.isfinite(losses["loss"])]
    largest = found.loc[found["loss"].idxmax()]
    seen = ambiguity_sets(placed(table))
    held, held_seen = rate(sets["holds"]), rate(seen["holds"])
    low, high = np.quantile(calibration_errors(table, RESAMPLES, stream(1, "calibration")), [0.025, 0.975])
    return {
        "cases": int(table["case"].nunique()),
        "answers": len(sets),
        "calibration_error": f"{calibration_error(table):.3f}",
        "calibration_low": f"{low:.3f}",
        "calibration_high": f"{high:.3f}",
        "calibration_aim": f"{CALIBRATION_AIM:g}",
        "calibration_verdict": verdicts.aim((low, high), CALIBRATION_AIM),
        "brier": f"{brier_score(table):.3f}",
        "log_score": f"{log_score(table):.3f}",
        "set_holds": f"{100 * held['rate']:.1f}",
        "set_low": f"{100 * held['low']:.1f}",
        "set_high": f"{100 * held['high']:.1f}",
        "set_size": f"{sets['size'].mean():.2f}",
        "seen": len(seen),
        "seen_holds": f"{100 * held_seen['rate']:.1f}",
        "seen_low": f"{100 * held_seen['low']:.1f}",
        "seen_size": f"{seen['size'].mean():.2f}",
        "singles": int(losses["count"].sum()),
        "effects": len(losses),
        "median_loss": tables.number(float(losses["loss"].median()), 2),
        "largest_loss": tables.number(float(largest["loss"]), 2),
        "largest_name": title_of(str(largest["name"])),
        "largest_tried": bool(largest["half"] <= tried[largest["name"]]),
        "below_names": [title_of(name) for name in losses["name"][losses["high"] < 1]],
        "choices": CHOICES,
        "bound": f"{bonferroni_half_size(CHOICES):.2f}",
    }


with job(snakemake) as (source, _, output):
    files = dict(source.items())
    table, curves = pd.read_csv(files["forecasts"]), pd.read_csv(files["curves"])
    bins, losses = reliability(table), loss_table(curves)
    curve = pd.DataFrame([{"size": size} | rate(group["seen"]) for size, group in curves.groupby("size")])
    save(
        output,
        reliability_figure=drawn.reliability(bins),
        curves_figure=drawn.losses(curve, losses, CHOICES),
        reliability=(bins, reliability_page(bins)),
        losses=(losses, loss_page(losses)),
        numbers=numbers(table, losses, curves.groupby("name")["size"].max()) | record_of(files),
    )
