"""Filter every flight with every model that it has."""

from itertools import cycle
from math import radians
from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.model import ErrorModel
from imugap.navigation.attitude import AttitudeAssumptions, InitialAttitude, estimate_attitude
from imugap.workflow.job_log import job

STEP_S = 0.1
"""Step of the stored attitudes."""


def attitude(flown, lift_s, heading, model, assumptions):
    """Return the attitude of the flight proper, from 0 s; up to ``lift_s`` the aircraft rests, then it is launched."""
    rest, ahead = flown[flown.index <= lift_s], flown[flown.index > lift_s]
    return estimate_attitude(ahead, model, InitialAttitude.at_rest(rest, heading), assumptions).table(STEP_S).loc[0:]


with job(snakemake) as (source, params, output):
    assumptions, found = AttitudeAssumptions.from_mapping(**params.assumptions), {}
    models = [yaml.safe_load(Path(path).read_text()) for path in source.models]
    for run, (path, of_run) in enumerate(zip(source.logs, cycle(models), strict=False), start=1):
        flown = log.load(path)
        for minutes, of_length in of_run.items():
            for scheme, mapping in of_length.items():
                model = ErrorModel.from_mapping(mapping)
                key, heading = (run, minutes, scheme), radians(params.heading_deg)
                found[key] = attitude(flown, -params.launch_s, heading, model, assumptions)
    pd.concat(found, names=["run", "minutes", "scheme"]).to_parquet(output[0])
