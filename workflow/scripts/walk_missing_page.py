"""Tabulate the errors named on real walks, and the scores of the predicted ends of the other walks."""

import numpy as np
import pandas as pd

from imugap.figures import pedestrian
from imugap.figures.pedestrian import SETS
from imugap.numerics.fitting import block_bootstrap as bootstrap
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.proper_scores import central_rank, energy_score
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

REST, NAMED, SHARED = "at rest", "named", "other sets"
QUANTITIES = {"horizontal": ["north", "east"], "height": ["down"], "space": ["north", "east", "down"]}
LEVELS = (0.5, 0.9)
SHOWN_UNITS = {
    "scale_factor": (100, "%"),
    "misalignment": (1e3, "mrad"),
    "g_sensitivity": (180 / np.pi * 9.80665, "°/s/g"),
    "time_offset": (1e3, "ms"),
    "stance_motion": (1e3, "mm/s"),
}
"""What a size is multiplied by for the page, and the unit there."""


def scored(ends):
    """Yield energy scores [m] of every walk and prediction, and where in it the measured end lies."""
    for (dataset, run), walk in ends.groupby(["dataset", "run"], sort=False):
        came = walk[walk["by"] == "measured"].iloc[0]
        for name, one in walk[walk["by"] != "measured"].groupby("by", sort=False):
            row = {"dataset": dataset, "run": run, "by": name}
            for quantity, columns in QUANTITIES.items():
                draws, truth = one[columns].to_numpy(), came[columns].to_numpy(float)
                row[f"score_{quantity}"] = energy_score(draws, truth)
                row[f"place_{quantity}"] = central_rank(draws, truth)
            yield row


def compared(scores, seed):
    """Yield means of the scores and their differences to those of the device at rest, with intervals over walks."""
    for name in scores["by"].unique():
        row = {"by": name, "walks": int((scores["by"] == name).sum())}
        for quantity in QUANTITIES:
            wide = scores.pivot(index=["dataset", "run"], columns="by", values=f"score_{quantity}")
            row[quantity], differences = wide[name].mean(), (wide[name] - wide[REST]).to_numpy()
            difference = bootstrap.mean(differences, stream(seed, "foretold", name, quantity), block=1)
            row |= {
                f"{quantity}_gap": difference.value,
                f"{quantity}_low": difference.low,
                f"{quantity}_high": difference.high,
            }
            inside = scores.loc[scores["by"] == name, f"place_{quantity}"]
            row |= {f"{quantity}_{level:g}": int((inside < level).sum()) for level in LEVELS}
        yield row


def size(one):
    """Return the size of what is named with its interval, in the unit of the page."""
    factor, unit = SHOWN_UNITS[one["name"]]
    return f"{tables.interval(*(factor * one[key] for key in ('value', 'low', 'high')))} {unit}"


def found_page(found):
    """Lay out what is named: a row for each half of a set."""
    for (dataset, asked), group in found[found["by"] == NAMED].groupby(["dataset", "asked"], sort=False):
        first, *others = group.to_dict("records")
        row = {"asked": f"{SETS[dataset]} {', '.join(str(asked).split())}"}
        if first["named"]:
            row |= {"named": said(first), "size": size(first)}
            row |= {"not distinguished from": "; ".join(f"{said(one)} ({size(one)})" for one in others) or "—"}
        else:
            row |= {"named": "nothing", "size": "—", "not distinguished from": f"most significant: {said(first)}"}
        yield row | {"chance": tables.number(first["p_value"], 2)}


def said(one):
    """Return name and axis of a suspect as text."""
    return one["suspect"].replace("_", " ")


def scores_page(data):
    """Lay out the scores: a row for each prediction, in centimetres."""
    for one in data.to_dict("records"):
        row = {"predicted from": one["by"]}
        for quantity in QUANTITIES:
            row[f"{quantity} [cm]"] = tables.fixed(100 * one[quantity], 1)
            difference = (100 * one[f"{quantity}_{key}"] for key in ("gap", "low", "high"))
            row[f"{quantity}, against at rest"] = "—" if one["by"] == REST else tables.interval(*difference)
        for quantity in ("horizontal", "height"):
            inside = " / ".join(str(one[f"{quantity}_{level:g}"]) for level in LEVELS)
            row[f"{quantity}: in the middle 50 / 90 %"] = f"{inside} of {one['walks']}"
        yield row


