"""Simulate one flight and the static log ahead of it."""

from imugap import log
from imugap.simulation.flight import Flight
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        flight, run, seed = Flight.read(snakemake.input.recipe), int(snakemake.wildcards.run), snakemake.params.seed
        log.write(flight.static(run, 60 * snakemake.params.minutes, seed), snakemake.output.static)
        log.write(flight.fly(run, seed), snakemake.output.flight)
