"""Draw the Allan deviations of a device."""

import pandas as pd

from imugap.figures import static, style
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        curves, indices = pd.read_csv(snakemake.input.allan), pd.read_csv(snakemake.input.indices)
        style.save(static.allan(curves, indices), snakemake.output[0])
