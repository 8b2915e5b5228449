"""Compare the indices of the virtual bench with its truth."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.estimation.indices import INDICES
from imugap.figures.style import AXIS_TITLES
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import journal

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
    rows = []
    for row in data.itertuples():
        unit = INDICES[row.symbol].unit(row.axis)
        value, low, high, truth = (from_si(v, unit) for v in (row.value, row.low, row.high, row.truth))
        shown = tables.interval(value, low, high) if row.holds else f"≤ {tables.number(high)}"
        axis = AXIS_TITLES[row.axis]
        verdict = "inside" if row.inside else "outside"
        rows.append([axis, INDICES[row.symbol].title, tables.unit(unit), tables.number(truth), shown, verdict])
    return pd.DataFrame(rows, columns=["axis", "index", "unit", "truth", "estimate", "truth is"])


def numbers(data):
    """Collect what the text quotes: intervals and bounds that hold the truth, and how far bounds lie above it."""
    read, bounds = data[data["holds"]], data[~data["holds"]]
    factors = {symbol: one["high"] / one["truth"] for symbol, one in bounds.groupby("symbol", sort=False)}
    return {
        "read": len(read), "read_inside": int(read["inside"].sum()),
        "bounds": len(bounds), "bounds_above": int(bounds["inside"].sum()),
        "factors": {symbol: [tables.number(end(one), 2) for end in (min, max)] for symbol, one in factors.items()},
    }  # fmt: skip


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        model = json.loads(Path(snakemake.input.truth).read_text())["model"]
        data = score(pd.read_csv(snakemake.input.indices), model, 1 / snakemake.params.rate_hz)
        tables.write(snakemake.output[0].removesuffix(".csv"), data, page(data))
        Path(snakemake.output.numbers).write_text(json.dumps(numbers(data), indent=1) + "\n")
