"""Tail of the chi-square law, and its quantile in the plane.

``scipy.stats`` has it too, but takes longer to import than all else that an effect or a filter needs.
"""

import numpy as np
from scipy.special import chdtrc


def log_tail(value: float, freedom: int) -> float:
    """Return the logarithm of the probability of a value at least as large; minus infinity where it underflows."""
    with np.errstate(divide="ignore"):
        return float(np.log(chdtrc(freedom, value)))


def squared_radius(probability: float) -> float:
    """Return the squared radius of the ellipse that holds a normal variable in the plane with this probability.

    In units of the standard deviations: the quantile of chi-square with two degrees of freedom.
    """
    return float(-2 * np.log(1 - probability))
