"""Estimate the indices and the Allan deviation of every run of a device."""

import pandas as pd

from imugap import log
from imugap.estimation.indices import INDICES, of_run
from imugap.estimation.variances import allan
from imugap.kinematics.site import Site
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    symbols = tuple(symbol for symbol in INDICES if symbol != "repeatability")
    ideal = Site.from_mapping(params.site).ideal()
    for path, indices, curves in zip(source.logs, output.indices, output.allan, strict=True):
        table = log.load(path, columns=list(log.AXES))
        of_run(table, ideal, params.period_s, symbols).to_csv(indices, index=False)
        asd = {axis: allan.curve(table[axis].to_numpy(), log.interval(table)) for axis in log.axes(table)}
        pd.concat(asd, names=["axis"]).to_csv(curves)
