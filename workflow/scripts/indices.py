"""Estimate the indices and the Allan deviation of every run of a device."""

import pandas as pd

from imugap import log
from imugap.estimation import allan
from imugap.estimation.indices import INDICES, of_run
from imugap.kinematics.site import Site
from imugap.workflow.job_log import journal


def main(path, site, period, indices, curves):
    """Write the indices of the run and its Allan curves, one block of rows per axis."""
    table = log.load(path, columns=list(log.AXES))
    ideal = Site.from_mapping(site).ideal()
    symbols = tuple(symbol for symbol in INDICES if symbol != "repeatability")
    of_run(table, ideal, period, symbols).to_csv(indices, index=False)
    asd = {axis: allan.curve(table[axis].to_numpy(), log.interval(table)) for axis in log.axes(table)}
    pd.concat(asd, names=["axis"]).to_csv(curves)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        params, output = snakemake.params, snakemake.output
        for path, *results in zip(snakemake.input.logs, output.indices, output.allan, strict=True):
            main(path, params.site, params.period_s, *results)
