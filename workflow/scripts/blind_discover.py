"""Name what is missing from the model of each of a batch of sealed cases, and note how long each took."""

from pathlib import Path

from imugap.discovery.device import Settings
from imugap.study.discovery.blind_answers import answer
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    for case in map(Path, source.cases):
        answer(case, Settings(**params.settings, seed=params.seed), Path(output[0]))
        print(case.name)
