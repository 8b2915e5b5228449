"""Seal the cases of the blind benchmark."""

from pathlib import Path

from imu_benchmark.recipe import read
from imu_benchmark.sealing import plan, seal, write
from imugap import log
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    recipe = read(source.recipe)
    for case in plan(params.seed, params.cases, recipe):
        write(seal(case, recipe), Path(output.cases[0]).parent, Path(output.key[0]).parent, log.write, ".parquet")
    print(f"{params.cases} cases")
