"""Join tables of the same columns, in their order."""

import pandas as pd

from imugap.workflow.job_log import job

with job(snakemake) as (source, _, output):
    pd.concat(map(pd.read_csv, source), ignore_index=True).to_csv(output[0], index=False)
