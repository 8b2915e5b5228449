"""Lay out the two-dimensional example: figures, table, numbers of the text."""

from pathlib import Path

import pandas as pd
import yaml

from imugap.figures import planar
from imugap.interchange.augmentation import augmentation
from imugap.interchange.datasheet import MODELS
from imugap.navigation.planar import QUANTITIES, SCOPES, VEHICLE, PlanarExample
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SHOWN = {
    "gyro": {"white": "deg/sqrt(h)", "flicker": "deg/h", "walk": "deg/h/sqrt(h)", "turn_on": "deg/h"},
    "accel": {"white": "m/s/sqrt(h)", "flicker": "mg", "walk": "m/s/h/sqrt(h)", "turn_on": "mg"},
}
"""Units in which the text gives the figures of a sensor."""


def inside(nees):
    """Return the share of epochs at which the mean NEES lies inside its two-sided band, per case, filter and scope."""
    within = (nees["nees"] >= nees["low"]) & (nees["nees"] <= nees["high"])
    return within.groupby([nees["case"], nees["filter"], nees["scope"]], sort=False).mean()


def page(ends, shares, states):
    """Lay the table out: a row per truth and filter."""
    for (case, title), group in ends.groupby(["case", "filter"], sort=False):
        one = group.set_index("quantity")
        row = {"truth": planar.CASES[case].removeprefix("truth: "), "filter": title, "states": states[title]}
        row["position error [m]"] = tables.interval(*one.loc["position", ["actual", "actual_low", "actual_high"]])
        for quantity in QUANTITIES:
            row[quantity] = tables.interval(*one.loc[quantity, ["ratio", "low", "high"]])
        for scope in SCOPES:
            row[f"NEES, {scope} [%]"] = f"{100 * shares[case, title, scope]:.0f}"
        yield row


def numbers(ends, shares, example, runs):
    """Collect what the text quotes: per case and model, the position error and what it is of the predicted one."""
    of = ends.set_index(["case", "filter", "quantity"])
    known = ends.dropna(subset="computed_ratio")
    agree = (known["low"] <= known["computed_ratio"]) & (known["computed_ratio"] <= known["high"])
    said = {
        case: {
            title: {
                "ratio": {name: tables.number(of.loc[(case, title, name), "ratio"], 2) for name in QUANTITIES},
                "position_m": tables.number(of.loc[(case, title, "position"), "actual"], 2),
                "inside_percent": [f"{100 * shares[case, title, scope]:.0f}" for scope in SCOPES],
            }
            for title in MODELS
        }
        for case in planar.CASES
    }
    sensors = {
        name: {key: tables.number(from_si(getattr(sheet, key), unit), 2) for key, unit in units.items()}
        for (name, units), sheet in zip(SHOWN.items(), example.sheets, strict=False)
    }
    return {"runs": runs, "case": said, "agree": int(agree.sum()), "compared": len(known), "sensors": sensors}


with job(snakemake) as (source, params, output):
    example, recipe = PlanarExample.read(source.recipe), yaml.safe_load(Path(source.recipe).read_text())
    spread, ends, nees = (pd.concat(map(pd.read_parquet, source[name])) for name in ("spread", "ends", "nees"))
    for case in planar.CASES:
        save(output, **{case: planar.spread(spread[spread["case"] == case], recipe["drive"]["outages_s"])})
    shares = inside(nees)
    states = {
        title: len(VEHICLE) + sum(len(augmentation(model).output) for model in example.models(slow))
        for title, slow in MODELS.items()
    }
    found = numbers(ends, shares, example, params.runs) | {"drive": recipe["drive"]}
    table = ends, page(ends, shares, states)
    save(output, consistency=planar.consistency(nees, example.drive), table=table, numbers=found)
