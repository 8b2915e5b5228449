"""Build N + B + K from one run."""

import pandas as pd

from imugap.effects.effect import AxisModel
from imugap.interchange.from_indices import fit
from imugap.model import ErrorModel
from imugap.workflow.job_log import job


def without_nothing(model):
    """Leave out what the fit sets to zero: the turn-on bias, of which one run says nothing, and processes not seen."""
    seen = {axis: [one for one in of if all(one.parameters().values())] for axis, of in model.axes.items()}
    return ErrorModel({axis: AxisModel(tuple(effects)) for axis, effects in seen.items()})


with job(snakemake) as (source, params, output):
    indices, allan = pd.read_csv(source.indices), pd.read_csv(source.allan)
    without_nothing(fit("nbk", indices, allan, params.period_s)).write(output[0])
