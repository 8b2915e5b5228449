"""Whether what was found on several motions of one device agrees, and what the model of one explains of another."""

import numpy as np
import pandas as pd
from scipy.stats import norm

from imugap.effects.effect import AxisModel
from imugap.log import axes
from imugap.model import ErrorModel
from imugap.numerics import block_bootstrap as bootstrap


def inertial(model: ErrorModel) -> ErrorModel:
    """Return the model with those of its effects alone that answer the motion."""
    kept = {axis: tuple(effect for effect in one if effect.of_motion) for axis, one in model.sensors.items()}
    return ErrorModel({axis: AxisModel(effects) for axis, effects in kept.items()})


def explained(model: ErrorModel, log: pd.DataFrame, ideal: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Return how much of the difference of a log and its error-free log the effects explain that answer the motion.

    Parameters
    ----------
    log, ideal
        Canonical logs with the same evenly spaced index.
    rng
        Of the circular block bootstrap, for intervals of 95 %.

    Returns
    -------
    Index ``axis``; ``rms`` of the difference less its mean [unit of the axis], and the share of its variance that goes
    with the effects taken out: ``share``, ``low``, ``high``, below zero where they add to it.
    """
    simulated, rows = inertial(model).simulate(ideal, 0), {}
    for axis in axes(log):
        gaps = ((log[axis] - without[axis]).to_numpy() for without in (ideal, simulated))
        before, after = ((gap - gap.mean()) ** 2 for gap in gaps)
        found = bootstrap.mean((before - after) / before.mean(), rng)
        rows[axis] = {"rms": float(np.sqrt(before.mean())), "share": found.value, "low": found.low, "high": found.high}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("axis")


def agreement(found: pd.DataFrame) -> pd.DataFrame:
    """Return whether the trials that give a parameter agree on it.

    Parameters
    ----------
    found
        Columns ``trial``, ``name``, ``axis``, ``parameter``, ``value``, ``low``, ``high`` (95 %).

    Returns
    -------
    A row for each parameter of two trials or more: ``name``, ``axis``, ``parameter``; ``middle``, the mean weighted by
    the inverse squares of the intervals; ``factor`` by which the trials scatter more than the intervals say (Birge
    1932); whether all have the ``same_sign``.
    """
    rows = []
    for key, one in found.dropna(subset=["low", "high"]).groupby(["name", "axis", "parameter"], sort=False):
        if one["trial"].nunique() > 1:
            weight = (2 * norm.ppf(0.975) / (one["high"] - one["low"])) ** 2
            middle = np.average(one["value"], weights=weight)
            factor = np.sqrt(np.sum(weight * (one["value"] - middle) ** 2) / (len(one) - 1))
            rows.append([*key, middle, factor, np.sign(one["value"]).nunique() == 1])
    return pd.DataFrame(rows, columns=["name", "axis", "parameter", "middle", "factor", "same_sign"])
