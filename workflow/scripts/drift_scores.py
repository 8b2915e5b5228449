"""Score simulated drifts against measured ones."""

import numpy as np
import pandas as pd

from imugap.kinematics.free_inertial import QUANTITIES, STARTS, crps, errors
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def table(levels, **values):
    """Return arrays as columns, a row for each combination of the levels."""
    index = pd.MultiIndex.from_product(levels.values(), names=levels)
    return pd.DataFrame({name: np.ravel(one) for name, one in values.items()}, index=index).reset_index()


def scores(contender, start, measured, simulated, horizons, at):
    """Return e_abs and e_rel of every run and trial, the CRPS of every run, and the scores of the ensemble."""
    e_abs, e_rel = errors(measured, simulated, at)
    low, high = np.quantile(simulated[:, at], [0.05, 0.95], axis=0)
    ends = measured[:, at]
    inside = ((low <= ends) & (ends <= high)).mean(axis=0)
    proper = crps(ends, simulated[:, at])
    of, case = {"contender": [contender], "start": [start]}, {"horizon": horizons, "quantity": QUANTITIES}
    runs, trials = {"run": range(len(measured))}, {"trial": range(len(simulated))}
    e_abs_5, e_abs_95 = np.quantile(e_abs, [0.05, 0.95], axis=(0, 1))
    error = proper.std(axis=0, ddof=1) / np.sqrt(len(measured)) if len(measured) > 1 else np.nan * inside
    whole = table(
        of | case, crps=proper.mean(axis=0), crps_error=error, inside_90=inside,
        median_e_abs=np.median(e_abs, axis=(0, 1)), e_abs_5=e_abs_5, e_abs_95=e_abs_95,
        measured=np.abs(ends).mean(axis=0),
    )  # fmt: skip
    return table(of | runs | trials | case, e_abs=e_abs, e_rel=e_rel), table(of | runs | case, crps=proper), whole


with job(snakemake) as (source, params, output):
    measured = np.load(source.measured)
    horizons = [length for length in params.horizons_s if length <= measured["time"][-1]]
    at = np.searchsorted(measured["time"], np.array(horizons) - 1e-9)
    found = []
    for contender, path in zip(params.contenders, source.simulated, strict=True):
        simulated = np.load(path)["drift"]
        for k, start in enumerate(STARTS):
            drift = measured["drift"][k][..., list(QUANTITIES.values())]
            found.append(scores(contender, start, drift, simulated[k], horizons, at))
    save(output, **dict(zip(("errors", "proper", "scores"), map(pd.concat, zip(*found, strict=True)), strict=True)))
