"""Take the Allan deviation of continuous models and of their samples."""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap import log
from imugap.estimation.variances import allan
from imugap.model import ErrorModel
from imugap.numerics.spectra import allan_from_psd as spectrum
from imugap.stream import stream
from imugap.study.static.farrell2022 import COMPOSED
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def rows(axis, model, interval, count, trials, labels):
    """Return the curve of one axis: eq. 16 of the spectrum; mean and 90 % band over simulated runs, if any."""
    system, averaging = model.state_space(), allan.factors(count)
    variance = spectrum.allan_variance(system.psd, averaging * interval)
    runs = np.full((1, len(averaging)), np.nan)
    if trials:
        streams = [stream(*labels, axis, trial) for trial in range(trials)]
        runs = np.array([allan.variance(system.simulate(count, interval, rng), averaging) for rng in streams])
    low, high = np.sqrt(np.quantile(runs, [0.05, 0.95], axis=0))
    return pd.DataFrame({"axis": axis, "tau": averaging * interval, "deviation": np.sqrt(variance),
                         "low": low, "mean": np.sqrt(runs.mean(axis=0)), "high": high})  # fmt: skip


with job(snakemake) as (source, params, output):
    like = log.load(source.log, columns=[log.AXES[0]])
    interval, count, curves = log.interval(like), len(like), []
    for path in map(Path, source.models):
        model, trials = ErrorModel.read(path), params.trials if path.stem in COMPOSED else 0
        labels = (params.seed, "tutorial", snakemake.wildcards.device, path.stem)
        parts = [rows(axis, model[axis], interval, count, trials, labels) for axis in model.axes]
        curves.append(pd.concat(parts).assign(model=path.stem))
    save(output, allan=pd.concat(curves))
