"""Generate one raw log of the virtual bench."""

from imugap import log
from imugap.simulation.bench import Bench
from imugap.workflow.job_log import journal


def main(recipe, run, params, path):
    """Simulate run ``run`` of the recipe and write it."""
    table = Bench.read(recipe).run(run, 1 / params.rate_hz, params.duration_s, params.seed)
    log.write(table, path)
    print(f"run {run}: {len(table)} samples")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.input.recipe, int(snakemake.wildcards.run), snakemake.params, snakemake.output[0])
