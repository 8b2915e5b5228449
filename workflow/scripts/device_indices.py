"""Combine the runs of a device."""

import pandas as pd

from imugap.estimation.indices import over_runs
from imugap.workflow.job_log import journal


def stacked(paths, runs):
    """Read one table per run into one, with the run as first column."""
    tables = [pd.read_csv(path) for path in paths]
    return pd.concat(tables, keys=runs, names=["run"]).reset_index("run").reset_index(drop=True)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        runs = stacked(snakemake.input.indices, snakemake.params.runs)
        runs.to_csv(snakemake.output.runs, index=False)
        over_runs(runs).to_csv(snakemake.output.indices, index=False)
        stacked(snakemake.input.allan, snakemake.params.runs).to_csv(snakemake.output.allan, index=False)
