"""Distance that an effect makes, as discovery measures it, for what an export leaves out."""

from math import inf

import numpy as np

from imugap import log
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel

SEED, SIMULATIONS = 0, 20
"""Seed and number of the simulations of each model."""


def distance(full: AxisModel, without: AxisModel, conditions: Conditions) -> float:
    """Return the distance in distribution of a log at rest of a model from simulations of it without an effect.

    The logs have the length of ``conditions``; their second half is compared. 1 is the distance of two logs of one
    model. It is infinite if the simulations without the effect do not differ from one another, as without noise.
    """
    # takes seconds, and most exports need none
    from imugap.discovery.evaluation.distance import HeldOutComparison, have_scatter

    axis = conditions.axis
    models = {"after": ErrorModel({axis: full}), "before": ErrorModel({axis: without})}
    ideal = log.from_samples({axis: np.zeros(len(conditions))}, conditions.interval)
    measured = models["after"].simulate(ideal, SEED, "left out", "log")
    compared = HeldOutComparison(measured, conditions.interval * (len(conditions) // 2), **models)
    if not have_scatter(compared.simulate("before", SEED, range(SIMULATIONS))):
        return inf
    return float(np.sqrt(np.median(compared.distribution(SEED, SIMULATIONS).before)))
