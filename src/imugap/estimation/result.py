"""Estimates of the parameters of an error model, whatever method made them: values, intervals, verdicts."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from math import isfinite

import pandas as pd

from imugap.effects.effect import AxisModel


class Identifiability(StrEnum):
    """What an interval says."""

    IDENTIFIED = "identified"
    UPPER_BOUND = "upper bound"
    """Zero is within the interval: the log does not show that the process exists, only that it is no larger.

    The upper end keeps the level of two sides, so that the bound errs on the safe side.
    """
    LOWER_BOUND = "lower bound"
    """Infinity is within the interval, as of a correlation time that the log is too short to see the end of."""
    UNDETERMINED = "undetermined"


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter with its interval; SI.

    Attributes
    ----------
    effect, ordinal, parameter
        Name of the effect, its ordinal among its kind, name of the parameter.
    value, low, high
        Estimate and interval; ``low`` is 0 and ``high`` infinite where the log sets no limit.
    error
        Relative standard deviation that the method expects at the estimate.
    verdict
        What the interval says.
    """

    effect: str
    ordinal: int
    parameter: str
    value: float
    low: float
    high: float
    error: float
    verdict: Identifiability


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Attributes
    ----------
    model
        The estimates as a model; a process that the log does not need has density zero.
    estimates
        One for each parameter, and for the driving PSD of each Gauss-Markov process (ordered by correlation time).
    objective
        What the method makes best: a log-likelihood at its highest, a weighted sum of squares at its lowest.
    converged
        Whether the gradient vanishes at the estimate.
    """

    model: AxisModel
    estimates: tuple[ParameterEstimate, ...]
    objective: float
    converged: bool

    def table(self) -> pd.DataFrame:
        """Return the estimates, index ``effect``, ``ordinal``, ``parameter``."""
        return pd.DataFrame(map(asdict, self.estimates)).set_index(["effect", "ordinal", "parameter"])


def identifiability(low: float, high: float) -> Identifiability:
    """Return what an interval of a parameter that cannot be negative says."""
    if low > 0:
        return Identifiability.IDENTIFIED if isfinite(high) else Identifiability.LOWER_BOUND
    return Identifiability.UPPER_BOUND if isfinite(high) else Identifiability.UNDETERMINED
