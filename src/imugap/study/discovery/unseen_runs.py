"""Score the models of a device on a run that none of them has seen, all by the same measures.

The log score is the log-density of the samples, free of their level, by the spectrum of the model; the energy score is
that of the free-inertial drift over simulated ones. Both are proper: no model gains by being wide. Distance and width
of the band are no scores: a wide band makes a small distance.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from imugap.discovery.evaluation.distance import (
    HORIZONS,
    HeldOutComparison,
    LogStatistics,
    combined,
    distribution,
)
from imugap.discovery.evaluation.parameter_ensemble import UncertainModel
from imugap.discovery.fit.axis_fit import log_score
from imugap.discovery.fit.start_model import described
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.runs.over_runs import recurring
from imugap.effects import StabilityRestoration, WhiteNoise
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.model import ErrorModel
from imugap.study.proper_scores import energy_score

Model = ErrorModel | UncertainModel


def log_scores(model: ErrorModel, sequences: Mapping[str, AxisSequence]) -> dict[str, float]:
    """Return the mean log-density of a sample of each axis [nat] by the spectrum of a model; more is better."""
    return {
        axis: log_score(one, recurring(described(_without_scaling(model[axis]), one))) / len(one.values)
        for axis, one in sequences.items()
    }


def _without_scaling(model: AxisModel) -> tuple[Effect, ...]:
    """Return the effects with white noise that is scaled to a bias stability as white noise of that stability.

    The means of white noise of density N over a period P scatter by N/sqrt(P).
    """
    scaled = [one for one in model if isinstance(one, StabilityRestoration)]
    if not scaled:
        return tuple(model)
    density = scaled[-1].stability * float(np.sqrt(scaled[-1].period))
    kept = [one for one in model if one.role is not Role.NOISE and one not in scaled]
    return (*kept, WhiteNoise(density))


def drift_scores(compared: HeldOutComparison, ensemble: list[LogStatistics]) -> dict[float, float]:
    """Return the energy score of the drift [m] after each horizon [s]; less is better."""
    paths, epochs = np.array([one.path for one in ensemble]), compared.course.epochs()
    at = np.rint((len(epochs) - 1) * HORIZONS).astype(int)
    measured = compared.statistics().path
    return {float(epochs[k]): energy_score(paths[:, k], measured[k]) for k in at}


def width(ensemble: list[LogStatistics]) -> float:
    """Return the width of the band: ratio of the ends of the 95 % band of the Allan deviation, geometric mean.

    It is over all averaging times and axes.
    """
    logs = [np.concatenate([views[0] for views in one.views.values()]) / 2 for one in ensemble]
    low, high = np.quantile(logs, [0.025, 0.975], axis=0)
    return float(np.exp(np.mean(high - low)))


def scores(compared: HeldOutComparison, model: Model, seed: int, count: int) -> dict[str, float]:
    """Return distance from a run with its floor, width of the band, and energy scores of the drift, of one model.

    Parameters
    ----------
    compared
        The run that no model has seen; its own models are not used.
    count
        Number of simulations.
    """
    own = replace(compared, before=model, after=model)
    ensemble = own.simulate("after", seed, range(count))
    apart = combined([distribution(own.statistics(), ensemble, ensemble)])
    drifts = drift_scores(own, ensemble) if own.course is not None else {}
    return {
        "distance": apart.after.value,
        "floor": apart.floor.high,
        "width": width(ensemble),
        **{f"drift_{time:.0f}_s": score for time, score in drifts.items()},
    }
