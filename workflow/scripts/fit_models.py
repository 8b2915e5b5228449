"""Build every contender from the indices of a device."""

import pandas as pd

from imugap.interchange.from_indices import averaged, fit
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    indices, curves = pd.read_csv(source.indices), averaged(pd.read_csv(source.allan))
    for name, path in zip(params.contenders, output, strict=True):
        fit(name, indices, curves, params.period_s).write(path)
