"""Tabulate what is missing from the models of a device, where, and how far the discrepancy shrinks on other runs."""

from itertools import groupby
from math import isfinite, nan
from shutil import copyfile

import pandas as pd

from imugap.discovery.finding import Discrepancy
from imugap.discovery.verdict import describe_range
from imugap.effects import title_of
from imugap.figures.static import TITLES
from imugap.figures.style import AXIS_TITLES
from imugap.figures.views import title
from imugap.study import verdicts
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save

DISTANCES = {"distance": "distribution", "navigation_distance": "navigation drift"}
STATES, ENDS = ("before", "after", "floor"), ("value", "low", "high")
FEW = 3
"""Effects of one name and the same axes that a page shows; of more it tells where the others are."""
PAIRS = "two axes"
SLOW_NOISE = ("bias_instability", "gauss_markov", "random_walk", "random_telegraph")
"""What noise of any slope may stand for."""


def axes_of(names):
    """Give axes as a page shows them."""
    names = tuple(names)
    return "all six" if names == tuple(AXIS_TITLES) else ", ".join(AXIS_TITLES.get(name, name) for name in names)


def view_title(place):
    """Give the view of a place as a page shows it."""
    return title(place["view"])


def effects(reports):
    """Return a row for each parameter of each effect."""
    return pd.DataFrame([
        {"start": start, "effect": number, "axes": " ".join(one["axes"]), "name": one["name"],
         "p_value": one["p_value"], "alternatives": " ".join(rival["name"] for rival in one["alternatives"]),
         "parameter": name, **ends}
        for start, report in reports.items()
        for number, one in enumerate(report["effects"])
        for name, ends in one["parameters"].items()
    ])  # fmt: skip


def effects_page(reports):
    """Lay out the effects with their parameters, the surest of one name and the same axes."""
    rows = []
    for start, report in reports.items():
        kin = {}
        for one in report["effects"]:
            kin.setdefault((tuple(one["axes"]), one["name"]), []).append(one)
        for (axes, name), group in kin.items():
            cells = [TITLES[start], axes_of(axes), title_of(name)]
            for one in group[:FEW]:
                shown = "; ".join(
                    f"{key.replace('_', ' ')} {tables.parameter(**ends)}" for key, ends in one["parameters"].items()
                )
                rivals = ", ".join(title_of(other["name"]) for other in one["alternatives"])
                rows.append([*cells, shown, rivals or "—"])
            if len(group) > FEW:
                key, ends = next(iter(group[0]["parameters"].items()))
                values = [one["parameters"][key]["value"] for one in group[FEW:]]
                reach = " to ".join(tables.number(value) for value in (min(values), max(values)))
                rows.append([*cells, f"{len(values)} more, {key.replace('_', ' ')} {reach} {ends['unit']}", "—"])
    return pd.DataFrame(rows, columns=["start model", "axes", "name", "parameters (95 %)", "not distinguished from it"])


def places(reports):
    """Return the places that the start model leaves and those that the final one leaves."""
    return pd.DataFrame([
        {"start": start, "model": model} | place
        for start, report in reports.items()
        for model, key in (("start", "gaps"), ("final", "unexplained"))
        for place in report[key]
    ], columns=["start", "model", "view", "axis", "low", "high", "unit", "p_value"])  # fmt: skip


def places_listed(places):
    """Tell how many places there are, and which is the surest of each of the surest views."""
    surest = [
        next(group)
        for _, group in groupby(sorted(places, key=lambda place: place["view"]), lambda place: place["view"])
    ]
    first = sorted(surest, key=lambda place: place["p_value"])[:FEW]
    shown = "; ".join(f"{view_title(place)} {tables.unit(describe_range(Discrepancy(**place)))}" for place in first)
    return f"{len(places)}: {shown}" if places else "none"


def places_page(reports):
    """Lay out the places, a row for each axis."""
    rows = []
    for start, report in reports.items():
        for axis in [*AXIS_TITLES, PAIRS]:
            sides = [
                [place for place in report[key] if (PAIRS if "," in place["axis"] else place["axis"]) == axis]
                for key in ("gaps", "unexplained")
            ]
            if any(sides):
                rows.append([TITLES[start], AXIS_TITLES.get(axis, axis), *map(places_listed, sides)])
    heads = ["start model", "axis", "places where the start model leaves the log", "where the final model leaves it"]
    return pd.DataFrame(rows, columns=heads)


