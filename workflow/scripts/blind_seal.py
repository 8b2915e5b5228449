"""Seal the cases of the blind benchmark."""

from pathlib import Path

import yaml

from imugap.benchmark.sealing import plan, seal, write
from imugap.io.configuration import configure
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    recipe = configure(yaml.safe_load(Path(source.recipe).read_text()), source.schema)
    for case in plan(params.seed, params.cases, recipe["shares"], recipe):
        write(seal(case, recipe), Path(output.cases[0]).parent, Path(output.key[0]).parent)
    print(f"{params.cases} cases")
