"""Cut logs short and average them over blocks, in the time of the clock of the first run of the device."""

import pandas as pd

from imugap import log
from imugap.workflow.job_log import job


def intervals(clocks):
    """Return the sampling interval over that of the first run, by run, of the runs that have another clock."""
    return clocks.loc[clocks["verdict"] == "different clock"].set_index("run")["combined"]


with job(snakemake) as (source, params, output):
    ratios = intervals(pd.read_csv(source.clock))
    for run, path, to in zip(params.runs, source.logs, output, strict=True):
        table = log.load(path)
        table = table.set_axis(table.index * ratios.get(run, 1.0)).loc[: params.duration_s]
        log.write(log.from_samples(*log.block_means(table, params.rate_hz)), to)
