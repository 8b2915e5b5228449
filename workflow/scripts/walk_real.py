"""Navigate every walk of a data set with the same settings, and compare it with the camera track."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import spearmanr

from imugap.analysis.walk import DEFAULT_MODEL, INDOORS, WalkInputs, navigate_walk
from imugap.integrity import report as integrity
from imugap.integrity.timestamps import filled
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.io.catalogue.datasets import RawFiles
from imugap.log import ACCEL
from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
from imugap.simulation.camera_track import compare_with_cameras
from imugap.simulation.matched_walk import matched_walk
from imugap.simulation.walk import Walk
from imugap.workflow.job_log import job
from imugap.workflow.products import save

STEP_S = 0.1
"""Step of the stored tracks [s]."""


def against(files, run, solution):
    """Return how a solution lies to what cameras saw, its strides, and these with the marker taken for the device."""
    dataset = files.dataset
    seen = readers.positions_of(files, run)
    beside, loose = compare_with_cameras(solution, seen), compare_with_cameras(solution, seen, stiff=False)
    told = run in dataset.runs_with(catalogue.EVENTS)
    events = readers.read_strides(files.path(run, catalogue.EVENTS), dataset, run) if told else solution.strides()
    return beside, beside.strides(events), loose.strides(events)


def scores(beside, strides, loose):
    """Return what the comparison says, in metres but for the lag [s]."""
    error, loose = (one["found"] - one["seen"] for one in (strides, loose))
    found, seen = beside.reach()
    horizontal, vertical = beside.rmse()
    end, height = beside.end()
    return {
        "end": end, "height": height, "rmse": horizontal, "rmse_vertical": vertical, "lag": beside.lag,
        "arm": np.linalg.norm(beside.arm), "stride_rmse": np.sqrt(np.mean(error**2)), "stride_bias": error.mean(),
        "stride_rmse_plain": np.sqrt(np.mean(loose**2)), "compared": len(error), "reach": found, "reach_seen": seen,
    }  # fmt: skip


def recipe(walk):
    """Return what a matched_walk has of its own, as plain data."""
    return {"rate_hz": walk.rate_hz, "gait": asdict(walk.gait), "course": asdict(walk.course)}


def heights(files, run, solution):
    """Return the height of the end [m] and the root mean square error of it [m], against cameras where these are."""
    if not files.dataset.positions:
        return -solution.trajectory["down"].iloc[-1], np.nan
    beside, *_ = against(files, run, solution)
    return beside.end()[1], beside.rmse()[1]


def believed(files, run, log):
    """Return what comes of believing samples near the full scale, and how strides go with the force of their strike."""
    beside, strides, _ = against(files, run, navigate_walk(WalkInputs(log)).smoothed)
    found, seen = beside.reach()
    error = strides["found"] - strides["seen"]
    force = log[list(ACCEL)].abs().max(axis=1)
    rank = spearmanr([force.loc[one.start : one.end].max() for one in strides.itertuples()], error)
    return {
        "reach_believed": found - seen, "stride_rmse_believed": np.sqrt(np.mean(error**2)),
        "strike_rank": rank.statistic, "strike_p": rank.pvalue,
    }  # fmt: skip


def one(files, run, like):
    """Return the row and the track of a walk, and the recipe of its matched walk."""
    timing = integrity.report(readers.read_raw_table(files.path(run), files.dataset, run)).timing
    log = readers.read_raw(files.path(run), files.dataset, run)
    full_scale = files.dataset.full_scale
    found = navigate_walk(WalkInputs(log, DEFAULT_MODEL, replace(INDOORS, full_scale=full_scale)))
    floorless = navigate(filled(log), DEFAULT_MODEL, WalkAssumptions(full_scale=full_scale), smooth=True)
    said, solution, labels = found.summary(), found.smoothed, {"dataset": files.dataset.name, "run": run}
    row = labels | said | {"lost": timing.missing, "repeated": timing.duplicated}
    table = solution.trajectory[["north", "east", "down"]]
    if files.dataset.positions:
        beside, *strides = against(files, run, solution)
        row |= {"cameras": True} | scores(beside, *strides)
        row |= believed(files, run, log) if np.isfinite(full_scale) else {}
        off = beside.off[:2]
        track = pd.DataFrame(np.hstack([beside.found, beside.seen]), columns=[*table, *table.add_suffix("_seen")])
        track.insert(0, "time", beside.time)
    else:
        row |= {"cameras": False, "end": said["end_horizontal_m"], "height": said["end_vertical_m"]}
        off = table[["north", "east"]].iloc[-1].to_numpy()
        track = table.reset_index(names="time")
    row["height_alone"], row["rmse_vertical_alone"] = heights(files, run, floorless)
    row["height_alone_std"] = floorless.trajectory_std["down"].iloc[-1]
    row["nees"] = off @ np.linalg.solve(solution.horizontal[-1], off)
    every = max(round(STEP_S / np.median(np.diff(track["time"]))), 1)
    return row, track[::every].assign(**labels), recipe(matched_walk(solution, like))


with job(snakemake) as (source, _, output):
    dataset, like = catalogue.load("data", "workflow/schemas")[snakemake.wildcards.dataset], Walk.read(source.recipe)
    files = RawFiles(dataset, source.raw)
    rows, tracks, twins = zip(*(one(files, run, like) for run in dataset.runs), strict=True)
    save(output, walks=pd.DataFrame(rows), tracks=pd.concat(tracks))
    Path(output.twins).write_text(json.dumps(dict(zip(dataset.runs, twins, strict=True))) + "\n")
