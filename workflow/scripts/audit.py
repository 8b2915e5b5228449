"""Check the published tables."""

import pandas as pd

from imugap.study.static.he2023 import findings
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, _, output):
    data = findings(*map(pd.read_csv, (source.indices, source.static, source.walk)))
    save(output, table=(data, data.assign(consistent=data["consistent"].map({True: "yes", False: "NO"}))))
