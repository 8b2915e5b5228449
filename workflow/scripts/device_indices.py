"""Combine the runs of a device."""

import pandas as pd

from imugap.estimation.indices import over_runs
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def stacked(paths, runs):
    """Read one table per run into one, with the run as first column."""
    tables = [pd.read_csv(path) for path in paths]
    return pd.concat(tables, keys=runs, names=["run"]).reset_index("run").reset_index(drop=True)


with job(snakemake) as (source, params, output):
    runs = stacked(source.indices, params.runs)
    save(output, runs=runs, indices=over_runs(runs), allan=stacked(source.allan, params.runs))
