"""Simulate every contender at rest and navigate every trial."""

import numpy as np

from imugap.kinematics.free_inertial import QUANTITIES, StaticNavigation
from imugap.model import ErrorModel
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    like, columns = np.load(source.measured), list(QUANTITIES.values())
    plan = StaticNavigation.from_mapping(params.site, params.course, float(like["time"][-1]))
    ideal = plan.ideal(float(like["interval"]))
    for contender, path, to in zip(params.contenders, source.models, output, strict=True):
        model = ErrorModel.read(path)
        trials = (model.simulate(ideal, params.seed, "drift", contender, trial) for trial in range(params.trials))
        drifts = np.stack([plan.drift(trial)[..., columns] for trial in trials], axis=1)  # starts, trials, epochs, ...
        np.savez(to, time=plan.epochs(), drift=drifts)
