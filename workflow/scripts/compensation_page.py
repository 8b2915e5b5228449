"""Lay out what compensation is worth on the simulated walk: figures, tables beside the printed ones, the verdict."""

import numpy as np
import pandas as pd

from imugap.figures import pedestrian
from imugap.simulation.walk import Walk
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.static import he2023
from imugap.study.walk.end_consistency import SQUARES, in_ellipse, interval_columns, mean_row
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

QUANTITIES = {"position": ("position error at the end", "m"), "heading": ("heading error at the end", "°")}
ROWS = {"position": "end_position_error", "heading": "end_heading_error"}
"""Rows of the printed table."""
PANELS = ("none", "stand", "bias_only", "method_a", "method_b", "restoration")
SUBTRACTED, INSIDE = "subtracted ahead of the navigator", "inside the filter"
ELLIPSE = 0.9
"""Probability of the ellipse whose share of ends is told."""


def printed(path):
    """Return the printed errors by quantity and contender, and their reductions [%]."""
    values = pd.read_csv(path).set_index("quantity").rename(columns={"uncompensated": "none"})
    errors = {quantity: values.loc[row, ["none", *he2023.METHODS]].to_dict() for quantity, row in ROWS.items()}
    gains = {quantity: values.loc[f"{row}_reduction", list(he2023.METHODS)].to_dict() for quantity, row in ROWS.items()}
    return errors, gains


def five(ends):
    """Return mean and spread of the trials on the first device, and the reduction against none."""
    groups = ends[ends["device"] == 0].groupby("contender", sort=False)
    found = {}
    for quantity in QUANTITIES:
        mean = groups[quantity].mean()
        found |= {quantity: mean, f"{quantity}_std": groups[quantity].std(ddof=1)}
        found[f"{quantity}_reduction"] = 100 * (1 - mean / mean["none"])
    return pd.DataFrame(found)


def over_devices(ends, seed):
    """Return mean errors over the devices, and their excess over bias only, with 95 % intervals."""
    first = ends[ends["trial"] == 0].pivot(index="device", columns="contender")
    rows = []
    for name in ends["contender"].unique():
        row = {"contender": name}
        for quantity in QUANTITIES:
            errors = first[quantity]
            for what, values in ("mean", errors[name]), ("excess", errors[name] - errors["bias_only"]):
                rng = stream(seed, "walks", name, quantity, what)
                row |= mean_row(f"{quantity}_{what}", values.to_numpy(), rng)
        rows.append(row)
    return pd.DataFrame(rows).set_index("contender")


def page(trials, devices, errors, gains):
    """Lay the table out: a row per compensation."""
    for name in trials.index:
        one, row = trials.loc[name], {"compensation": pedestrian.TITLES[name]}
        for quantity, (_, unit) in QUANTITIES.items():
            spread = one[f"{quantity}_std"]
            value = tables.number(one[quantity]) + (f" ± {tables.number(spread, 2)}" if spread > 1e-9 else "")
            row[f"{quantity}, {unit}"] = value
            row[f"{quantity}, less [%]"] = "—" if name == "none" else tables.fixed(one[f"{quantity}_reduction"], 1)
            gain = f" ({tables.fixed(gains[quantity][name], 1)} %)" if name in gains[quantity] else ""
            known = name in errors[quantity]
            row[f"{quantity}, printed"] = f"{errors[quantity][name]:g}{gain}" if known else "—"
            row[f"{quantity}, devices [{unit}]"] = tables.interval(
                *devices.loc[name, interval_columns(f"{quantity}_mean")]
            )
        yield row


def inside_of(ends, seed):
    """Yield what each model is worth inside the filter: mean errors, and what the filter believes of them."""
    for name, one in ends.groupby("contender", sort=False):
        row = {"contender": name}
        degrees = dict.fromkeys(QUANTITIES, 1) | {square: degree for square, (_, degree) in SQUARES.items()}
        for key, degree in degrees.items():
            row |= mean_row(key, one[key].to_numpy() / degree, stream(seed, "inside", name, key))
        yield row | {"inside": in_ellipse(one["nees"], ELLIPSE).mean()}


def inside_page(data):
    """Lay the table out: a row per model."""
    for one in data.to_dict("records"):
        row = {"model in the filter": pedestrian.TITLES[one["contender"]]}
        for quantity, (_, unit) in QUANTITIES.items():
            row[f"{quantity} [{unit}]"] = tables.interval(*(one[key] for key in interval_columns(quantity)))
        for square, (title, _) in SQUARES.items():
            row[title] = tables.interval(*(one[key] for key in interval_columns(square)))
        yield row | {f"ends in the {ELLIPSE:.0%} ellipse": f"{100 * one['inside']:.0f} %"}


def numbers(trials, devices, inside, walk, table3):
    """Collect what the text quotes."""
    difference = {
        quantity: {
            name: {
                "value": tables.interval(*devices.loc[name, interval_columns(f"{quantity}_excess")]),
                "verdict": verdicts.difference(tuple(devices.loc[name, interval_columns(f"{quantity}_excess")[1:]])),
            }
            for name in devices.index
            if name != "bias_only"
        }
        for quantity in QUANTITIES
    }
    known, held = trials.apply(lambda one: one.map(tables.number)), inside.set_index("contender")
    mean = {
        name: {quantity: tables.number(devices.loc[name, f"{quantity}_mean"], 2) for quantity in QUANTITIES}
        for name in devices.index
    }
    filtered = {
        name: {key: tables.number(held.loc[name, key], 2) for key in QUANTITIES}
        | {key: tables.interval(*held.loc[name, interval_columns(key)]) for key in SQUARES}
        | {f"{key}_verdict": verdicts.consistency(tuple(held.loc[name, interval_columns(key)[1:]])) for key in SQUARES}
        for name in held.index
    }
    return {
        "duration_s": f"{walk.duration_s:.0f}",
        "length_m": f"{sum(leg.share for leg in walk.course.strides()) * walk.gait.length_m:.0f}",
        "strides": sum(1 for _ in walk.course.strides()),
        "rate_hz": walk.rate_hz,
        "gap": difference,
        "five": known.to_dict("index"),
        "mean": mean,
        "inside": filtered,
        "printed": {quantity: {"none": table3[quantity]["none"], "restoration": table3[quantity]["restoration"]}
                    for quantity in QUANTITIES},
    }  # fmt: skip


with job(snakemake) as (source, params, output):
    ends, held = (
        one.assign(heading=np.degrees(one["heading"])) for one in map(pd.read_parquet, (source.ends, source.inside))
    )
    ends["contender"] = pd.Categorical(ends["contender"], [name for name in pedestrian.TITLES if name != "truth"])
    ends = ends.sort_values(["contender", "device", "trial"]).astype({"contender": str})
    walk, (errors, gains) = Walk.read(source.recipe), printed(source.printed)
    titles = {name: pedestrian.TITLES[name] for name in PANELS}
    both = pd.concat([ends[ends["trial"] == 0].assign(use=SUBTRACTED), held.assign(use=INSIDE)])
    trials, devices, inside = five(ends), over_devices(ends, params.seed), pd.DataFrame(inside_of(held, params.seed))
    save(
        output,
        tracks=pedestrian.tracks(pd.read_parquet(source.tracks), walk.truth(0, params.seed), titles),
        ends=pedestrian.ends(both, errors, QUANTITIES),
        table=(trials.join(devices).reset_index(), page(trials, devices, errors, gains)),
        inside=(inside, inside_page(inside)),
        numbers=numbers(trials, devices, inside, walk, errors),
    )
