"""Take the Allan deviation of simulated runs of every contender."""

import numpy as np
import pandas as pd

from imugap import log
from imugap.estimation import allan
from imugap.model import ErrorModel
from imugap.workflow.job_log import journal


def main(model_path, log_path, contender, params, path):
    """Write median and 90 % band over the trials, per axis and tau."""
    model, like = ErrorModel.read(model_path), log.load(log_path, columns=[log.AXES[0]])
    interval, count = log.interval(like), len(like)
    ideal = log.from_samples({axis: np.zeros(count) for axis in model.axes}, interval)
    averaging = allan.factors(count)
    trials = np.empty((params.trials, len(model.axes), len(averaging)))
    for trial in range(params.trials):
        simulated = model.simulate(ideal, params.seed, "model_allan", contender, trial)
        for k, axis in enumerate(model.axes):
            trials[trial, k] = np.sqrt(allan.variance(simulated[axis].to_numpy(), averaging))
    low, median, high = np.quantile(trials, [0.05, 0.5, 0.95], axis=0)
    bands = [
        pd.DataFrame({"contender": contender, "axis": axis, "tau": averaging * interval,
                      "low": low[k], "median": median[k], "high": high[k]})
        for k, axis in enumerate(model.axes)
    ]  # fmt: skip
    pd.concat(bands).to_csv(path, index=False)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, params = snakemake.input, snakemake.params
        for contender, model, path in zip(params.contenders, source.models, snakemake.output, strict=True):
            main(model, source.log, contender, params, path)