def numbers(found, scores, data, seed):
    """Collect what the text quotes."""
    own, shared = (found[found["by"] == name] for name in (NAMED, SHARED))
    halves = own.groupby(["dataset", "asked"], sort=False)["named"].first()
    difference, beyond = {}, {}
    for one in data.to_dict("records"):
        values = {name: [one[f"{name}_{key}"] for key in ("gap", "low", "high")] for name in QUANTITIES}
        difference[one["by"]] = {name: verdict(value) for name, value in values.items()}
        beyond[one["by"]] = {name: one["walks"] - one[f"{name}_0.9"] for name in QUANTITIES}
    with_name = own.loc[own["named"], "dataset"].unique()
    wide = scores[named_for(scores, own)].pivot(index=["dataset", "run"], columns="by", values="score_space")
    differences = (wide[NAMED] - wide[REST]).to_numpy() if len(wide) else np.empty(0)
    there = bootstrap.mean(differences, stream(seed, "foretold", "there"), block=1) if len(wide) else None
    sinking = 1e3 * shared.loc[shared["named"], "value"]
    return {
        "walks": int((scores["by"] == REST).sum()),
        "asked": len(halves),
        "silent": int((~halves).sum()),
        "silent_sets": [SETS[name] for name in own["dataset"].unique() if name not in with_name],
        "sets": {SETS[name]: of_set(own[own["dataset"] == name]) for name in with_name},
        "shared": {
            "asked": len(shared),
            "named": len(sinking),
            "mm_per_s": [tables.number(end(sinking), 2) for end in (min, max)] if len(sinking) else [],
        },
        "gap_cm": difference,
        "beyond": beyond,
        "there": {"walks": len(wide)} | (verdict([there.value, there.low, there.high]) if there else {}),
    }


def named_for(scores, own):
    """Tell of which walks, shape (n,), other walks of the device named something."""
    told = np.zeros(len(scores), bool)
    for one in own[own["named"]].drop_duplicates(["dataset", "asked"]).itertuples():
        asked = [int(run) for run in str(one.asked).split()]
        told |= ((scores["dataset"] == one.dataset) & (scores["run"] % 2 != asked[0] % 2)).to_numpy()
    return told


def of_set(rows):
    """Collect what the halves of a set name, and what is among the names of all of them."""
    groups = [group[group["named"]] for _, group in rows.groupby("asked", sort=False)]
    firsts = [group.iloc[0] for group in groups if len(group)]
    common = set.intersection(*(set(group["suspect"]) for group in groups))
    shared = [one for one in rows["suspect"].unique() if one in common] if len(groups) > 1 else []
    return {
        "named": [f"{said(one)}, {size(one)} (walks {', '.join(str(one['asked']).split())})" for one in firsts],
        "silent": len(groups) - len(firsts),
        "common": [name.replace("_", " ") for name in shared],
        "halves": len(groups),
        "alone": all(len(group) == 1 for group in groups if len(group)),
    }


def verdict(values):
    """Return a difference with its interval [cm], and what it says."""
    return {"value": tables.interval(*(100 * one for one in values)), "verdict": verdicts.difference(tuple(values[1:]))}


with job(snakemake) as (source, params, output):
    found, ends = pd.read_csv(source.found), pd.read_parquet(source.ends)
    scores = pd.DataFrame(scored(ends))
    data = pd.DataFrame(compared(scores, params.seed))
    order = ends[["dataset", "run"]].drop_duplicates().sort_values(["dataset", "run"])
    titles = {(one.dataset, one.run): f"{SETS[one.dataset]} {one.run}" for one in order.itertuples()}
    save(output, figure=pedestrian.predictions(ends, titles, scores), found=(found, found_page(found)),
         scores=(data, scores_page(data)), numbers=numbers(found, scores, data, params.seed))  # fmt: skip
