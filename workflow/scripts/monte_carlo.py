"""Simulate the source's device many times and estimate its parameters by every method."""

import pandas as pd

from imugap.estimation.gmwm import estimator
from imugap.estimation.methods import METHODS
from imugap.study.static.experiment import Experiment
from imugap.study.static.monte_carlo import row
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def estimates(experiment, time, seed, runs, printed):
    """Return the estimates of all runs by all methods, of the first ones by simulated wavelet variances as well."""
    found = []
    for run in range(runs):
        sequence = experiment.simulate(seed, "monte carlo", time, run)
        for name, method in METHODS.items():
            fit = method(sequence, experiment.interval, experiment.kinds)
            found.append(row(fit, method=name, run=run, time=time))
        if run < printed:
            fit = estimator.fit_by_simulation(sequence, experiment.interval, experiment.kinds, seed)
            found.append(row(fit, method="indirect_simulated", run=run, time=time))
    return pd.concat(found, ignore_index=True)


with job(snakemake) as (source, params, output):
    time = int(snakemake.wildcards.time)
    experiment = Experiment.read(source.recipe).at(time)
    save(output, estimates=estimates(experiment, time, params.seed, params.runs, params.printed))
