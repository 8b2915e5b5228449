"""Tabulate the example that opens the paper: hidden effects against what was found, and the distances."""

from shutil import copyfile

import pandas as pd

from imugap.effects import title_of
from imugap.figures.style import AXIS_TITLES
from imugap.study import verdicts
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

DIGITS = 5
DISTANCES = {"distance": "distribution", "navigation_distance": "navigation drift"}


def compared(key, report):
    """Return a row for each hidden parameter: its true value, and what was found on the same axis."""
    rows = []
    for hidden in key["effects"]:
        found = next(
            (one for one in report["effects"] if (one["name"], one["axes"]) == (hidden["name"], hidden["axes"])), None
        )
        for name, truth in hidden["parameters"].items():
            ends = {} if found is None else found["parameters"][name]
            rows.append({"axis": hidden["axes"][0], "effect": hidden["name"], "parameter": name, "truth": truth} | ends)
    data = pd.DataFrame(rows, columns=["axis", "effect", "parameter", "truth", "value", "low", "high", "unit"])
    return data.assign(holds=(data["low"] <= data["truth"]) & (data["truth"] <= data["high"]))


def page(data):
    """Lay out the comparison."""
    ends = data[["value", "low", "high"]].map(lambda end: tables.number(end, DIGITS))
    return pd.DataFrame({
        "axis": data["axis"].map(AXIS_TITLES),
        "effect": data["effect"].map(title_of),
        "parameter": [f"{name} [{tables.unit(unit)}]" for name, unit in data[["parameter", "unit"]].to_numpy()],
        "hidden": data["truth"].map(lambda truth: tables.number(truth, DIGITS)),
        "found (95 %)": ends["value"] + " [" + ends["low"] + ", " + ends["high"] + "]",
        "interval holds it": data["holds"].map({True: "yes", False: "no"}),
    })  # fmt: skip


def numbers(key, report, data):
    """Return what the text says."""
    named = {(one["name"], *one["axes"]) for one in report["effects"]}
    hidden = {(one["name"], *one["axes"]) for one in key["effects"]}
    apart = {
        name: {end: tables.number(report[of][end]["value"]) for end in ("before", "after")}
        | {"floor_high": tables.number(report[of]["floor"]["high"]),
           **verdicts.distance(*(report[of][state] for state in ("before", "after", "floor")))}
        for of, name in DISTANCES.items()
    }  # fmt: skip
    return {
        "duration_s": key["duration_s"],
        "rate_hz": tables.number(key["rate_hz"]),
        "hidden": len(hidden),
        "named": len(hidden & named),
        "false": len(named - hidden),
        "holds": int(data["holds"].sum()),
        "parameters": len(data),
        "distances": apart,
    }


with job(snakemake) as (source, _, output):
    key, report = read_json(source.key), read_json(source.report)
    data = compared(key, report)
    copyfile(source.figure, output.figure)
    save(output, table=(data, page(data)), numbers=numbers(key, report, data))
