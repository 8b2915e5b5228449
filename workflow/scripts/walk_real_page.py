"""Lay out the real walks: tracks, errors against cameras, tables, numbers of the text."""

import numpy as np
import pandas as pd

from imugap.analysis.walk import STD
from imugap.figures import pedestrian, style
from imugap.figures.pedestrian import SETS
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

RMSE = {"RMSE": "rmse", "RMSE of height": "rmse_vertical", "RMSE of a stride": "stride_rmse"}
FEET = {1: "left foot", 2: "right foot"}
PEERS = {
    "end_spatial": "end, in space",
    "end_horizontal": "end, horizontal",
    "end_vertical": "end, height",
    "stride_rmse": "length of a stride, RMSE",
    "reach_error": "largest distance from the begin",
}
OWN = {
    "end_spatial": lambda one: np.hypot(one["end"], one["height"]),
    "end_horizontal": lambda one: one["end"],
    "end_vertical": lambda one: one["height"],
    "stride_rmse": lambda one: one["stride_rmse"],
    "reach_error": lambda one: one["reach"] - one["reach_seen"],
}
"""The quantities of the peers, from a row of the walks."""


def name(dataset, run):
    """Return the name of a walk."""
    return f"{SETS.get(dataset, dataset)}, {FEET[run]}" if dataset == "gaitmap_2x20m" else f"{SETS[dataset]} {run}"


def peers_page(walks, peers):
    """Lay out what other programs make of a walk beside what is found here, a row per walk and quantity."""
    own = walks.set_index(["dataset", "run"])
    for (dataset, run, quantity), group in peers.groupby(["dataset", "run", "quantity"], sort=False):
        if (dataset, run) in own.index:
            told = "; ".join(f"{one.program}: {one.value:.3f}" for one in group.itertuples())
            here = tables.fixed(abs(OWN[quantity](own.loc[(dataset, run)])), 3)
            yield {"walk": name(dataset, run), "error [m]": PEERS[quantity], "here": here, "others": told}


def page(walks):
    """Lay the table out: a row per walk, lengths in metres."""
    for one in walks.to_dict("records"):
        spread = tables.number(one["end_horizontal_m" + STD], 2)
        row = {"walk": name(one["dataset"], one["run"]), "time [s]": f"{one['duration_s']:.0f}"}
        row |= {"distance": tables.fixed(one["distance_m"], 1), "strides": int(one["strides"])}
        row |= {"end": f"{tables.fixed(one['end'], 3)} ± {spread}", "of distance [%]": tables.fixed(one["share"], 2)}
        row["height"] = f"{tables.fixed(one['height'], 2)} ± {tables.number(one['end_vertical_m' + STD], 2)}"
        for title, column in RMSE.items():
            row[title] = tables.fixed(one[column], 3) if one["cameras"] else "—"
        row["no floor"] = f"{tables.fixed(one['height_alone'], 2)} ± {tables.number(one['height_alone_std'], 2)}"
        yield row


def sets_page(walks):
    """Lay the short table out: a row per set, median and largest of each error over its walks."""
    for dataset, group in [*walks.groupby("dataset", sort=False), ("all", walks)]:
        seen = group[group["cameras"]]
        distances = [tables.fixed(end(group["distance_m"]), 0) for end in (min, max)]
        yield {
            "walks": SETS.get(dataset, dataset),
            "number": len(group),
            "distance [m]": " to ".join(dict.fromkeys(distances)),
            "end [% of distance]": ends_of(group["share"], 2),
            "height at the end [m]": ends_of(group["height"].abs(), 2),
            "without a floor [m]": ends_of(group["height_alone"].abs(), 2),
            "path against cameras [m]": ends_of(seen["rmse"], 3) if len(seen) else "—",
            "stride [m]": ends_of(seen["stride_rmse"], 3) if len(seen) else "—",
        }


def ends_of(errors, decimals):
    """Return median and largest of errors, as the short table shows them."""
    return " / ".join(tables.fixed(end(errors), decimals) for end in (np.median, max))


