"""Navigate the logs of a simulated walk with a filter that holds states and densities of each model."""

from dataclasses import asdict
from pathlib import Path

import pandas as pd
import yaml

from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import navigate
from imugap.simulation.walk import Walk
from imugap.study.walk.walk_compensation import End, filter_model, known_assumptions
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    walk, mappings = Walk.read(source.recipe), yaml.safe_load(Path(source.models).read_text())
    models = {name: ErrorModel.from_mapping(one) for name, one in mappings.items() if name != "bias_only"}
    truth, ideal, assumptions = walk.truth(0, params.seed), walk.ideal(0, params.seed), known_assumptions(walk)
    rows = []
    for device in range(params.devices):
        log = walk.model.simulate(ideal, params.seed, "walk", device)
        for name, model in models.items():
            found = navigate(log, filter_model(model), assumptions)
            rows.append({"contender": name, "device": device} | asdict(End.of(found, truth)))
    save(output, ends=pd.DataFrame(rows))
