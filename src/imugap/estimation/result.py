"""Result of an estimation, common to all methods: the fitted model, its parameters, their intervals."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from math import isfinite

import pandas as pd

from imugap.effects.effect import AxisModel


class Identifiability(StrEnum):
    """Class of a parameter by its confidence interval."""

    IDENTIFIED = "identified"
    UPPER_BOUND = "upper bound"
    """Zero is within the interval: the log bounds the process from above, and does not show that it exists.

    The upper end is that of the two-sided interval, so that the bound is conservative.
    """
    LOWER_BOUND = "lower bound"
    """Infinity is within the interval, as for a correlation time longer than the log."""
    UNDETERMINED = "undetermined"


@dataclass(frozen=True)
class ParameterEstimate:
    """Parameter of one effect with its confidence interval; SI.

    Attributes
    ----------
    effect, ordinal, parameter
        Name of the effect, its number among effects of the same kind (from 1), name of the parameter.
    value, low, high
        Estimate and limits of the interval; ``low`` is 0 and ``high`` infinite where the log sets no limit.
    error
        Expected relative standard deviation of the estimate.
    verdict
        Class of the parameter by its interval.
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
    """Fitted model of one axis.

    Attributes
    ----------
    model
        Estimated model; a process without which the fit is as good has density zero.
    estimates
        One for each parameter, and for the driving PSD of each Gauss-Markov process (ordered by correlation time).
    objective
        Optimum of the criterion: the maximum of a log-likelihood, or the minimum of a weighted sum of squares.
    converged
        Whether the gradient is zero at the estimate.
    """

    model: AxisModel
    estimates: tuple[ParameterEstimate, ...]
    objective: float
    converged: bool

    @property
    def present(self) -> AxisModel:
        """Return the random processes that are not zero."""
        return AxisModel(tuple(one for one in self.model.stochastic() if all(one.parameters().values())))

    @property
    def shown(self) -> dict[tuple[str, int, str], ParameterEstimate]:
        """Return the estimates of what is not zero by effect, number among those of its kind, and parameter."""
        absent = {(one.effect, one.ordinal) for one in self.estimates if not one.value}
        kept = [one for one in self.estimates if (one.effect, one.ordinal) not in absent]
        numbers = {
            (one.effect, one.ordinal): one.ordinal - sum(gone == one.effect and k < one.ordinal for gone, k in absent)
            for one in kept
        }
        return {(one.effect, numbers[one.effect, one.ordinal], one.parameter): one for one in kept}

    def table(self) -> pd.DataFrame:
        """Return the estimates, index ``effect``, ``ordinal``, ``parameter``."""
        return pd.DataFrame(map(asdict, self.estimates)).set_index(["effect", "ordinal", "parameter"])


def identifiability(low: float, high: float) -> Identifiability:
    """Classify a non-negative parameter by the limits of its interval."""
    if low > 0:
        return Identifiability.IDENTIFIED if isfinite(high) else Identifiability.LOWER_BOUND
    return Identifiability.UPPER_BOUND if isfinite(high) else Identifiability.UNDETERMINED
