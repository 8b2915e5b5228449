"""Draw the Allan deviations of a device."""

import pandas as pd

from imugap.figures import static
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, _, output):
    save(output, figure=static.allan(pd.read_csv(source.allan), pd.read_csv(source.indices)))
