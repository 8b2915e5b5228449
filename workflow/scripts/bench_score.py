"""Compare the indices of the virtual bench with its truth."""

import numpy as np
import pandas as pd

from imugap.estimation.indices import INDICES
from imugap.figures.style import AXIS_TITLES
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

TRUTH = {
    "bias": ("bias", "value"),
    "repeatability": ("turn_on_bias", "std"),
    "N": ("white_noise", "density"),
    "B": ("bias_instability", "density_b"),
    "K": ("random_walk", "density_k"),
}
"""Index to the effect and the parameter of the recipe that it estimates; the bias stability has no single one."""


def true_value(effects, symbol, interval):
    """Return the true value of an index; rounding to the lattice adds white noise of variance step^2/12 per sample."""
    name, parameter = TRUTH[symbol]
    value = effects[name][parameter]
    return np.hypot(value, effects["resolution"]["step"] * np.sqrt(interval / 12)) if symbol == "N" else value


def score(indices, model, interval):
    """Return the indices with their true values and whether the interval (or the bound) holds the truth."""
    effects = {axis: {name: values for item in items for name, values in item.items()} for axis, items in model.items()}
    known = indices[indices["symbol"].isin(TRUTH)].copy()
    known["truth"] = [true_value(effects[row.axis], row.symbol, interval) for row in known.itertuples()]
    known["inside"] = (known["low"] <= known["truth"]) & (known["truth"] <= known["high"])
    return known


def page(data):
    """Lay the table out: a row per axis and index."""
    for row in data.itertuples():
        unit = INDICES[row.symbol].unit(row.axis)
        value, low, high, truth = (from_si(v, unit) for v in (row.value, row.low, row.high, row.truth))
        shown = tables.interval(value, low, high) if row.holds else f"≤ {tables.number(high)}"
        yield {"axis": AXIS_TITLES[row.axis], "index": INDICES[row.symbol].title, "unit": tables.unit(unit),
               "truth": tables.number(truth), "estimate": shown,
               "truth is": "inside" if row.inside else "outside"}  # fmt: skip


def numbers(data):
    """Collect what the text quotes: intervals and bounds that hold the truth, and how far bounds lie above it."""
    read, bounds = data[data["holds"]], data[~data["holds"]]
    factors = {symbol: one["high"] / one["truth"] for symbol, one in bounds.groupby("symbol", sort=False)}
    return {
        "read": len(read), "read_inside": int(read["inside"].sum()),
        "bounds": len(bounds), "bounds_above": int(bounds["inside"].sum()),
        "factors": {symbol: [tables.number(end(one), 2) for end in (min, max)] for symbol, one in factors.items()},
    }  # fmt: skip


with job(snakemake) as (source, params, output):
    model = read_json(source.truth)["model"]
    data = score(pd.read_csv(source.indices), model, 1 / params.rate_hz)
    save(output, table=(data, page(data)), numbers=numbers(data))
