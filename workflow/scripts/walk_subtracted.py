"""Subtract what models simulate from the log of a simulated walk, and navigate it with a filter that has no model."""

from dataclasses import asdict
from pathlib import Path

import pandas as pd
import yaml

from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import navigate
from imugap.simulation.walk import Walk
from imugap.study.walk.walk_compensation import End, known_assumptions, stand_biases, subtracted, white_noise_model
from imugap.workflow.job_log import job
from imugap.workflow.products import save

STEP_S = 0.5
"""Step of the stored tracks."""


with job(snakemake) as (source, params, output):
    walk, mappings = Walk.read(source.recipe), yaml.safe_load(Path(source.models).read_text())
    models = {name: ErrorModel.from_mapping(one) for name, one in mappings.items() if name != "truth"}
    white = white_noise_model(pd.read_csv(source.indices).set_index(["symbol", "axis"])["value"]["N"])
    truth, ideal, assumptions = walk.truth(0, params.seed), walk.ideal(0, params.seed), known_assumptions(walk)
    rows, tracks = [], []
    for device in range(params.devices):
        log = walk.model.simulate(ideal, params.seed, "walk", device)
        for name, model in (models | {"none": ErrorModel({}), "stand": stand_biases(log)}).items():
            for trial in range(params.printed if device == 0 else 1):
                left = subtracted(log, model, params.seed, "compensation", name, device, trial)
                found = navigate(left, white, assumptions)
                labels = {"contender": name, "device": device, "trial": trial}
                rows.append(labels | asdict(End.of(found, truth)))
                if device == 0:
                    every = round(STEP_S * walk.rate_hz)
                    tracks.append(found.trajectory[["north", "east", "heading"]][::every].assign(**labels))
    save(output, ends=pd.DataFrame(rows))
    pd.concat(tracks).to_parquet(output.tracks)
