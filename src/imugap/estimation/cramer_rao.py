"""Fisher information of a log of given length about the parameters of its error model, and the Cramer-Rao bound."""

import numpy as np
import pandas as pd

from imugap.effects.effect import AxisModel
from imugap.estimation.likelihood import Grid, core_matrix, decompose, parameters


def fisher(theta: np.ndarray, shapes: np.ndarray, grid: Grid, ramp: bool = False) -> np.ndarray:
    """Return the expected information in the log parameters, tr(V^-1 V_i V^-1 V_j)/2, of the contrasts of a log.

    V is the covariance of the cosine coefficients and V_i its derivative: exact but for the binning, mean (and ramp)
    unknown (Kay 1993, Fundamentals of Statistical Signal Processing, eq. 3.32).

    Parameters
    ----------
    theta, shapes
        Log parameters and spectral shapes (:class:`imugap.estimation.likelihood.Composition`).
    """
    spectrum = decompose(theta, shapes, grid.square, grid.count, grid.interval, ramp)
    return 0.5 * sum(_parity(parity, spectrum, grid) for parity in (0, 1))


def _parity(parity: int, spectrum: tuple[np.ndarray, ...], grid: Grid) -> np.ndarray:
    """Return tr(V^-1 V_i V^-1 V_j) of one parity, with V^-1 = 1/d + (u/d) core^-1 (u/d)' and V_i = D_i + Q C_i Q'.

    Q are the Gauss-Markov columns and their derivatives. Columns are kept without their factor a; every product of
    two of them is weighted with the leverage, the sum of a^2.
    """
    first, last = (grid.odd, len(grid.index)) if parity else (0, grid.odd)
    bins = slice(first, last)
    diagonal, slopes, columns, column_slopes, weights, weight_slopes = spectrum
    markov = len(column_slopes)
    ranks = len(columns) if parity else markov
    number, leverage, d = grid.number[bins], grid.leverage[bins], diagonal[bins]
    ratio, lever = slopes[:, bins] / d, leverage / d
    result = (ratio * number) @ ratio.T
    if not ranks:
        return result
    core, _ = core_matrix(diagonal, columns, weights[parity], grid.leverage, grid.leverage[None], first, last, ranks)
    inverse, u = np.linalg.inv(core), columns[:ranks, bins]
    result += 2 * (ratio * (lever * np.einsum("im,ij,jm->m", u, inverse, u))) @ ratio.T
    pulls = inverse @ np.einsum("am,im,bm->iab", u, ratio * lever, u)
    result += np.einsum("iab,jba->ij", pulls, pulls)
    basis = np.concatenate([columns[:markov, bins], column_slopes[:, bins]])
    solved = (basis + (basis * lever @ u.T) @ inverse @ u) / d
    middle = _middle(np.exp(weights[parity]), weight_slopes[parity], len(ratio))
    diagonals = np.einsum("am,im,bm->iab", solved, ratio * lever * d**2, solved)
    cross = np.einsum("iab,jba->ij", middle, diagonals)
    low = middle @ (basis * leverage @ solved.T)
    return result + cross + cross.T + np.einsum("iab,jba->ij", low, low)


def _middle(weight: np.ndarray, weight_slope: np.ndarray, size: int) -> np.ndarray:
    """Return C_i of all parameters, shape (size, 2 processes, 2 processes): the derivative of -b u u'."""
    markov = len(weight)
    middle = np.zeros((size, 2 * markov, 2 * markov))
    for i in range(markov):
        std = size - 2 * markov + 2 * i
        middle[std, i, i] = -2 * weight[i]
        middle[std + 1, i, i] = -weight[i] * weight_slope[i]
        middle[std + 1, i, markov + i] = middle[std + 1, markov + i, i] = -weight[i]
    return middle


def bound(model: AxisModel, interval: float, count: int, ramp: bool = False) -> pd.Series:
    """Return the Cramer-Rao bound of every parameter of the stochastic effects of ``model``, as a relative deviation.

    Parameters
    ----------
    interval, count
        Sampling interval [s] and number of samples.
    ramp
        Whether a ramp is unknown besides the mean.

    Returns
    -------
    pandas.Series
        Standard deviation of the best unbiased estimate over the value; index ``effect``, ``ordinal``, ``parameter``.
    """
    composition, theta = parameters(model)
    grid = Grid.of(count, interval)
    covariance = np.linalg.inv(fisher(theta, composition.shapes(grid), grid, ramp))
    rows = composition.quantities()
    names = pd.MultiIndex.from_tuples([row.key for row in rows], names=["effect", "ordinal", "parameter"])
    return pd.Series([np.sqrt(row.direction @ covariance @ row.direction) for row in rows], index=names, name="bound")
