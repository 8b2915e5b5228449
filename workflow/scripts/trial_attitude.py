"""Filter the motion of every trial with the model of every scheme, without and with a margin for motion."""

from math import radians
from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.effects import GaussMarkov
from imugap.io.references import reference
from imugap.model import ErrorModel
from imugap.navigation.attitude import AttitudeAssumptions, InitialAttitude, estimate_attitude
from imugap.numerics.rotation import to_euler
from imugap.workflow.job_log import job

STEP_S = 0.1
"""Step of the stored attitudes."""


def attitude(table, known, model, margin_s, assumptions):
    """Return the attitude in motion; the heading at rest is the reference's, the tilt is levelled."""
    begin, end = reference.motion(known)
    rest, _ = reference.rests(table, known, margin_s)
    heading = to_euler(reference.rotations(known.loc[rest.index[0] : rest.index[-1]]).mean())[2]
    ahead = table[(table.index > rest.index[-1]) & (table.index <= end)]
    start = InitialAttitude.at_rest(rest, heading)
    return estimate_attitude(ahead, model, start, assumptions).table(STEP_S).loc[begin:]


with job(snakemake) as (source, params, output):
    assumptions = AttitudeAssumptions.from_mapping(**params.assumptions)
    models, found = yaml.safe_load(Path(source.models).read_text()), {}
    extra = GaussMarkov(radians(params.motion_margin["std_deg_per_s"]), params.motion_margin["correlation_time_s"])
    for trial, log_path, reference_path in zip(params.trials, source.logs, source.references, strict=True):
        table, known = log.load(log_path), pd.read_parquet(reference_path)
        for scheme, mapping in models[trial].items():
            rest = ErrorModel.from_mapping(mapping)
            wider = {axis: one + extra if axis in log.GYRO else one for axis, one in rest.axes.items()}
            for model, of_model in {"rest": rest, "margin": ErrorModel(wider)}.items():
                found[trial, model, scheme] = attitude(table, known, of_model, params.margin_s, assumptions)
    pd.concat(found, names=["trial", "model", "scheme"]).to_parquet(output[0])
