"""Build N + B + K from one run."""

import pandas as pd

from imugap.effects.effect import AxisModel
from imugap.interchange.from_indices import fit
from imugap.model import ErrorModel
from imugap.workflow.job_log import journal


def without_nothing(model):
    """Leave out what the fit sets to zero: the turn-on bias, of which one run says nothing, and processes not seen."""
    axes = model.axes.items()
    return ErrorModel(
        {axis: AxisModel(tuple(one for one in of if all(one.parameters().values()))) for axis, of in axes}
    )


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        indices, allan = pd.read_csv(snakemake.input.indices), pd.read_csv(snakemake.input.allan)
        without_nothing(fit("nbk", indices, allan, snakemake.params.period_s)).write(snakemake.output[0])
