"""Compare the scatter of the bias over power cycles with what noise within a cycle explains."""

import numpy as np
import pandas as pd
from scipy.stats import chi2

from imugap import log
from imugap.estimation.indices import INDICES, of_run, repeatability
from imugap.figures import static
from imugap.figures.style import AXIS_TITLES
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def cycle(path, period):
    """Return the indices of one power cycle that its length can show, with its length [s]."""
    table = log.load(path)
    ideal = pd.Series(0.0, index=list(log.AXES))
    return of_run(table, ideal, period, ("bias", "stability", "N")).assign(length=log.duration(table))


def compare(cycles):
    """Yield repeatability, the floor sqrt(mean N^2/T) and the chi-square p-value that the floor explains it all."""
    for axis, group in cycles.groupby("axis", sort=False):
        means = group.loc[group["symbol"] == "bias", "value"].to_numpy()
        white = group[group["symbol"] == "N"]
        floor = np.sqrt((white["value"] ** 2 / white["length"]).mean())
        value, low, high = repeatability(means)
        p = chi2.sf((len(means) - 1) * (value / floor) ** 2, len(means) - 1)
        excess = np.sqrt(max(value**2 - floor**2, 0))
        yield {"axis": axis, "cycles": len(means), "repeatability": value, "low": low, "high": high,
                     "floor": floor, "p_value": p, "turn_on_bias": excess}  # fmt: skip


def page(data):
    """Lay the table out in data-sheet units."""
    unit = INDICES["repeatability"].gyro_unit
    rows = []
    for row in data.itertuples():
        value, low, high, floor, excess = (
            from_si(v, unit) for v in (row.repeatability, row.low, row.high, row.floor, row.turn_on_bias)
        )
        verdict = "turn-on bias" if row.p_value < 0.01 else "noise explains it"
        cells = [tables.interval(value, low, high), tables.number(floor), tables.number(row.p_value, 2)]
        rows.append([AXIS_TITLES[row.axis], row.cycles, *cells, tables.number(excess, 2), verdict])
    shown = tables.unit(unit)
    heads = [f"repeatability [{shown}]", f"noise floor of a mean [{shown}]", "p", f"beyond the floor [{shown}]"]
    return pd.DataFrame(rows, columns=["axis", "cycles", *heads, "verdict"])


with job(snakemake) as (source, params, output):
    found = {run: cycle(path, params.period_s) for run, path in zip(params.runs, source.logs, strict=True)}
    cycles = pd.concat(found, names=["run"]).reset_index("run")
    data = pd.DataFrame(compare(cycles))
    save(output, figure=static.repeatability(cycles[cycles["symbol"] == "bias"]), table=(data, page(data)))
