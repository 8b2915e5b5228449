"""Filter a part of the simulated drives under every scheme, and write their errors, verdicts and recoveries."""

from dataclasses import asdict

import pandas as pd

from imugap.study.fault_ablation import CASES, CLEAN, CONTAMINATED, Ablation
from imugap.workflow.job_log import journal


def main(ablation, runs, parted, seed, output):
    """Write the errors at every second, what the quality control did, and the gross errors that last."""
    errors, verdicts, events = [], [], []
    for run in runs:
        cases = CASES if run <= parted else (CLEAN, CONTAMINATED)
        for case, scheme, one in ablation.runs(run, seed, cases=cases):
            key = {"run": run, "case": case, "scheme": scheme}
            errors.append(ablation.errors(one).assign(**key))
            verdicts.append(key | ablation.verdicts(one))
            events += [key | asdict(event) for event in one.events if scheme == "reset"]
    pd.concat(errors).to_parquet(output.errors, index=False)
    pd.DataFrame(verdicts).to_csv(output.verdicts, index=False)
    pd.DataFrame(events).drop(columns="shift").to_csv(output.recovery, index=False)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        params = snakemake.params
        main(Ablation.read(snakemake.input.recipe), params.runs, params.parted, params.seed, snakemake.output)
