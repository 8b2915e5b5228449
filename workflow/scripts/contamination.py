"""Estimate from logs with gross outliers, by plain and by robust wavelet variances and by likelihood."""

from functools import partial

import numpy as np
import pandas as pd

from imugap.estimation.cramer_rao import bound
from imugap.estimation.gmwm import estimator
from imugap.estimation.gmwm.estimator import GmwmOptions
from imugap.estimation.methods import METHODS
from imugap.estimation.variances.wavelet_variance import EFFICIENCY
from imugap.figures import estimation
from imugap.stream import stream
from imugap.study.static.experiment import Experiment
from imugap.study.static.monte_carlo import row, summary
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

COMPARED = {
    "indirect_full": METHODS["indirect_full"],
    "indirect_robust": partial(estimator.fit, options=GmwmOptions(efficiency=EFFICIENCY)),
    "likelihood": METHODS["likelihood"],
}


def contaminated(sequence, choice, seed, run):
    """Add normal outliers of ``size`` white-noise deviations to a share of the samples."""
    rng = stream(seed, "outliers", run)
    hit = rng.random(len(sequence)) < choice["share"]
    white = np.std(np.diff(sequence)) / np.sqrt(2)
    return sequence + hit * choice["size"] * white * rng.standard_normal(len(sequence))


def estimates(experiment, choice, seed):
    """Return the estimates of all runs, clean and contaminated, by the compared methods."""
    found = []
    for run in range(choice["runs"]):
        clean = experiment.simulate(seed, "contamination", run)
        logs = {"clean": clean, "contaminated": contaminated(clean, choice, seed, run)}
        for (log, sequence), (name, method) in ((a, b) for a in logs.items() for b in COMPARED.items()):
            fit = method(sequence, experiment.interval, experiment.kinds)
            found.append(row(fit, method=name, run=run, log=log))
    return pd.concat(found, ignore_index=True)


def page(data):
    """Lay the table out: a row per parameter and method, clean and contaminated side by side."""
    for (effect, parameter, method), group in data.groupby(["effect", "parameter", "method"], sort=False):
        if parameter == "driving_psd":
            continue
        cells = {"parameter": estimation.SYMBOLS[effect, parameter], "method": estimation.TITLES[method]}
        for one in group.itertuples():
            bias, error = tables.number(100 * one.bias, 2), tables.number(100 * one.bias_error, 1)
            cells[f"bias, {one.log} [%]"] = f"{bias} ± {error}"
            cells[f"RMSE, {one.log} [%]"] = tables.number(100 * one.rmse, 2)
            cells[f"coverage, {one.log} [%]"] = f"{100 * one.coverage:.0f}"
        yield cells


with job(snakemake) as (source, params, output):
    experiment = Experiment.read(source.recipe)
    found = estimates(experiment, params.contamination, params.seed)
    truth, limits = experiment.truth(), bound(experiment.model, experiment.interval, experiment.count)
    data = pd.concat(
        summary(group, truth, limits, params.seed).assign(log=log) for log, group in found.groupby("log", sort=False)
    )
    dirty = data[data["log"] == "contaminated"].set_index(["parameter", "method"])
    said = {
        "white": {name: tables.number(100 * value, 2) for name, value in dirty["bias"]["density"].items()},
        "time": {name: tables.number(100 * v, 2) for name, v in dirty["rmse"]["correlation_time"].items()},
    }
    said["correlation_time_s"] = f"{next(true for key, true in truth.items() if key[2] == 'correlation_time'):g}"
    table = data, page(data)
    save(output, figure=estimation.contamination(data), table=table, numbers=said | params.contamination)
