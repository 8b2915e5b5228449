"""Estimate the source's models of gyroscopes and accelerometers from every run, by every method."""

import pandas as pd

from imugap import log
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.methods import METHODS
from imugap.io import readers
from imugap.study.monte_carlo import row
from imugap.workflow.job_log import journal

MODELS = {"gyro": (WhiteNoise, GaussMarkov), "accel": (WhiteNoise, RandomWalk)}


def estimates(table, rate):
    """Return the estimates of all axes by all methods, from means at ``rate`` [Hz]."""
    factor = max(round(1 / (log.interval(table) * rate)), 1)
    found = []
    for axis in log.axes(table):
        kinds = MODELS[axis.split("_")[0]]
        samples = table[axis].to_numpy()
        means = samples[: len(samples) // factor * factor].reshape(-1, factor).mean(axis=1)
        for name, method in METHODS.items():
            found.append(row(method(means, factor * log.interval(table), kinds), method=name, axis=axis))
    return pd.concat(found, ignore_index=True)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        for source, path in zip(snakemake.input.logs, snakemake.output, strict=True):
            estimates(readers.read(source), snakemake.params.rate_hz).to_csv(path, index=False)
