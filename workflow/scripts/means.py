"""Cut logs short and average them over blocks."""

from imugap import log
from imugap.io import readers
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    for path, to in zip(source[: len(output)], output, strict=True):
        table = readers.read(path).loc[: params.duration_s]
        table = table if params.columns is None else table[params.columns]
        log.write(log.from_samples(*log.block_means(table, params.rate_hz)), to)
