"""Intervals of what a filter takes of one axis: its estimates, carried through the reduction to N and K."""

from collections.abc import Sequence
from math import exp

import numpy as np

from imugap.effects import RateRamp
from imugap.effects.effect import AxisModel, Effect
from imugap.estimation.cramer_rao import fisher
from imugap.estimation.likelihood import Grid, parameters
from imugap.estimation.report import AxisEstimate
from imugap.estimation.result import ParameterEstimate
from imugap.interchange.conventions import Rule, reduced
from imugap.interchange.limits import Limits
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

STEP = 1e-4
"""Change of a log parameter in a difference quotient."""
MOVES = 1e-6
"""Change of the logarithm of a number, per that of a parameter, above which it depends on it."""
UNKNOWN = 1e-12
"""Information that keeps the matrix of parameters which the log does not separate invertible."""


def of(estimate: AxisEstimate, bounds: Sequence[Effect], rule: Rule) -> Limits:
    """Return the 95 % limits of the reduced model of an axis.

    A number that follows from one parameter has the interval of that parameter. One that follows from several, such
    as standard deviation and time of a Gauss-Markov process, has the interval of its logarithm to first order, from
    the Fisher information of the log. A process that is only bounded has zero for its lower limit.

    Parameters
    ----------
    bounds
        Processes at their upper limit, which stand for what the log does not show.
    """
    present = estimate.fit.present
    if not tuple(present):
        alone = reduced(estimate.axis, AxisModel(tuple(bounds)), rule)
        return Limits.of(alone, (0.0, alone.white), (0.0, alone.walk))
    composition, theta = parameters(present)

    def sizes(theta: np.ndarray) -> np.ndarray:
        """Return the logarithms of N and K, shape (2,); of a K that is zero, zero."""
        one = reduced(estimate.axis, AxisModel((*composition.model(theta), *bounds)), rule)
        return np.log([one.white, one.walk or 1.0])

    slopes = [(sizes(theta + step) - sizes(theta - step)) / (2 * STEP) for step in STEP * np.eye(len(theta))]
    whole = reduced(estimate.axis, AxisModel((*present, *bounds)), rule)
    shown = estimate.fit.shown
    own = [shown[one.key] for one in composition.quantities() if np.count_nonzero(one.direction) == 1]  # as in theta
    ends = (_ends(slope, own, estimate) for slope in np.transpose(slopes))
    white, walk = (
        tuple(value * one for one in end) for value, end in zip((whole.white, whole.walk), ends, strict=True)
    )
    return Limits.of(whole, white, walk)


def _ends(slope: np.ndarray, own: Sequence[ParameterEstimate], estimate: AxisEstimate) -> tuple[float, float]:
    """Return the ends of the interval of a number, over its value.

    Parameters
    ----------
    slope
        Change of its logarithm with those of the parameters, shape (parameters,).
    own
        Estimates of the parameters.
    """
    moved = np.flatnonzero(np.abs(slope) > MOVES)
    if not len(moved):
        return 0.0, 1.0
    if len(moved) == 1:
        one, power = own[moved[0]], slope[moved[0]]
        return (one.low / one.value) ** power, (one.high / one.value) ** power
    reach = float(NORMAL_QUANTILE * np.sqrt(slope @ _covariance(estimate) @ slope))
    return exp(-reach), exp(reach)


def _covariance(estimate: AxisEstimate) -> np.ndarray:
    """Return the covariance of the log parameters of the processes that an axis shows, by the Fisher information."""
    used = estimate.used
    composition, theta = parameters(estimate.fit.present)
    grid = Grid.of(len(used.values), used.interval, used.highest)
    ramp = any(isinstance(one, RateRamp) for one in estimate.fit.model)
    information = used.share * fisher(theta, composition.shapes(grid), grid, ramp)
    return np.linalg.inv(information + UNKNOWN * np.eye(len(theta)))
