"""Make the cases of the comparison with baselines."""

from imu_benchmark import commitments, recipe
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    changed = recipe.checked(recipe.read(source.recipe) | params.changes, "baselines.changes")
    commitments.make(params.seed, params.cases, changed, output.public, output.secret)
