"""Tabulate what was found on recordings of other devices."""

from math import isfinite, nan

import pandas as pd

from imugap.effects import title_of
from imugap.figures.style import AXIS_TITLES
from imugap.log import GYRO
from imugap.model import ErrorModel
from imugap.study import verdicts
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

STATES, ENDS = ("before", "after", "floor"), ("value", "low", "high")
DISTANCES = {"distance": "distribution", "navigation_distance": "navigation drift"}
NONE = "—"
FEW = 3
"""Effects of one name and the same axes that a page shows."""


def axes_of(names):
    """Give axes as a page shows them."""
    names = tuple(names)
    return "all six" if names == tuple(AXIS_TITLES) else ", ".join(AXIS_TITLES.get(name, name) for name in names)


def left_out(known):
    """Tell what discovery leaves out, and where."""
    shocks = ", ".join(f"{begin:.4g} to {end:.4g} s" for begin, end in known["shocks"])
    return [*known["left_out"], *([f"shocks of the device on several axes: {shocks}"] if shocks else [])]


def overview(known, reports):
    """Return the properties of each recording, the places, and the distances, a row for each distance."""
    return pd.DataFrame([
        {"recording": name, **{key: known[name][key] for key in ("duration_s", "rate_hz", "in_motion")},
         "left_out": "; ".join(left_out(known[name])), "places_before": len(report["gaps"]),
         "places_after": len(report["unexplained"]), "distance": title}
        | {f"{state}_{end}": report[key][state][end] for state in STATES for end in ENDS} | described(report, key)
        for name, report in reports.items() for key, title in DISTANCES.items() if report[key]
    ])  # fmt: skip


def described(report, key):
    """Return the distance with a description of noise that has no name, NaN where there is none."""
    nameless = report["nameless_noise"] if key == "distance" else None
    return {f"described_{end}": nameless["distance"]["after"][end] if nameless else nan for end in ENDS}


def overview_page(data, titles):
    """Lay out the properties, what was left out, and the distances."""
    return pd.DataFrame([
        {"recording": titles[one["recording"]],
         "log": f"{one['duration_s']:.0f} s at {tables.number(one['rate_hz'])} Hz, "
                + ("in motion" if one["in_motion"] else "at rest"),
         "left out": one["left_out"] or "nothing", "places": f"{one['places_before']}, then {one['places_after']}",
         "distance in": one["distance"]}
        | {state: tables.interval(*(one[f"{state}_{end}"] for end in ENDS))
           if isfinite(one[f"{state}_value"]) else NONE for state in ("before", "after", "described", "floor")}
        for one in data.to_dict("records")
    ])  # fmt: skip


def effects(reports):
    """Return a row for each parameter of each effect; those without ``named`` stand for noise without a name."""
    rows = []
    for recording, report in reports.items():
        named = [one | {"named": True} for one in report["effects"]]
        described = [{"axes": [one["axis"]], "alternatives": [], "named": False} | one for one in report["described"]]
        for number, one in enumerate([*named, *described]):
            rivals = " ".join(rival["name"] for rival in one["alternatives"])
            cells = {"recording": recording, "effect": number, "axes": " ".join(one["axes"]), "name": one["name"]}
            cells |= {"named": one["named"], "alternatives": rivals}
            rows += [cells | {"parameter": name} | ends for name, ends in one["parameters"].items()]
    heads = ["recording", "effect", "axes", "name", "named", "alternatives", "parameter", *ENDS, "unit"]
    return pd.DataFrame(rows, columns=heads)


def effects_page(data, titles):
    """Lay out the effects with their parameters; of many of one name and the same axes the first ones."""
    rows = []
    for (recording, axes, name, named), kin in data.groupby(["recording", "axes", "name", "named"], sort=False):
        title = title_of(name) if named else f"no name, as {title_of(name)}"
        cells = (titles[recording], axes_of(axes.split()), title)
        alike = [group for _, group in kin.groupby("effect", sort=False)]
        for group in alike[:FEW]:
            shown = "; ".join(
                f"{one.parameter.replace('_', ' ')} {tables.parameter(one.value, one.low, one.high, one.unit)}"
                for one in group.itertuples(index=False)
            )
            rivals = group["alternatives"].iloc[0].split()
            rows.append((*cells, shown, ", ".join(title_of(one) for one in rivals) or NONE))
        if len(alike) > FEW:
            rows.append((*cells, f"{len(alike) - FEW} more", NONE))
    heads = ["recording", "axes", "name", "parameters (95 %)", "not distinguished from it"]
    return pd.DataFrame(rows or [[NONE] * len(heads)], columns=heads)


