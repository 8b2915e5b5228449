"""Evaluate the recorded flight: attitude against the onboard filter, outages against its own fixes."""

import numpy as np
import pandas as pd

from imugap.figures import recorded_drive
from imugap.filters.consistency import nees_band
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import public_drives
from imugap.kinematics.strapdown import ATTITUDE
from imugap.study.drive import recorded_drive as roadtest
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

NAME = "thor_flight75"
IN_THE_AIR_S = (230.0, 560.0)


def apart(solution, aboard):
    """Return how far roll, pitch and heading are from those of the filter aboard, in the air [rad]."""
    mine = solution.trajectory.loc[slice(*IN_THE_AIR_S), list(ATTITUDE)]
    theirs = [np.interp(mine.index, aboard.index, np.unwrap(aboard[name])) for name in ATTITUDE]
    return np.angle(np.exp(1j * (mine - np.column_stack(theirs))))


def numbers(solution, errors, drift, way):
    """Collect what the text quotes."""
    record, nees = solution.record, drift["nees"]
    low, high = nees_band(2, len(nees))
    std = np.degrees(solution.trajectory_std.loc[slice(*IN_THE_AIR_S), list(ATTITUDE)].mean())
    return {
        "angles": {
            name: {"mean": tables.number(np.degrees(error.mean()), 2), "std": tables.number(np.degrees(error.std()), 2),
                   "told": tables.number(std[name], 2)}
            for name, error in zip(ATTITUDE, errors.T, strict=True)
        },
        "nis": tables.number(record.statistic.sum() / record.freedom.sum(), 2),
        "factors": {name: tables.number(way.iloc[-1][name], 2) for name in roadtest.TUNED},
        "outages": len(nees), "rms_m": tables.number(np.sqrt((drift["horizontal"] ** 2).mean()), 2),
        "predicted_m": tables.number(np.sqrt((drift["predicted"] ** 2).mean()), 2),
        "nees": tables.number(nees.mean(), 2), "low": tables.number(low, 2), "high": tables.number(high, 2),
        "consistent": bool(low < nees.mean() < high),
    }  # fmt: skip


with job(snakemake) as (source, params, output):
    catalogue.verify(catalogue.load("data", "workflow/schemas")[NAME].file(1), source.log)
    recording = public_drives.read_flight(source.log)
    test = roadtest.aircraft(recording, roadtest.StandardReceiver.read(source.recipe, "flight"))
    model, way = test.tune(recording.fixes, roadtest.model_from_rest(recording.log, params.rest_s))
    solution = test.navigate(recording.fixes, model)
    first, last, length = params.outages_s
    begins = np.arange(first, last, length + 1)
    drift = pd.DataFrame([test.outage(recording.fixes, model, begin, length).iloc[-1] for begin in begins])
    found = numbers(solution, apart(solution, recording.aboard), drift, way)
    save(output, figure=recorded_drive.attitude(solution, recording.aboard), numbers=found)
