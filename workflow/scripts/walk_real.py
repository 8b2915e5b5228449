"""Navigate every walk of a data set by the rules that hold for all of them, and lay it over what cameras saw."""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap import catalogue, integrity, readers
from imugap.footprints import footprints
from imugap.journal import journal
from imugap.walk import walked

STEP_S = 0.1
"""Step of the stored tracks [s]."""


class Files:
    """The raw files of a data set, verified, by run and content."""

    def __init__(self, dataset, paths):
        """Take the paths of all files."""
        self.dataset, self.paths = dataset, {Path(path).name: path for path in paths}
        for file in dataset.files:
            catalogue.verify(file, self.paths[file.name])

    def path(self, run, content=catalogue.LOG):
        """Return the path of the file that holds the content of a run."""
        return self.paths[self.dataset.file(run, content).name]


def against(files, run, solution):
    """Return how a solution lies to what cameras saw, its strides, and these with the marker taken for the device."""
    dataset = files.dataset
    apart = bool(dataset.position_rate_hz)
    path = files.path(run, catalogue.POSITIONS if apart else catalogue.LOG)
    seen = readers.read_positions(path, dataset, run)
    beside, loose = footprints(solution, seen), footprints(solution, seen, stiff=False)
    told = run in dataset.runs_with(catalogue.EVENTS)
    events = readers.read_strides(files.path(run, catalogue.EVENTS), dataset, run) if told else solution.strides()
    return beside, beside.strides(events), loose.strides(events)


def scores(beside, strides, loose):
    """Return what the comparison says, in metres but for the lag [s]."""
    gap, loose = (one["found"] - one["seen"] for one in (strides, loose))
    found, seen = beside.reach()
    horizontal, vertical = beside.rmse()
    end, height = beside.end()
    return {
        "end": end, "height": height, "rmse": horizontal, "rmse_vertical": vertical, "lag": beside.lag,
        "arm": np.linalg.norm(beside.arm), "stride_rmse": np.sqrt(np.mean(gap**2)), "stride_bias": gap.mean(),
        "stride_rmse_plain": np.sqrt(np.mean(loose**2)), "compared": len(gap), "reach": found, "reach_seen": seen,
    }  # fmt: skip


def main(files):
    """Return a row and a track for each walk."""
    rows, tracks = [], []
    for run in files.dataset.runs:
        timing = integrity.report(readers.read_raw_table(files.path(run), files.dataset, run)).timing
        solution = walked(readers.read_raw(files.path(run), files.dataset, run))
        said = solution.summary()
        row = {"dataset": files.dataset.name, "run": run} | said
        row |= {"lost": timing.missing, "repeated": timing.duplicated, "cameras": bool(files.dataset.positions)}
        row |= {"end": said["end_horizontal_m"], "height": said["end_vertical_m"]}
        table = solution.smoothed.trajectory
        track = {name: table[name].to_numpy() for name in ("north", "east", "down")}
        time = table.index.to_numpy()
        if row["cameras"]:
            beside, *strides = against(files, run, solution.smoothed)
            row |= scores(beside, *strides)
            time = beside.time
            track = dict(zip(track, beside.found.T, strict=True))
            track |= {f"{name}_seen": values for name, values in zip(list(track), beside.seen.T, strict=True)}
        every = max(round(STEP_S / np.median(np.diff(time))), 1)
        labels = {"dataset": files.dataset.name, "run": run}
        tracks.append(pd.DataFrame({"time": time} | track)[::every].assign(**labels))
        rows.append(row)
    return pd.DataFrame(rows), pd.concat(tracks)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        dataset = catalogue.load("data", "workflow/schemas")[snakemake.wildcards.dataset]
        table, tracks = main(Files(dataset, snakemake.input.raw))
        table.to_csv(snakemake.output.walks, index=False)
        tracks.to_parquet(snakemake.output.tracks, index=False)
