"""Navigate the trials of PyShoe with one setting after the other, and score them by the published protocol."""

from dataclasses import replace

import numpy as np
import pandas as pd

from imugap.analysis.walk import INDOORS
from imugap.integrity.timestamps import filled
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.io.catalogue.datasets import RawFiles
from imugap.navigation.walk import pedestrian
from imugap.simulation.camera_track import compare_with_cameras
from imugap.study.walk import walk_protocol, walk_settings
from imugap.workflow.job_log import job
from imugap.workflow.products import save

USUAL = replace(INDOORS, heading_free=True)
"""One setting for all trials: that of the program, which accepts a trial without a stand."""
HOW = {"filter": False, "smoother": True}
PLANE = ["north", "east"]


def trials(sets, paths, number):
    """Return data set, run and path of so many trials, evenly spread over the order of time."""
    found = sorted(((files, run) for files in map(RawFiles, sets, paths) for run in files.dataset.runs),
                   key=lambda one: one[0].path(one[1]).name)  # fmt: skip
    return [found[at] for at in np.unique(np.linspace(0, len(found) - 1, number).round().astype(int))]


def scores(files, run, factors):
    """Yield the errors of a trial with each setting, by the filter and by the smoother."""
    name, log = files.path(run).stem, filled(readers.read_raw(files.path(run), files.dataset, run))
    seen = readers.positions_of(files, run)
    track = seen[PLANE].reindex(log.index, method="nearest", tolerance=1e-6).to_numpy()
    for setting in walk_settings.around(USUAL, factors):
        aligned = pedestrian.align(log, setting.model, setting.assumptions)
        for how, smooth in HOW.items():
            solution = pedestrian.solve(aligned, smooth)
            found = solution.trajectory[PLANE].to_numpy()
            row = {"trial": name, "varied": setting.varied, "factor": setting.factor, "how": how}
            row |= {"error": walk_protocol.armse(found, track), "distance": walk_protocol.distance_rms(found, track)}
            yield row | (consistency(solution, seen) if setting.varied == "usual" and smooth else {})


def consistency(solution, seen):
    """Return the normalised squares of the error at the end, horizontal (two degrees of freedom) and vertical."""
    off = compare_with_cameras(solution, seen).off
    return {
        "nees": off[:2] @ np.linalg.solve(solution.horizontal[-1], off[:2]),
        "vertical_nees": (off[2] / solution.trajectory_std["down"].iloc[-1]) ** 2,
        "still": solution.stand.still,
    }


with job(snakemake) as (source, params, output):
    known = catalogue.load("data", "workflow/schemas")
    sets = [known[name] for name in params.sets]
    chosen = trials(sets, [source[name] for name in params.sets], params.trials)
    rows = [row for files, run in chosen for row in scores(files, run, params.factors)]
    save(output, scores=pd.DataFrame(rows))
