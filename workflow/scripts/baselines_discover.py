"""Name what is missing from the model of each of a batch of cases of the comparison with baselines."""

from pathlib import Path

from imugap.discovery.device import Settings
from imugap.study.discovery.blind_answers import answer
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    for case in params.cases:
        answer(Path(source.public) / "cases" / case, Settings(**params.settings, seed=params.seed), Path(output[0]))
        print(case)
