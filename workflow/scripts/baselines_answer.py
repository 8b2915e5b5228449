"""Answer the cases with a baseline."""

from imu_benchmark.baselines import answer_all, named
from imugap.workflow.job_log import job

with job(snakemake) as (source, _, output):
    answer_all(named(snakemake.wildcards.baseline), source.public, output[0])
