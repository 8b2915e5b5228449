"""Tabulate and draw the Cramer-Rao bound of every parameter for models and lengths of log."""

from itertools import product

import pandas as pd

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.cramer_rao import bound
from imugap.figures import estimation
from imugap.study.static.experiment import Experiment
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

COMPOSITIONS = {
    "N": (WhiteNoise,),
    "N + K": (WhiteNoise, RandomWalk),
    "N + GM": (WhiteNoise, GaussMarkov),
    "N + GM + K": (WhiteNoise, GaussMarkov, RandomWalk),
}


def bounds(experiment, times, lengths):
    """Return the bounds of all compositions, correlation times and lengths [s]."""
    found = []
    for (name, kinds), time, length in product(COMPOSITIONS.items(), times, lengths):
        model = AxisModel(tuple(effect for effect in experiment.at(time).model if isinstance(effect, kinds)))
        if GaussMarkov not in kinds and time != times[0]:
            continue
        rows = bound(model, experiment.interval, round(length / experiment.interval)).reset_index()
        found.append(rows.assign(model=name, time=time if GaussMarkov in kinds else float("nan"), length=length))
    return pd.concat(found, ignore_index=True)


def page(data):
    """Lay the table out: a row per model and correlation time, columns parameters and lengths, in percent."""
    shown = data[data["parameter"] != "driving_psd"].copy()
    shown["head"] = [
        f"{estimation.SYMBOLS[row.effect, row.parameter]}, {tables.number(row.length / 3600, 2)} h"
        for row in shown.itertuples()
    ]
    shown["cell"] = [tables.number(100 * value, 2) for value in shown["bound"]]
    shown["T [s]"] = [tables.number(time) for time in shown["time"]]
    wide = shown.pivot_table(index=["model", "T [s]"], columns="head", values="cell", aggfunc="first", sort=False)
    heads = sorted(dict.fromkeys(shown["head"]), key=lambda head: "NσTK".index(head[0]))
    return wide[heads].fillna("").reset_index()


with job(snakemake) as (source, params, output):
    data = bounds(Experiment.read(source.recipe), params.times, params.lengths_s)
    save(output, figure=estimation.bounds(data), table=(data, page(data)))
