"""Calibrate the simulated device at rest; build every contender, and the composite that a log of it chooses."""

from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.effects import Bias, TurnOnBias
from imugap.estimation.indices import INDICES, of_run, over_runs
from imugap.estimation.model_selection import choose
from imugap.estimation.variances import allan
from imugap.interchange.from_indices import CONTENDERS, averaged, fit
from imugap.model import ErrorModel
from imugap.simulation.walk import Walk
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SYMBOLS = tuple(symbol for symbol in INDICES if symbol != "repeatability")


def calibrated(walk, logs, period):
    """Return the indices over the static logs, and their Allan curves averaged."""
    found, curves = [], []
    for run, table in enumerate(logs):
        found.append(of_run(table, walk.site.ideal(), period, SYMBOLS).assign(run=run))
        asd = {axis: allan.curve(table[axis].to_numpy(), log.interval(table)) for axis in log.AXES}
        curves.append(pd.concat(asd, names=["axis"]).reset_index())
    return over_runs(pd.concat(found)), averaged(pd.concat(curves))


def composite(indices, table, rate):
    """Return what the means of one log choose, with the bias of all logs and its repeatability."""
    axes, (means, _) = {}, log.block_means(table, rate)
    for axis in log.AXES:
        value = indices[indices["axis"] == axis].set_index("symbol")["value"]
        axes[axis] = choose(means[axis], 1 / rate).fit.model + Bias(value["bias"]) + TurnOnBias(value["repeatability"])
    return ErrorModel(axes)


with job(snakemake) as (source, params, output):
    walk, runs = Walk.read(source.recipe), range(1, params.static["runs"] + 1)
    logs = [walk.static(run, params.static["duration_s"], params.seed) for run in runs]
    indices, curves = calibrated(walk, logs, params.period_s)
    models = {name: fit(name, indices, curves, params.period_s) for name in CONTENDERS}
    models |= {"fitted": composite(indices, logs[0], params.rate_hz), "truth": walk.model}
    plain = {name: model.to_mapping() for name, model in models.items()}
    Path(output.models).write_text(yaml.safe_dump(plain, sort_keys=False))
    save(output, indices=indices)
