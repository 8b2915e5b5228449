"""Tabulate the indices of a device."""

import pandas as pd

from imugap.estimation.indices import INDICES
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def in_datasheet_units(indices):
    """Add the data-sheet unit and the values in it."""
    units = [INDICES[row.symbol].unit(row.axis) for row in indices.itertuples()]
    converted = {
        f"{name}_datasheet": [from_si(v, u) for v, u in zip(indices[name], units, strict=True)]
        for name in ("value", "low", "high")
    }
    return indices.assign(datasheet_unit=units, **converted)


def page(data):
    """Lay the table out: a row per index, a column per axis, gyroscopes above accelerometers."""
    for kind, sensor in {"gyro": "gyroscope", "accel": "accelerometer"}.items():
        part = data[data["axis"].str.startswith(kind)]
        for symbol, group in part.groupby("symbol", sort=False):
            unit = tables.unit(group["datasheet_unit"].iloc[0])
            cells = {row.axis[-1]: cell(row) for row in group.itertuples()}
            yield {"sensor": sensor, "index": INDICES[symbol].title, "unit": unit, **cells}


def cell(row):
    """Show a reading with its interval, a bound with its sign."""
    value, low, high = row.value_datasheet, row.low_datasheet, row.high_datasheet
    return tables.interval(value, low, high) if row.holds else f"≤ {tables.number(high)}"


def numbers(data):
    """Count the values of N, B and K of all axes, and those of them that can be read."""
    laws = data[data["symbol"].isin(["N", "B", "K"])]
    return {"laws": len(laws), "read": int(laws["holds"].sum())}


with job(snakemake) as (source, _, output):
    data = in_datasheet_units(pd.read_csv(source.indices))
    save(output, table=(data, page(data)), numbers=numbers(data))
