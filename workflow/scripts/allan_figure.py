"""Draw the Allan deviations of a device."""

import pandas as pd

from imugap import figures
from imugap.figures import static
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        curves, indices = pd.read_csv(snakemake.input.allan), pd.read_csv(snakemake.input.indices)
        figures.save(static.allan(curves, indices), snakemake.output[0])
