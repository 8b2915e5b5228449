"""Transfer of a model to another run: agreement of the parameters of several runs, and explained variance."""

import numpy as np
import pandas as pd

from imugap.effects.effect import AxisModel
from imugap.log import axes
from imugap.model import ErrorModel
from imugap.numerics.fitting import block_bootstrap as bootstrap
from imugap.numerics.normal_quantile import NORMAL_QUANTILE


def motion_effects(model: ErrorModel) -> ErrorModel:
    """Return the model with only the effects that depend on the motion."""
    kept = {axis: tuple(effect for effect in one if effect.of_motion) for axis, one in model.sensors.items()}
    return ErrorModel({axis: AxisModel(effects) for axis, effects in kept.items()})


def explained_variance(
    model: ErrorModel, log: pd.DataFrame, ideal: pd.DataFrame, rng: np.random.Generator
) -> pd.DataFrame:
    """Return the share of the error of a log that the motion-dependent effects of a model explain.

    Parameters
    ----------
    log, ideal
        Canonical logs with the same evenly spaced index.
    rng
        Generator of the circular block bootstrap, for 95 % intervals.

    Returns
    -------
    Index ``axis``; ``rms`` of log minus error-free log, less its mean [unit of the axis]; ``share`` of its variance
    that the effects explain, with ``low`` and ``high``, negative where they increase it.
    """
    simulated, rows = motion_effects(model).simulate(ideal, 0), {}
    for axis in axes(log):
        differences = ((log[axis] - without[axis]).to_numpy() for without in (ideal, simulated))
        before, after = ((difference - difference.mean()) ** 2 for difference in differences)
        found = bootstrap.mean((before - after) / before.mean(), rng)
        rows[axis] = {"rms": float(np.sqrt(before.mean())), "share": found.value, "low": found.low, "high": found.high}
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("axis")


def parameter_agreement(found: pd.DataFrame) -> pd.DataFrame:
    """Compare the estimates of each parameter over several trials.

    Parameters
    ----------
    found
        Columns ``trial``, ``name``, ``axis``, ``parameter``, ``value``, ``low``, ``high`` (95 %).

    Returns
    -------
    A row for each parameter of two or more trials: ``name``, ``axis``, ``parameter``; ``middle``, the mean weighted by
    the inverse squares of the intervals; ``factor``, the Birge ratio of the scatter of the trials to that of the
    intervals (Birge 1932); ``same_sign``, whether all have one sign.
    """
    rows = []
    for key, one in found.dropna(subset=["low", "high"]).groupby(["name", "axis", "parameter"], sort=False):
        if one["trial"].nunique() > 1:
            weight = (2 * NORMAL_QUANTILE / (one["high"] - one["low"])) ** 2
            middle = np.average(one["value"], weights=weight)
            factor = np.sqrt(np.sum(weight * (one["value"] - middle) ** 2) / (len(one) - 1))
            rows.append([*key, middle, factor, np.sign(one["value"]).nunique() == 1])
    return pd.DataFrame(rows, columns=["name", "axis", "parameter", "middle", "factor", "same_sign"])
