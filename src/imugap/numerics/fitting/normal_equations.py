"""Normal equations of few unknowns, solved in units in which each has a precision of one."""

import numpy as np
from numba import njit


@njit(cache=True)
def solution(precision, score, least):
    """Return the unknowns, shape (m,), of least squares; those of least size where the equations leave them open.

    They are no numbers where the right side has one that is not finite. Compiled, as the call of a solver takes longer
    than the solution.

    Parameters
    ----------
    precision, score
        Matrix, shape (m, m), and right side, shape (m,).
    least
        Singular value, over the largest one, below which a direction is open.
    """
    if not len(score) or not np.isfinite(score).all():
        return np.full(len(score), np.nan)
    units = np.sqrt(np.diag(precision))
    units[units == 0] = 1.0
    return np.linalg.lstsq(precision / np.outer(units, units), score / units, least)[0] / units