def withheld(reports):
    """Return what was seen but not named, and why."""
    rows = [{"recording": name} | one for name, report in reports.items() for one in report["withheld"]]
    return pd.DataFrame(rows, columns=["recording", "axis", "name", "reason"])


def withheld_page(data, titles):
    """Lay out what was not named, and why."""
    rows = [
        (titles[recording], axes_of(group["axis"]), title_of(name), reason)
        for (recording, name, reason), group in data.groupby(["recording", "name", "reason"], sort=False)
    ]
    heads = ["recording", "axes", "something like", "not named because"]
    return pd.DataFrame(rows or [[NONE] * len(heads)], columns=heads)


def biases(reports, published):
    """Return the biases of the final models beside those that the publisher estimated."""
    rows = []
    for name, table in published.items():
        model = ErrorModel.from_mapping(reports[name]["final_model"])
        found = {axis: next(one.value for one in some if one.name == "bias") for axis, some in model.axes.items()}
        rows.append(table.assign(recording=name, found=table["axis"].map(found)))
    data = pd.concat(rows) if rows else pd.DataFrame(columns=["axis", "published", "recording", "found"])
    return data.assign(difference=data["found"] - data["published"])


def biases_page(data, titles):
    """Lay out the biases."""
    rows = [
        {"recording": titles[one["recording"]], "axis": AXIS_TITLES[one["axis"]]}
        | {key: tables.number(one[key]) for key in ("found", "published", "difference")}
        | {"unit": "rad/s" if one["axis"].startswith("gyro") else "m/s²"}
        for one in data.to_dict("records")
    ]  # fmt: skip
    heads = ["recording", "axis", "found", "published", "difference", "unit"]
    return pd.DataFrame(rows or [[NONE] * len(heads)], columns=heads)


def distances(report):
    """Return the distances of a recording as the text says them."""
    said = {}
    for key, title in DISTANCES.items():
        if one := report[key]:
            shown = {state: tables.number(one[state]["value"]) for state in STATES}
            shown["floor_high"] = tables.number(one["floor"]["high"])
            far = described(report, key)["described_value"]
            shown["described"] = tables.number(far) if isfinite(far) else None
            said[title.split()[0]] = shown | verdicts.distance(*(one[state] for state in STATES))
    return said


def numbers(known, reports, bias, titles):
    """Return what the text says of each recording, and in how many the distance in distribution reaches the floor."""
    said = {}
    for name, report in reports.items():
        shown = {key: tables.number(known[name][key]) for key in ("duration_s", "rate_hz")}
        parameters = {
            one["name"]: {key: tables.parameter(**ends) for key, ends in one["parameters"].items()}
            for one in report["effects"]
        }
        said[name] = shown | {
            "title": titles[name],
            "in_motion": known[name]["in_motion"],
            "left_out": left_out(known[name]),
            "shocks": len(known[name]["shocks"]),
            "names": [title_of(one) for one in parameters],
            "parameters": parameters,
            "withheld": list(dict.fromkeys(title_of(one["name"]) for one in report["withheld"])),
            "places": len(report["gaps"]),
            "left": len(report["unexplained"]),
            "distances": distances(report),
        }
        own = bias[(bias["recording"] == name) & bias["axis"].isin(GYRO)]
        if len(own):
            said[name]["gyro_bias_difference"] = tables.number(own["difference"].abs().max(), 2)
    far = [one["distances"]["distribution"] for one in said.values()]
    return {
        "recordings": said,
        "count": len(said),
        "reached": sum(one["reached"] for one in far),
        "unexplained": sum(one["left"] > 0 for one in said.values()),
    }


with job(snakemake) as (source, params, output):
    known, reports = (
        dict(zip(params.titles, map(read_json, paths), strict=True)) for paths in (source.properties, source.reports)
    )
    published = dict(zip(params.referenced, map(pd.read_csv, source.biases), strict=True))
    titles, data, named = params.titles, overview(known, reports), effects(reports)
    unnamed, bias = withheld(reports), biases(reports, published)
    save(output, overview=(data, overview_page(data, titles)), effects=(named, effects_page(named, titles)),
         withheld=(unnamed, withheld_page(unnamed, titles)), biases=(bias, biases_page(bias, titles)),
         numbers=numbers(known, reports, bias, titles))  # fmt: skip
