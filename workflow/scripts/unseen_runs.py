"""Score every contender and the discovered models on each run of a device, fitted to the other runs alone."""

import pandas as pd

from imugap import log
from imugap.discovery.device import Settings, leave_one_out
from imugap.discovery.evaluation.held_out import of_one_run
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.prepare import prepare
from imugap.discovery.runs.over_runs import fit_over_runs
from imugap.effects import PowerLaw, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.gmwm import estimator
from imugap.estimation.indices import over_runs
from imugap.estimation.model_selection import choose
from imugap.interchange import from_indices
from imugap.model import ErrorModel
from imugap.study.discovery.unseen_runs import log_scores, scores
from imugap.workflow.job_log import job
from imugap.workflow.products import save

OF_INDICES = ("white", "method_a", "method_b", "restoration", "nbk")
"""Contenders by the indices of the runs."""
GUESS = 0.1
"""Share of the deviation of the samples with which the fit of a power law begins."""


def of_indices(runs, indices, curves, period):
    """Return the contenders by the indices of some runs."""
    mean, curve = over_runs(pd.concat([indices[run] for run in runs])), pd.concat([curves[run] for run in runs])
    return {name: from_indices.fit(name, mean, from_indices.averaged(curve), period) for name in OF_INDICES}


def power_law(sequences):
    """Return white noise and noise of a free slope, fitted to some runs together."""
    axes = {}
    for axis, first in sequences[0].items():
        std, interval = first.values.std(), first.conditions.interval
        start = Description.known(WhiteNoise(std * interval**0.5), PowerLaw(GUESS * std, 1.0))
        fitted = fit_over_runs([fit(one[axis], start) for one in sequences])
        axes[axis] = AxisModel(fitted.description.effects())
    return ErrorModel(axes)


def chosen(sequences):
    """Return the effects chosen for one run, fitted by likelihood and by wavelet moments (GMWM)."""
    choices = {axis: choose(one.values, one.conditions.interval) for axis, one in sequences.items()}
    moments = {
        axis: estimator.fit(one.values, one.conditions.interval, choices[axis].kinds) for axis, one in sequences.items()
    }
    return {
        "chosen": ErrorModel({axis: one.fit.model for axis, one in choices.items()}),
        "gmwm": ErrorModel({axis: one.model for axis, one in moments.items()}),
    }


# started processes import this module again
if __name__ == "__main__":
    with job(snakemake) as (source, params, output):
        runs = params.runs
        logs, starts = [*map(log.load, source.logs)], [*map(ErrorModel.read, source.starts)]
        indices, curves = (
            {run: pd.read_csv(path).assign(run=run) for run, path in zip(runs, paths, strict=True)}
            for paths in (source.indices, source.allan)
        )
        settings = Settings(**params.settings, seed=params.seed, workers=snakemake.threads)
        prepared = [prepare(one, seed=params.seed) for one in logs]
        sequences = [one.sequences for one in prepared]
        choices = {first: chosen(sequences[first]) for first in (0, 1)}
        given = ([None] * len(logs), starts)
        folds = zip(*(leave_one_out(logs, prepared, settings, one) for one in given), strict=True)
        rows = []
        for out, pair in enumerate(folds):
            others = [number for number in range(len(runs)) if number != out]
            models = of_indices([runs[number] for number in others], indices, curves, params.period_s)
            models |= {"power_law": power_law([sequences[number] for number in others])} | choices[others[0]]
            ensembles = {name: of_one_run(model) for name, model in models.items()}
            ensembles |= {f"discovered_{start}": one.after for start, one in zip(params.names, pair, strict=True)}
            for name, ensemble in ensembles.items():
                by_axis = log_scores(getattr(ensemble, "model", ensemble), sequences[out])
                of_run = scores(pair[0], ensemble, params.seed, settings.simulations)
                rows += [(runs[out], name, "log_score", axis, value) for axis, value in by_axis.items()]
                rows += [(runs[out], name, quantity, "", value) for quantity, value in of_run.items()]
        save(output, scores=pd.DataFrame(rows, columns=["run", "contender", "quantity", "axis", "value"]))
