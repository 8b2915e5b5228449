"""Build every contender from the indices of a device."""

import pandas as pd

from imugap.interchange.from_indices import averaged, fit
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        indices, curves = pd.read_csv(snakemake.input.indices), averaged(pd.read_csv(snakemake.input.allan))
        for name, path in zip(snakemake.params.contenders, snakemake.output, strict=True):
            fit(name, indices, curves, snakemake.params.period_s).write(path)