def numbers(walks, peers):
    """Collect what the text quotes."""
    of = walks.set_index(["dataset", "run"])
    share, spread = walks["share"], walks["end_horizontal_m" + STD]
    said = {
        "walks": len(walks),
        "closed": int((~walks["cameras"]).sum()),
        "median_percent": tables.number(share.median(), 2),
        "largest_percent": tables.number(share.max(), 2),
        "within_half": int((share < 0.5).sum()),
        "within_one": int((share < 1.0).sum()),
        "rising": int((walks["height_alone"] > 0).sum()),
        "heights_m": {
            key: [tables.fixed(end(walks[key].abs()), 2) for end in (np.median, max)]
            for key in ("height", "height_alone")
        },
        "rmse_of_height_m": {
            key: tables.fixed(walks.loc[walks["cameras"], key].median(), 3)
            for key in ("rmse_vertical", "rmse_vertical_alone")
        },
        "height_within": int((walks["height"].abs() < 2 * walks["end_vertical_m" + STD]).sum()),
        "height_alone_within": int((walks["height_alone"].abs() < 2 * walks["height_alone_std"]).sum()),
        "end_within": int((walks["end"] < 2 * spread).sum()),
    }
    told = peers.set_index(["dataset", "quantity", "run"])["value"]
    if "gaitmap_2x20m" in set(walks["dataset"]):
        own = of.loc["gaitmap_2x20m"]
        said["gaitmap"] = {
            "stride_rmse_m": [tables.fixed(value, 3) for value in own["stride_rmse"]],
            "plain_rmse_m": [tables.fixed(value, 3) for value in own["stride_rmse_plain"]],
            "peer_rmse_m": tables.fixed(told["gaitmap_2x20m", "stride_rmse"].min(), 3),
            "reach_error_m": [tables.fixed(value, 3) for value in own["reach"] - own["reach_seen"]],
            "peer_reach_m": [tables.fixed(told["gaitmap_2x20m", "reach_error", run].min(), 3) for run in (1, 2)],
            "believed_reach_m": [tables.fixed(value, 3) for value in own["reach_believed"]],
            "believed_rmse_m": [tables.fixed(value, 3) for value in own["stride_rmse_believed"]],
            "strike_rank": [tables.fixed(value, 2) for value in own["strike_rank"]],
            "strike_p": [tables.number(value, 2) for value in own["strike_p"]],
            "lag_ms": [tables.fixed(1e3 * value, 1) for value in own["lag"]],
        }
    if "pyshoe_vicon" in set(walks["dataset"]):
        own = of.loc["pyshoe_vicon"]
        said["pyshoe"] = {
            key: [tables.fixed(end(own[key]), 3) for end in (min, np.median, max)] for key in ("rmse", "stride_rmse")
        }
    if "xio_gait_tracking" in set(walks["dataset"]):
        own = of.loc["xio_gait_tracking"]
        said["xio"] = {
            "end_m": [tables.fixed(value, 3) for value in own["end"]],
            "space_m": {
                key: [tables.fixed(value, 3) for value in np.hypot(own["end"], own[key])]
                for key in ("height", "height_alone")
            },
            "peer_space_m": [tables.fixed(told["xio_gait_tracking", "end_spatial", run].min(), 3) for run in (1, 2)],
        }
    return said


with job(snakemake) as (source, _, output):
    walks = pd.concat(map(pd.read_csv, source.walks), ignore_index=True)
    walks["share"] = 100 * walks["end"] / walks["distance_m"]
    tracks, peers = pd.concat(map(pd.read_parquet, source.tracks)), pd.read_csv(source.peers)
    titles = {(one.dataset, one.run): name(one.dataset, one.run).removesuffix(" foot") for one in walks.itertuples()}
    known = {one: SETS[one] for one in walks.loc[walks["cameras"], "dataset"].unique()}
    drawn = pedestrian.against_cameras(tracks, known) if known else style.text_figure("no walk with cameras is here")
    here = peers[peers["dataset"].isin(walks["dataset"])]
    save(
        output,
        walks=pedestrian.walks(tracks, titles),
        errors=drawn,
        table=(walks, page(walks)),
        sets=(walks, sets_page(walks)),
        peers=(here, peers_page(walks, here)),
        numbers=numbers(walks, peers),
    )
