"""Tail of the chi-square law.

``scipy.stats`` has it too, but takes longer to import than all else that an effect or a filter needs.
"""

import numpy as np
from scipy.special import chdtrc


def log_tail(value: float, freedom: int) -> float:
    """Return the logarithm of the probability of a value at least as large; minus infinity where it underflows."""
    with np.errstate(divide="ignore"):
        return float(np.log(chdtrc(freedom, value)))
