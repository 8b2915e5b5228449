"""Error models from performance indices: those that the study compares (He et al. 2023, eqs. 10-18).

A contender maps the indices of one axis (symbol -> value, SI) to an :class:`~imugap.model.AxisModel`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from imugap.effects import Bias, GaussMarkov, RandomWalk, StabilityRestoration, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.model import ErrorModel


@dataclass(frozen=True)
class AxisIndices:
    """Input of a contender for one axis: indices over the runs, averaging period, Allan curve.

    Attributes
    ----------
    bias, stability, repeatability, white, flicker, walk
        B, Bs, Br, N (the source's W), B of the Allan curve (the source's Bi), K; SI.
    period
        Averaging period P of the bias stability [s].
    curve
        Allan deviation over the runs: index ``tau`` [s], columns ``deviation`` and ``error`` (relative).
    """

    bias: float
    stability: float
    repeatability: float
    white: float
    flicker: float
    walk: float
    period: float
    curve: pd.DataFrame


def bias_only(of: AxisIndices) -> AxisModel:
    """Return the constant bias alone, the baseline of the comparison."""
    return AxisModel((Bias(of.bias),))


def white(of: AxisIndices) -> AxisModel:
    """Return bias + white noise (eq. 10)."""
    return Bias(of.bias) + WhiteNoise(of.white)


def white_turn_on(of: AxisIndices) -> AxisModel:
    """Return white noise + turn-on bias: restoration without its scaling, to isolate the effect of the scaling."""
    return white(of) + TurnOnBias(of.repeatability)


def rate_random_walk(of: AxisIndices) -> AxisModel:
    """Return white noise + random walk (eq. 11), started at the bias.

    The printed recursion of b_k lacks b_{k-1}; with it, b is the random walk of the cited Claasen et al. (2013). The
    printed model has no constant either; b_0 is set to the bias, as in every other contender.
    """
    return Bias(of.bias) + WhiteNoise(of.white) + RandomWalk(of.walk)


def method_a(of: AxisIndices) -> AxisModel:
    """Return Method A (eq. 12; Woodman 2007): slow drift of increments Bs sqrt(dt/P)."""
    return Bias(of.bias) + WhiteNoise(of.white) + RandomWalk(of.stability / np.sqrt(of.period))


def method_b(of: AxisIndices) -> AxisModel:
    """Return Method B (eq. 13; Jing et al. 2021): slow drift of increments Bi sqrt(dt)."""
    return Bias(of.bias) + WhiteNoise(of.white) + RandomWalk(of.flicker)


def restoration(of: AxisIndices) -> AxisModel:
    """Return the statistical restoration (eqs. 14-18)."""
    return (
        Bias(of.bias)
        + TurnOnBias(of.repeatability)
        + WhiteNoise(of.white)
        + StabilityRestoration(of.stability, of.period)
    )


def nbk(of: AxisIndices) -> AxisModel:
    """Return N + B + K in state space: white noise, one Gauss-Markov state for the floor, random walk.

    With the correlation time the Gauss-Markov process peaks at the floor of the curve (Farrell et al. 2022, eq. 38);
    the three variances are the non-negative least-squares fit of the Allan variance, which is linear in them. The
    turn-on bias is included.
    """
    known = of.curve[of.curve["error"] < 0.25]
    tau, observed = known.index.to_numpy(), known["deviation"].to_numpy() ** 2
    unit = GaussMarkov(1.0, known["deviation"].idxmin() / FLAT_TOP)
    columns = [process.allan_variance(tau) for process in (WhiteNoise(1.0), unit, RandomWalk(1.0))]
    weights = 1 / (observed * np.maximum(known["error"].to_numpy(), 0.01))
    scale = np.array([column.max() for column in columns])
    variances, _ = nnls((np.array(columns) / scale[:, None] * weights).T, observed * weights)
    density, std, density_k = np.sqrt(variances / scale)
    return (
        Bias(of.bias)
        + TurnOnBias(of.repeatability)
        + WhiteNoise(density)
        + GaussMarkov(std, unit.correlation_time)
        + RandomWalk(density_k)
    )


CONTENDERS: dict[str, Callable[[AxisIndices], AxisModel]] = {
    builder.__name__: builder
    for builder in (bias_only, white, white_turn_on, rate_random_walk, method_a, method_b, restoration, nbk)
}

READ = {
    "white": ("N",),
    "white_turn_on": ("N",),
    "rate_random_walk": ("N", "K"),
    "method_a": ("N",),
    "method_b": ("N", "B"),
    "restoration": ("N",),
}
"""The coefficients of the Allan curve that a contender takes as values; where one is refused, it takes the bound."""

SOURCE = ("method_a", "method_b", "restoration")
"""Contenders in the tables of the source."""


def averaged(curves: pd.DataFrame) -> pd.DataFrame:
    """Return the Allan curves of a device for :func:`fit`: variances averaged over its runs.

    The relative error decreases with the square root of their number. ``curves`` has columns ``axis``, ``tau``,
    ``deviation`` and ``error``, a row for each run.
    """
    grouped = curves.assign(square=curves["deviation"] ** 2).groupby(["axis", "tau"], sort=False)
    mean = grouped.agg(square=("square", "mean"), error=("error", "mean"))
    error = mean["error"] / np.sqrt(grouped.size())
    return mean.assign(deviation=np.sqrt(mean["square"]), error=error).reset_index()


def bounded(indices: pd.DataFrame) -> dict[str, int]:
    """Count the axes on which each contender takes an upper bound for a value, from the indices of a device.

    A bound is the most that the device can have, and may be far above what it has: the drift of such a contender says
    how large the process can be, not how large it is. Contenders without such an axis are left out.
    """
    refused = indices[~indices["holds"].astype(bool)]
    counts = {name: refused.loc[refused["symbol"].isin(of), "axis"].nunique() for name, of in READ.items()}
    return {name: int(count) for name, count in counts.items() if count}


def fit(name: str, indices: pd.DataFrame, curves: pd.DataFrame, period: float) -> ErrorModel:
    """Build contender ``name`` for a device.

    Parameters
    ----------
    indices
        Table of :func:`imugap.estimation.indices.over_runs`.
    curves
        Allan curves averaged over the runs: columns ``axis``, ``tau``, ``deviation``, ``error``.
    period
        Averaging period of the bias stability [s].
    """
    axes = {}
    for axis, group in indices.groupby("axis", sort=False):
        value = group.set_index("symbol")["value"]
        curve = curves[curves["axis"] == axis].set_index("tau")
        of = AxisIndices(
            value["bias"], value["stability"], value.get("repeatability", 0.0), value["N"], value["B"], value["K"],
            period, curve,
        )  # fmt: skip
        axes[axis] = CONTENDERS[name](of)
    return ErrorModel(axes)
