"""Draw the measured drift and its distance from the simulated drifts of one run."""

import numpy as np

from imugap.figures import static
from imugap.kinematics.free_inertial import QUANTITIES, STARTS, differences
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    measured = np.load(source.measured)
    shown = measured["time"] <= params.length_s
    time, drift = measured["time"][shown], measured["drift"][:, :, shown]
    save(output, drift=static.drift(time, dict(zip(STARTS, drift, strict=True))))
    ensembles = {
        name: np.load(path)["drift"][:, :, shown]
        for name, path in zip(params.contenders, source.simulated, strict=True)
    }
    columns = list(QUANTITIES.values())
    for k, start in enumerate(STARTS):
        deviations = {name: differences(drift[k, :1][..., columns], one[k])[0] for name, one in ensembles.items()}
        save(output, **{start: static.differences(time, deviations, params.drawn)})
