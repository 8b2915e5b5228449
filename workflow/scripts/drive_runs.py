"""Filter a part of the simulated drives under every scheme, and write their errors, verdicts and recoveries."""

from dataclasses import asdict

import pandas as pd

from imugap.study.drive.fault_ablation import CASES, CLEAN, CONTAMINATED, Ablation
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    ablation = Ablation.read(source.recipe)
    errors, verdicts, events = [], [], []
    for run in params.runs:
        cases = CASES if run <= params.parted else (CLEAN, CONTAMINATED)
        for case, scheme, one in ablation.runs(run, params.seed, cases=cases):
            key = {"run": run, "case": case, "scheme": scheme}
            errors.append(ablation.errors(one).assign(**key))
            verdicts.append(key | ablation.verdicts(one))
            events += [key | asdict(event) for event in one.events if scheme == "reset"]
    recovery = pd.DataFrame(events).drop(columns="shift")
    save(output, errors=pd.concat(errors), verdicts=pd.DataFrame(verdicts), recovery=recovery)
