"""Build every contender from the indices of a device."""

import numpy as np
import pandas as pd

from imugap.contenders import fit
from imugap.journal import journal


def mean_curves(allan):
    """Average the Allan variance over the runs; the error shrinks with their number."""
    grouped = allan.assign(square=allan["deviation"] ** 2).groupby(["axis", "tau"], sort=False)
    runs = grouped.size()
    mean = grouped.agg(square=("square", "mean"), error=("error", "mean"))
    return mean.assign(deviation=np.sqrt(mean["square"]), error=mean["error"] / np.sqrt(runs)).reset_index()


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        indices, curves = pd.read_csv(snakemake.input.indices), mean_curves(pd.read_csv(snakemake.input.allan))
        for name, path in zip(snakemake.params.contenders, snakemake.output, strict=True):
            fit(name, indices, curves, snakemake.params.period_s).write(path)
