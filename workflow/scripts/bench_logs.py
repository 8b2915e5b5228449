"""Generate the raw logs of the virtual bench."""

from imugap import log
from imugap.simulation.bench import Bench
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    bench = Bench.read(source.recipe)
    for run, path in zip(params.runs, output, strict=True):
        table = bench.run(run, 1 / params.rate_hz, params.duration_s, params.seed)
        log.write(table, path)
        print(f"run {run}: {len(table)} samples")
