"""Take the Allan deviation of simulated runs of every contender."""

import numpy as np
import pandas as pd

from imugap import log
from imugap.estimation.variances import allan
from imugap.model import ErrorModel
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    like = log.load(source.log, columns=[log.AXES[0]])
    interval, count = log.interval(like), len(like)
    averaging = allan.factors(count)
    for contender, path, to in zip(params.contenders, source.models, output, strict=True):
        model = ErrorModel.read(path)
        ideal = log.from_samples({axis: np.zeros(count) for axis in model.axes}, interval)
        trials = np.empty((params.trials, len(model.axes), len(averaging)))
        for trial in range(params.trials):
            simulated = model.simulate(ideal, params.seed, "model_allan", contender, trial)
            for k, axis in enumerate(model.axes):
                trials[trial, k] = np.sqrt(allan.variance(simulated[axis].to_numpy(), averaging))
        bands = [
            pd.DataFrame(dict(zip(("low", "median", "high"), band, strict=True)) | {"tau": averaging * interval})
            for band in np.quantile(trials, [0.05, 0.5, 0.95], axis=0).swapaxes(0, 1)
        ]
        found = pd.concat(bands, keys=model.axes, names=["axis"]).reset_index("axis").assign(contender=contender)
        found[["contender", "axis", "tau", "low", "median", "high"]].to_csv(to, index=False)
