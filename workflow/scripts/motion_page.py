"""Tabulate what discovery names on trials in motion, whether they agree, and what the model of one says of another."""

from itertools import product

import pandas as pd

from imugap import log
from imugap.effects import CATALOGUE, title_of
from imugap.figures import discovery
from imugap.figures.style import AXIS_TITLES
from imugap.model import ErrorModel
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.discovery.transfer import explained_variance, parameter_agreement
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

NAMES = [name for name, effect in CATALOGUE.items() if effect.of_motion]
SCALES = {"1": ("%", 1e2), "rad": ("mrad", 1e3), "m": ("mm", 1e3), "s": ("ms", 1e3),
          "rad/s/(m/s^2)": ("mrad/s/(m/s²)", 1e3)}  # fmt: skip
"""How a unit is shown, and by what its values are multiplied."""


def effects(reports):
    """Return a row for each parameter, but for zeros, of each effect that answers the motion, by trial and axis."""
    rows = [
        {"trial": trial, "name": one["name"], "axis": axis, "parameter": name, **ends}
        for trial, report in reports.items()
        for one in report["effects"] if one["name"] in NAMES
        for axis, (name, ends) in product(one["axes"], one["parameters"].items()) if ends["value"]
    ]  # fmt: skip
    data = pd.DataFrame(rows, columns=["trial", "name", "axis", "parameter", "value", "low", "high", "unit"])
    ranks = {name: rank for rank, name in enumerate([*NAMES, *AXIS_TITLES])}
    order = {"name": data["name"].map(ranks), "axis": data["axis"].map(ranks)}
    return data.assign(**{f"{key}_rank": rank for key, rank in order.items()}).sort_values(
        ["name_rank", "axis_rank", "parameter", "trial"], kind="stable", ignore_index=True
    )[list(data)]


def effects_page(data, agreed, trials):
    """Lay out the parameters that several trials name, a column per trial."""
    rows = []
    for one in agreed.itertuples(index=False):
        found = data.query("name == @one.name and axis == @one.axis and parameter == @one.parameter").set_index("trial")
        title, scale = SCALES.get(found["unit"].iloc[0], (tables.unit(found["unit"].iloc[0]), 1.0))
        shown = {
            f"trial {trial}": tables.interval(*(scale * found.loc[trial, ["value", "low", "high"]]))
            if trial in found.index
            else "—"
            for trial in trials
        }
        name = f"{title_of(one.name)}, {one.parameter} [{title}]"
        rows.append({"effect": name, "axis": AXIS_TITLES[one.axis]} | shown | {"scatter": tables.number(one.factor, 2)})
    return pd.DataFrame(rows, columns=["effect", "axis", *(f"trial {trial}" for trial in trials), "scatter"])


def carried(models, logs, ideals, seed):
    """Return what the model of every trial explains of every trial, by axis."""
    found = (
        explained_variance(models[one], logs[other], ideals[other], stream(seed, "carried", one, other))
        .reset_index().assign(model=one, trial=other)
        for one, other in product(models, logs)
    )  # fmt: skip
    return pd.concat(found, ignore_index=True)


def reach(values):
    """Show the median and the range of shares."""
    ends = (round(100 * end) for end in (values.median(), values.min(), values.max()))
    return "{} ({} to {})".format(*ends) if len(values) else "—"


def explained_page(data, noise):
    """Lay out the difference from the ideal, what the cameras add at rest, and what own and other models explain."""
    own = data["model"] == data["trial"]
    for axis, one in data.groupby("axis", sort=False):
        unit = "m/s²" if axis in log.ACCEL else "mrad/s"
        scale = 1.0 if axis in log.ACCEL else 1e3
        yield {
            "axis": AXIS_TITLES[axis],
            "difference, rms": f"{tables.number(scale * one.loc[own, 'rms'].median(), 2)} {unit}",
            "cameras at rest": f"{tables.number(scale * noise.loc[noise['axis'] == axis, 'std'].median(), 2)} {unit}",
            "explained by the trial's own model [%]": reach(one.loc[own, "share"]),
            "by the model of another trial [%]": reach(one.loc[~own, "share"]),
        }  # fmt: skip


def distances(reports):
    """Return the distances on the last part of each trial."""
    return pd.DataFrame([
        {"trial": trial} | {f"{state}_{end}": one[end] for state, one in report["distance"].items() for end in one}
        for trial, report in reports.items()
    ])  # fmt: skip


def distances_page(reports):
    """Lay out the distances, how many effects were named, and how many places are left."""
    return pd.DataFrame([
        {"trial": trial} | {state: tables.interval(**one) for state, one in report["distance"].items()}
        | {"change": verdicts.change(report["distance"]["before"], report["distance"]["after"])}
        | {"effects of motion": sum(one["name"] in NAMES for one in report["effects"]),
           "other effects": sum(one["name"] not in NAMES for one in report["effects"]),
           "withheld": len(report["withheld"]), "places before": len(report["gaps"]),
           "places after": len(report["unexplained"])}
        for trial, report in reports.items()
    ])  # fmt: skip


def numbers(reports, agreed, share, noise):
    """Return what the text says."""
    other = share[share["model"] != share["trial"]]
    kinds = {kind: other["axis"].isin(axes) for kind, axes in log.TRIADS.items()}
    apart = [report["distance"] for report in reports.values()]
    return {
        "trials": list(reports),
        "rate_hz": tables.number(next(iter(reports.values()))["log"][0]["rate_hz"]),
        "unseen": tables.number(100 * noise["unseen"].max(), 2),
        "agreed": len(agreed),
        "same_sign": int(agreed["same_sign"].sum()),
        "factors": {
            title_of(name): tables.number(one.median(), 2) for name, one in agreed.groupby("name", sort=False)["factor"]
        },
        "carried": {
            kind: [round(100 * end) for end in other.loc[of, "share"].quantile([0.5, 0.0, 1.0])]
            for kind, of in kinds.items()
        },
        "smaller": sum(one["after"]["value"] < one["before"]["value"] for one in apart),
        "nearer": sum(verdicts.change(one["before"], one["after"]) == verdicts.NEARER for one in apart),
        "within_before": sum(one["before"]["value"] <= one["floor"]["high"] for one in apart),
        "reached": sum(one["after"]["value"] <= one["floor"]["high"] for one in apart),
    }


with job(snakemake) as (source, params, output):
    reports, models, logs, ideals = (
        dict(zip(params.trials, map(read, paths), strict=True))
        for read, paths in (
            (read_json, source.reports),
            (ErrorModel.read, source.models),
            (log.load, source.logs),
            (log.load, source.ideals),
        )
    )
    noise = pd.concat(map(pd.read_csv, source.noises))
    data = effects(reports)
    agreed, share = parameter_agreement(data), carried(models, logs, ideals, params.seed)
    figure = discovery.repeated(data.merge(agreed[["name", "axis", "parameter"]]), SCALES)
    save(output, effects=(data, effects_page(data, agreed, params.trials)), figure=figure,
         explained=(share, explained_page(share, noise)), distances=(distances(reports), distances_page(reports)),
         numbers=numbers(reports, agreed, share, noise))  # fmt: skip