def withheld(reports):
    """Return what was seen but not named, and the exponent of the noise that the final model has on its axis."""
    rows = []
    for start, report in reports.items():
        laws = (one for one in report["described"] if one["name"] == "power_law")
        exponents = {one["axis"]: one["parameters"]["exponent"] for one in laws}
        for one in report["withheld"]:
            ends = exponents.get(one["axis"], {}) if one["name"] in SLOW_NOISE else {}
            rows.append({"start": start} | one | {f"exponent_{end}": ends.get(end, nan) for end in ENDS})
    return pd.DataFrame(rows, columns=["start", "axis", "name", "reason", *(f"exponent_{end}" for end in ENDS)])


def withheld_page(data):
    """Lay out what was not named, and why."""
    rows = []
    for (start, axis, name, reason), group in data.groupby(["start", "axis", "name", "reason"], sort=False):
        ends = [float(group[f"exponent_{end}"].iloc[0]) for end in ENDS]
        model = tables.interval(*ends) if isfinite(ends[0]) else "—"
        rows.append((TITLES[start], AXIS_TITLES.get(axis, axis), title_of(name), reason, len(group), model))
    heads = ["start model", "axis", "something like", "not named because", "times", "exponent"]
    return pd.DataFrame(rows or [["—"] * len(heads)], columns=heads)


def distances(reports):
    """Yield the distances on the other runs, and whether the last one is within the floor's interval or below it."""
    for start, report in reports.items():
        for key, name in DISTANCES.items():
            row = {"start": start, "distance": name}
            for state in STATES:
                row |= {f"{state}_{end}": report[key][state][end] for end in ENDS}
            yield row | {"reached": row["after_value"] <= row["floor_high"]}


def distances_page(data):
    """Lay out the distances."""
    shown = {
        state: [tables.interval(*ends) for ends in data[[f"{state}_{end}" for end in ENDS]].itertuples(index=False)]
        for state in STATES
    }
    reached = data["reached"].map({True: "yes", False: "no"})
    first = {"start model": data["start"].map(TITLES), "distance in": data["distance"]}
    return pd.DataFrame(first | shown | {"reaches the floor": reached})


def numbers(reports, data):
    """Return what the text says."""
    first = next(iter(reports.values()))
    said = {
        "duration_s": tables.number(first["log"][0]["duration_s"]),
        "rate_hz": tables.number(first["log"][0]["rate_hz"]),
        "tests": len(first["test"]),
        "starts": {},
    }
    for start, report in reports.items():
        rows = data[data["start"] == start].set_index("distance")
        left = sorted({axis for place in report["unexplained"] for axis in place["axis"].split(",")})
        said["starts"][start] = {
            "title": TITLES[start],
            "gaps": len(report["gaps"]),
            "left": len(report["unexplained"]),
            "left_axes": axes_of(axis for axis in AXIS_TITLES if axis in left),
            "left_views": ", ".join(dict.fromkeys(view_title(place) for place in report["unexplained"])),
            "effects": len(report["effects"]),
            "names": ", ".join(dict.fromkeys(title_of(one["name"]) for one in report["effects"])),
            "withheld": len(report["withheld"]),
            "described_axes": axes_of(dict.fromkeys(one["axis"] for one in report["described"])),
        } | {
            key: {
                "before": tables.number(rows.loc[name, "before_value"]),
                "after": tables.number(rows.loc[name, "after_value"]),
                "floor_high": tables.number(rows.loc[name, "floor_high"]),
            }
            | verdicts.distance(*({end: rows.loc[name, f"{state}_{end}"] for end in ENDS} for state in STATES))
            for key, name in (("distribution", "distribution"), ("navigation", "navigation drift"))
        }  # fmt: skip
    return said


with job(snakemake) as (source, params, output):
    reports = dict(zip(params.starts, map(read_json, source.reports), strict=True))
    apart, unnamed = pd.DataFrame(distances(reports)), withheld(reports)
    for figure, path in zip(source.figures, output.figures, strict=True):
        copyfile(figure, path)
    save(output, effects=(effects(reports), effects_page(reports)), places=(places(reports), places_page(reports)),
         withheld=(unnamed, withheld_page(unnamed)), distances=(apart, distances_page(apart)),
         numbers=numbers(reports, apart))  # fmt: skip
