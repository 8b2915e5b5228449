"""Compare the names that were found on the virtual bench with its truth."""

import numpy as np
import pandas as pd

from imugap import log
from imugap.discovery.search.intervals import axis_unit
from imugap.effects import title_of
from imugap.figures.static import TITLES
from imugap.figures.style import AXIS_TITLES
from imugap.model import ErrorModel
from imugap.study.discovery.oracle_size import sizes_in_limits
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

NOT_MISSING = ("bias", "white_noise", "turn_on_bias")
"""What every start model has, and a bias that is drawn anew, which one run cannot show."""
VALUES = {"bias_instability": "density_b", "random_walk": "density_k", "temperature": "coefficient"}
"""Name to the parameter whose value is compared; the lattice of means is not that of the samples."""
STARTS = TITLES | {"runs": "White noise, all runs"}
REPEATED = "temperature"


def named(model):
    """Return the (name, axis) of a model."""
    return {(name, axis) for axis, effects in model.items() for effect in effects for name in effect}


def true_values(model):
    """Return the true values by (name, axis)."""
    return {
        (name, axis): values[VALUES[name]]
        for axis, effects in model.items() for effect in effects for name, values in effect.items() if name in VALUES
    }  # fmt: skip


def intervals(report):
    """Return the interval of the value of each effect of one axis that was found, by (name, axis)."""
    return {
        (one["name"], axis): one["parameters"][VALUES[one["name"]]]
        for one in report["effects"] for axis in one["axes"] if one["name"] in VALUES and len(one["axes"]) == 1
    }  # fmt: skip


def score(reports, truth):
    """Yield, for each start and name, on how many axes it is true, known at the start, found, and found wrongly."""
    true = {(name, axis) for name, axis in named(truth) if name not in NOT_MISSING}
    values = true_values(truth)
    for start, report in reports.items():
        known = named(report["start_model"])
        found = {(one["name"], axis) for one in report["effects"] for axis in one["axes"]}
        rivals = {
            (rival["name"], axis) for one in report["effects"] for rival in one["alternatives"] for axis in one["axes"]
        }
        ends = {key: one for key, one in intervals(report).items() if key in values}
        held = {key for key, one in ends.items() if one["low"] <= values[key] <= one["high"]}
        groups = {"true": true, "known": known, "found": found, "rival": rivals, "valued": set(ends), "held": held}
        for name in sorted({name for name, _ in true | found if name not in NOT_MISSING}):
            of = {title: {axis for other, axis in group if other == name} for title, group in groups.items()}
            yield {
                "start": start, "name": name, "true": len(of["true"]), "known": len(of["known"] & of["true"]),
                "found": len(of["found"] & of["true"]), "valued": len(of["valued"]), "held": len(of["held"]),
                "rival": len(of["rival"] & of["true"]), "wrong": len(of["found"] - of["true"]),
                "missed": " ".join(axis for axis in AXIS_TITLES if axis in of["true"] - of["known"] - of["found"]),
            }  # fmt: skip


def page(data):
    """Lay the table out."""
    said = {"": "—", " ".join(AXIS_TITLES): "all six"}
    missed = [said.get(axes, ", ".join(map(AXIS_TITLES.get, axes.split()))) for axes in data["missed"]]
    heads = {
        "true": "true on", "known": "in the start model", "found": "found", "within": "intervals with the truth",
        "rival": "given as a rival", "wrong": "found where it is not",
    }  # fmt: skip
    within = [f"{row.held} of {row.valued}" if row.valued else "—" for row in data.itertuples()]
    shown = data.assign(start=data["start"].map(STARTS), name=data["name"].map(title_of), within=within)
    shown = shown[["start", "name", *heads]].rename(columns={"start": "start model"} | heads)
    return shown.assign(**{"not found on": missed})


def repeated(report, truth, logs):
    """Yield, for each axis with an answer to the temperature, its size for the test that knows it, and the finding."""
    found = intervals(report)
    for axis, effects in ErrorModel.from_mapping(truth).axes.items():
        known = [one for one in effects if one.name == REPEATED]
        sizes = np.array([sizes_in_limits(logs, axis, effects, one) for one in known])
        for one, of_runs in zip(known, sizes, strict=True):
            ends = found.get((REPEATED, axis), {})
            yield {
                "axis": axis, "truth": one.coefficient, "one": of_runs[0], "all": float(np.linalg.norm(of_runs)),
                **{end: ends.get(end) for end in ("value", "low", "high")},
            }  # fmt: skip


def repeated_page(data):
    """Lay the table of what all runs repeat out."""
    for row in data.itertuples():
        named = pd.notna(row.value)
        yield {
            "axis": AXIS_TITLES[row.axis], "true value": f"{tables.number(row.truth)} {axis_unit(row.axis)}/°C",
            "size in the first run": tables.number(row.one, 2), "size in all runs": tables.number(row.all, 2),
            "found in all runs": tables.interval(row.value, row.low, row.high) if named else "—",
        }  # fmt: skip


def numbers(data, repeats):
    """Collect what the text quotes of the search in all runs together."""
    runs, found = data[data["start"] == "runs"], repeats[repeats["value"].notna()]
    return {
        "valued": int(runs["valued"].sum()), "held": int(runs["held"].sum()), "wrong": int(runs["wrong"].sum()),
        "temperature": len(found),
        "temperature_held": int(((found["low"] <= found["truth"]) & (found["truth"] <= found["high"])).sum()),
        "axes": len(repeats),
        **{f"largest_in_{length}": tables.number(repeats[length].max(), 2) for length in ("one", "all")},
    }  # fmt: skip


with job(snakemake) as (source, params, output):
    reports = dict(zip(params.starts, map(read_json, source.reports), strict=True))
    truth = read_json(source.truth)["model"]
    data = pd.DataFrame(score(reports, truth))
    repeats = pd.DataFrame(repeated(reports["runs"], truth, list(map(log.load, source.logs))))
    save(
        output,
        table=(data, page(data)),
        repeated=(repeats, repeated_page(repeats)),
        numbers=numbers(data, repeats),
    )
