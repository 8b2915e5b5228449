"""Schemes of the attitude experiment: sources of the parameters of the filter's error model.

After Liu, Ren and Li (2016): scheme 1 reads them from the Allan curve, scheme 2 estimates them from wavelet variances.
Likelihood is a third scheme. All use the same static log and the same processes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pandas as pd

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.methods import METHODS, Estimator
from imugap.estimation.result import Fit, Identifiability
from imugap.log import ACCEL, GYRO, interval
from imugap.model import ErrorModel

SCHEMES: dict[str, Estimator] = {
    "allan": METHODS["allan"],
    "indirect": METHODS["indirect_full"],
    "likelihood": METHODS["likelihood"],
}
"""Scheme to method of estimation."""
KINDS = dict.fromkeys(GYRO, (WhiteNoise, GaussMarkov)) | dict.fromkeys(ACCEL, (WhiteNoise, RandomWalk))
"""Processes of each axis, as in the source."""


def fit(log: pd.DataFrame, scheme: str) -> dict[str, Fit]:
    """Fit every axis of a log at rest."""
    step = interval(log)
    return {axis: SCHEMES[scheme](log[axis].to_numpy(), step, kinds) for axis, kinds in KINDS.items()}


def fitted(static: pd.DataFrame, minutes: Sequence[int]) -> tuple[pd.DataFrame, dict[int, dict[str, dict]]]:
    """Fit the first ``minutes`` of a static log by every scheme.

    Returns the table of estimates, and the filter's error model as plain data by length [min] and scheme.
    """
    tables, models = [], {}
    for length in minutes:
        begun = static[static.index < 60 * length]
        fits = {scheme: fit(begun, scheme) for scheme in SCHEMES}
        tables += [table(found, minutes=length, scheme=scheme) for scheme, found in fits.items()]
        models[length] = {scheme: filter_model(found).to_mapping() for scheme, found in fits.items()}
    return pd.concat(tables), models


def filter_model(fits: Mapping[str, Fit]) -> ErrorModel:
    """Return the error model for the filter, by one rule for all schemes.

    A parameter with only an upper bound enters with that bound: a pessimistic filter loses little, an optimistic one
    becomes inconsistent. Every other parameter enters with its value.
    """
    return ErrorModel({axis: _cautious(one) for axis, one in fits.items()})


def _cautious(fit: Fit) -> AxisModel:
    effects = []
    for effect in fit.model:
        bounded = [
            one
            for one in fit.estimates
            if one.effect == effect.name
            and one.parameter in effect.parameters()
            and one.verdict is Identifiability.UPPER_BOUND
        ]
        effects.append(replace(effect, **{one.parameter: one.high for one in bounded}))
    return AxisModel(tuple(effects))


def table(fits: Mapping[str, Fit], **labels: object) -> pd.DataFrame:
    """Return the estimates of all axes as rows, with a column for each of ``labels``."""
    rows = [one.table().reset_index().assign(axis=axis, **labels) for axis, one in fits.items()]
    return pd.concat(rows, ignore_index=True)
