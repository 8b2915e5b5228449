"""Estimate the source's models of gyroscopes and accelerometers from every run, by every method."""

from itertools import product

import pandas as pd

from imugap import log
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.methods import METHODS
from imugap.study.static.monte_carlo import row
from imugap.workflow.job_log import job

MODELS = {"gyro": (WhiteNoise, GaussMarkov), "accel": (WhiteNoise, RandomWalk)}


def estimates(table, rate):
    """Return the estimates of all axes by all methods, from means at ``rate`` [Hz]."""
    means, interval = log.block_means(table, rate)
    found = [
        row(method(means[axis], interval, MODELS[axis.split("_")[0]]), method=name, axis=axis)
        for axis, (name, method) in product(log.axes(table), METHODS.items())
    ]
    return pd.concat(found, ignore_index=True)


with job(snakemake) as (source, params, output):
    for path, to in zip(source.logs, output, strict=True):
        estimates(log.load(path), params.rate_hz).to_csv(to, index=False)
