"""Evaluate the recorded drive: model of the rest, tuned model, outages, schemes of quality control."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.io import gnss
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import public_drives
from imugap.simulation.gnss_faults import Faults
from imugap.study.drive import recorded_drive
from imugap.workflow.job_log import job
from imugap.workflow.products import save

NAME = "rtklibexplorer_drive"


def outages(tests, receiver, params):
    """Return the drifts of every test, with its model, in outages one after the other, for every draw of the noise."""
    rows = []
    first, last, length = params.outages_s
    for draw in range(params.seeds):
        fixes = receiver.degrade(tests["rest"][0].recording.fixes, params.seed, draw)
        for begin in np.arange(first, last, length + 1):
            for name, (test, model) in tests.items():
                drift = test.outage(fixes, model, begin, length).reset_index()
                rows.append(drift.assign(model=name, draw=draw, begin=begin))
    return pd.concat(rows)


def contaminated(test, receiver, faults, model, params):
    """Return the scores of every scheme for every draw of noise and gross errors, and the errors of the first."""
    scores, shown = [], None
    ellipsoid = gnss.origin(test.recording.fixes)
    for draw in range(params.seeds):
        fixes = receiver.degrade(test.recording.fixes, params.seed, draw)
        events = faults.draw(fixes.index.to_numpy(), params.seed, "car", draw)
        spoilt = faults.apply(fixes, events, ellipsoid, params.seed, "car", draw)
        found, errors = test.schemes(fixes, spoilt, events, model)
        scores.append(found.assign(draw=draw))
        if shown is None:
            place = gnss.local(spoilt, ellipsoid)[:, :2]
            seen = pd.DataFrame(place, index=spoilt.index, columns=["north", "east"]).assign(scheme="fixes")
            tracks = [one.assign(scheme=name) for name, one in errors.items()]
            truth = pd.DataFrame(gnss.local(test.recording.fixes, ellipsoid)[:, :2], index=test.recording.fixes.index,
                                 columns=["north", "east"]).assign(scheme="truth")  # fmt: skip
            shown = pd.concat([seen, truth, *tracks]).reset_index()
    return pd.concat(scores), shown


with job(snakemake) as (source, params, output):
    dataset = catalogue.load("data", "workflow/schemas")[NAME]
    for file in dataset.files:
        catalogue.verify(file, source[file.content])
    recording = public_drives.read_car(source.log, source.clock, source.fixes, dataset)
    receiver = recorded_drive.StandardReceiver.read(source.recipe, "car")
    test = recorded_drive.car(recording, receiver)
    rest = recorded_drive.model_from_rest(recording.log, params.rest_s)
    tuned, way = test.tune(receiver.degrade(recording.fixes, params.seed, "tuning"), rest)
    models = {"rest": rest, "tuned": tuned}
    Path(output.models).write_text(yaml.safe_dump({name: one.to_mapping() for name, one in models.items()}))
    tests = {name: (test, model) for name, model in models.items()} | {"wheels": (test.rolling, tuned)}
    scores, shown = contaminated(test, receiver, Faults.read(source.recipe), tuned, params)
    save(output, tuning=way, outages=outages(tests, receiver, params), schemes=scores, errors=shown)
