"""Compare the names that were found on the virtual bench with its truth."""

import pandas as pd

from imugap.effects import title_of
from imugap.figures.static import TITLES
from imugap.figures.style import AXIS_TITLES
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

NOT_MISSING = ("bias", "white_noise", "turn_on_bias")
"""What every start model has, and a bias that is drawn anew, which one run cannot show."""


def named(model):
    """Return the (name, axis) of a model."""
    return {(name, axis) for axis, effects in model.items() for effect in effects for name in effect}


def score(reports, truth):
    """Yield, for each start and name, on how many axes it is true, known at the start, found, and found wrongly."""
    true = {(name, axis) for name, axis in named(truth) if name not in NOT_MISSING}
    for start, report in reports.items():
        known = named(report["start_model"])
        found = {(one["name"], axis) for one in report["effects"] for axis in one["axes"]}
        rivals = {
            (rival["name"], axis) for one in report["effects"] for rival in one["alternatives"] for axis in one["axes"]
        }
        groups = {"true": true, "known": known, "found": found, "rival": rivals}
        for name in sorted({name for name, _ in true | found}):
            of = {title: {axis for other, axis in group if other == name} for title, group in groups.items()}
            yield {
                "start": start, "name": name, "true": len(of["true"]), "known": len(of["known"] & of["true"]),
                "found": len(of["found"] & of["true"]), "rival": len(of["rival"] & of["true"]),
                "wrong": len(of["found"] - of["true"]),
                "missed": " ".join(axis for axis in AXIS_TITLES if axis in of["true"] - of["known"] - of["found"]),
            }  # fmt: skip


def page(data):
    """Lay the table out."""
    said = {"": "—", " ".join(AXIS_TITLES): "all six"}
    missed = [said.get(axes, ", ".join(map(AXIS_TITLES.get, axes.split()))) for axes in data["missed"]]
    heads = {
        "true": "true on", "known": "in the start model", "found": "found", "rival": "given as a rival",
        "wrong": "found where it is not",
    }  # fmt: skip
    names = data["name"].map(title_of)
    shown = data.assign(start=data["start"].map(TITLES), name=names)[["start", "name", *heads]]
    return shown.rename(columns={"start": "start model"} | heads).assign(**{"not found on": missed})


with job(snakemake) as (source, params, output):
    reports = dict(zip(params.starts, map(read_json, source.reports), strict=True))
    data = pd.DataFrame(score(reports, read_json(source.truth)["model"]))
    save(output, table=(data, page(data)))
