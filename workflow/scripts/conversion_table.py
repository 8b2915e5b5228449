"""Tabulate what each tool takes for the noise of a sensor, with the values of every device."""

from itertools import zip_longest

import pandas as pd

from imugap import log
from imugap.interchange.conventions import CONVENTIONS, HOUR, Rule, by_triad, reduced_axes
from imugap.model import ErrorModel
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

NAMES = {"bench": "virtual bench", "adis16405": "ADIS16405", "own": "own device"}


def values(device, model, rule):
    """Return every parameter of every tool for a device, in the unit of the tool."""
    of = by_triad(reduced_axes(model, rule), rule)
    rows = []
    for convention in CONVENTIONS:
        for kind, parameters in (("gyro", convention.gyro), ("accel", convention.accel)):
            for one in parameters:
                value = from_si(one.value(of[kind], rule), one.unit)
                rows.append([convention.tool, kind, one.name, one.meaning, one.unit, one.formula, device, value,
                             rule.rate, convention.source])  # fmt: skip
    columns = ["tool", "kind", "parameter", "meaning", "unit", "formula", "device", "value", "rate_hz", "source"]
    return pd.DataFrame(rows, columns=columns)


def page(data):
    """Lay the table out: the parameters of gyroscope and accelerometer side by side, a column per device."""
    shown = data.set_index(["tool", "parameter", "device"])["value"]
    for convention in CONVENTIONS:
        for pair in zip_longest(convention.gyro, convention.accel):
            of = [one for one in pair if one]
            names = dict.fromkeys(one.name.split()[-1] for one in of)
            row = {
                "tool": convention.tool if pair[0] is convention.gyro[0] else "",
                "gyroscope, accelerometer": ", ".join(names),
                "meaning": of[0].meaning,
                "formula": of[0].formula,
                "unit": ", ".join(dict.fromkeys(tables.unit(one.unit) for one in of)),
            }
            for device in data["device"].unique():
                numbers = (tables.number(shown[convention.tool, one.name, device]) for one in of)
                row[NAMES[device]] = ", ".join(dict.fromkeys(numbers))
            yield row


with job(snakemake) as (source, params, output):
    found = []
    for device, model, path in zip(params.devices, source.models, source.logs, strict=True):
        rate = 1 / log.interval(log.load(path, columns=[log.AXES[0]]))
        rule = Rule(rate, params.horizon_s, correlation_time=HOUR)
        found.append(values(device, ErrorModel.read(model), rule))
    data = pd.concat(found)
    save(output, table=(data, page(data)))
