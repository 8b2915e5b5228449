"""Navigate every walk of a data set with other thresholds, detectors, assumptions, and delays between the triads."""

from dataclasses import replace

import numpy as np
import pandas as pd

from imugap.filters.zero_velocity import Statistic
from imugap.integrity.timestamps import filled
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.io.catalogue.datasets import RawFiles
from imugap.log import ACCEL
from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
from imugap.simulation.camera_track import compare_with_cameras
from imugap.study.walk.walk_settings import WalkSetting, noise, threshold, velocity
from imugap.workflow.job_log import job
from imugap.workflow.products import save

USUAL_CHOICE = WalkAssumptions()
DETECTOR = USUAL_CHOICE.detector


def delayed(log, delay):
    """Return the log with the accelerometers later by a delay [s]."""
    time = log.index.to_numpy()
    return log.assign(**{axis: np.interp(time - delay, time, log[axis]) for axis in ACCEL})


def ends(solution, seen):
    """Return the errors of the end, against the begin or cameras: horizontal and height [m]."""
    if seen is not None:
        return compare_with_cameras(solution, seen).end()
    end = solution.trajectory.iloc[-1]
    return float(np.hypot(end["north"], end["east"])), -float(end["down"])


def choices(params):
    """Yield the settings, and the delay of the accelerometers with each [s]."""
    for factor in params.factors:
        yield threshold(USUAL_CHOICE, factor), 0.0
    for statistic in Statistic:
        other = replace(USUAL_CHOICE, detector=replace(DETECTOR, statistic=statistic))
        yield WalkSetting("detector", statistic, other), 0.0
    for factor in params.doubts:
        yield velocity(USUAL_CHOICE, factor), 0.0
        yield noise(USUAL_CHOICE, factor), 0.0
    for delay in params.delays_ms:
        yield WalkSetting("delay", delay, USUAL_CHOICE), 1e-3 * delay


def main(files, params):
    """Return the end errors of every walk under every choice."""
    rows, dataset = [], files.dataset
    for run in dataset.runs:
        log, seen = filled(readers.read_raw(files.path(run), dataset, run)), None
        if dataset.positions:
            seen = readers.positions_of(files, run)
        for one, delay in choices(params):
            solution = navigate(delayed(log, delay) if delay else log, one.model, one.assumptions)
            end, height = ends(solution, seen)
            row = {"dataset": dataset.name, "run": run, "varied": one.varied, "value": float(one.factor), "end": end}
            row |= {"height": height, "nis": np.nansum(solution.nis)}
            rows.append(row | {"distance": solution.strides()["length"].sum()})
    return pd.DataFrame(rows)


with job(snakemake) as (source, params, output):
    dataset = catalogue.load("data", "workflow/schemas")[snakemake.wildcards.dataset]
    save(output, choices=main(RawFiles(dataset, source.raw), params))
