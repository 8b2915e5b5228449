"""Write the truth of the virtual bench."""

from imugap.simulation.bench import Bench
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, _, output):
    save(output, truth=Bench.read(source.recipe).truth())
