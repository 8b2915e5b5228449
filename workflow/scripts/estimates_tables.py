"""Tabulate the estimates of a device over its runs (tables 3 and 4 of the source)."""

import numpy as np
import pandas as pd

from imugap.effects import CATALOGUE
from imugap.estimation.result import Identifiability
from imugap.figures.estimation import SYMBOLS, TITLES
from imugap.figures.style import AXIS_TITLES
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

DATASHEET = {
    ("gyro", "density"): "deg/sqrt(h)",
    ("gyro", "std"): "deg/h",
    ("accel", "density"): "m/s/sqrt(h)",
    ("accel", "density_k"): "m/s/h/sqrt(h)",
}


def page(data, kind):
    """Lay the table out: a row per axis and method; first run with its interval, and the scatter over the runs."""
    part = data[data["axis"].str.startswith(kind) & (data["parameter"] != "driving_psd")]
    for (axis, method), group in part.groupby(["axis", "method"], sort=False):
        cells = {"axis": AXIS_TITLES[axis], "method": TITLES[method]}
        for (effect, parameter), runs in group.groupby(["effect", "parameter"], sort=False):
            unit = DATASHEET.get((kind, parameter), CATALOGUE[effect].units("")[parameter])
            shown = {
                name: [from_si(v, unit) if (kind, parameter) in DATASHEET else v for v in runs[name]]
                for name in ("value", "low", "high")
            }
            head = f"{SYMBOLS[effect, parameter]} [{tables.unit(unit)}]"
            cells[head] = cell(runs["verdict"].iloc[0], *(column[0] for column in shown.values()))
            known = np.array(shown["value"])[(runs["verdict"] == Identifiability.IDENTIFIED).to_numpy()]
            spread = f"{100 * known.std(ddof=1) / known.mean():.0f}" if len(known) > 1 else "—"
            cells[f"{SYMBOLS[effect, parameter]}: runs, scatter [%]"] = f"{len(known)}/{len(runs)}, {spread}"
        yield cells


def cell(verdict, value, low, high):
    """Show a value with its interval, or the bound that the log sets."""
    match verdict:
        case Identifiability.IDENTIFIED:
            return tables.interval(value, low, high)
        case Identifiability.UPPER_BOUND:
            return f"≤ {tables.number(high, 2)}"
        case Identifiability.LOWER_BOUND:
            return f"≥ {tables.number(low, 2)}"
    return "—"


def numbers(data):
    """Count how often each method pins down the correlation time of a gyroscope."""
    times = data[data["parameter"] == "correlation_time"]
    shares = (times["verdict"] == Identifiability.IDENTIFIED).groupby(times["method"], sort=False).agg(["sum", "count"])
    return {name: {"identified": int(row["sum"]), "of": int(row["count"])} for name, row in shares.iterrows()}


with job(snakemake) as (source, params, output):
    runs = zip(source.estimates, params.runs, strict=True)
    data = pd.concat([pd.read_csv(path).assign(run=run) for path, run in runs], ignore_index=True)
    parts = {kind: (data[data["axis"].str.startswith(kind)], page(data, kind)) for kind in ("gyro", "accel")}
    save(output, **parts, numbers=numbers(data))
