"""Generate the raw logs of the virtual bench."""

from imugap import log
from imugap.simulation.bench import Bench
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        bench, params = Bench.read(snakemake.input.recipe), snakemake.params
        for run, path in zip(params.runs, snakemake.output, strict=True):
            table = bench.run(run, 1 / params.rate_hz, params.duration_s, params.seed)
            log.write(table, path)
            print(f"run {run}: {len(table)} samples")
