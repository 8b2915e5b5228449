"""Score simulated drifts against measured ones."""

import numpy as np
import pandas as pd

from imugap.kinematics.free_inertial import QUANTITIES, STARTS, crps, errors
from imugap.workflow.job_log import journal


def scores(contender, start, measured, simulated, horizons, at):
    """Return e_abs and e_rel of every run and trial, the CRPS of every run, and the scores of the ensemble."""
    e_abs, e_rel = errors(measured, simulated, at)
    runs, trials = range(len(measured)), range(len(simulated))
    index = pd.MultiIndex.from_product(
        [[contender], [start], runs, trials, horizons, QUANTITIES],
        names=["contender", "start", "run", "trial", "horizon", "quantity"],
    )
    each = pd.DataFrame({"e_abs": e_abs.ravel(), "e_rel": e_rel.ravel()}, index=index).reset_index()
    low, high = np.quantile(simulated[:, at], [0.05, 0.95], axis=0)
    ends = measured[:, at]
    inside = ((low <= ends) & (ends <= high)).mean(axis=0)
    index = pd.MultiIndex.from_product([[contender], [start], horizons, QUANTITIES])
    index.names = ["contender", "start", "horizon", "quantity"]
    proper = crps(ends, simulated[:, at])
    runs = pd.MultiIndex.from_product(
        [[contender], [start], runs, horizons, QUANTITIES], names=["contender", "start", "run", "horizon", "quantity"]
    )
    of_runs = pd.DataFrame({"crps": proper.ravel()}, index=runs).reset_index()
    columns = {
        "crps": proper.mean(axis=0),
        "crps_error": proper.std(axis=0, ddof=1) / np.sqrt(len(measured)) if len(measured) > 1 else np.nan * inside,
        "inside_90": inside,
        "median_e_abs": np.median(e_abs, axis=(0, 1)),
        "e_abs_5": np.quantile(e_abs, 0.05, axis=(0, 1)),
        "e_abs_95": np.quantile(e_abs, 0.95, axis=(0, 1)),
        "measured": np.abs(ends).mean(axis=0),
    }
    return each, of_runs, pd.DataFrame({k: np.ravel(v) for k, v in columns.items()}, index=index).reset_index()


def main(measured_path, simulated_paths, params, output):
    """Write the errors of all trials, the CRPS of all runs and the scores of all ensembles."""
    measured = np.load(measured_path)
    horizons = [length for length in params.horizons_s if length <= measured["time"][-1]]
    at = np.searchsorted(measured["time"], np.array(horizons) - 1e-9)
    found = []
    for contender, path in zip(params.contenders, simulated_paths, strict=True):
        simulated = np.load(path)["drift"]
        for k, start in enumerate(STARTS):
            drift = measured["drift"][k][..., list(QUANTITIES.values())]
            found.append(scores(contender, start, drift, simulated[k], horizons, at))
    errors, proper, summary = (pd.concat(part) for part in zip(*found, strict=True))
    errors.to_parquet(output.errors, index=False)
    proper.to_parquet(output.proper, index=False)
    summary.to_csv(output.scores, index=False)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.input.measured, snakemake.input.simulated, snakemake.params, snakemake.output)
