"""Seal one case with given effects."""

from pathlib import Path

from imu_benchmark.recipe import read
from imu_benchmark.sealing import BlindCase, CaseKind, PlannedEffect, seal, write
from imugap import log
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    folder = Path(output.log).parent
    case = BlindCase(
        name=folder.name, seed=params.seed, kind=CaseKind.PAIR,
        effects=tuple(PlannedEffect(name, size) for name, size in params.effects.items()), same_axis=False,
        base="white", motion="rest", rate_hz=params.rate_hz, duration_s=params.duration_s, runs=1, temperature=True,
    )  # fmt: skip
    write(seal(case, read(source.recipe)), folder.parent, Path(output.key).parent, log.write, ".parquet")
