"""Proper scores and ranks of ensemble predictions.

Sources: T. Gneiting, A. E. Raftery, Strictly proper scoring rules, prediction, and estimation, J. Am. Stat. Assoc. 102
(2007) 359-378, section 4.3; C. A. T. Ferro, Fair scores for ensemble forecasts, Q. J. R. Meteorol. Soc. 140 (2014)
1917-1923; T. L. Thorarinsdottir, M. Scheuerer, C. Heinz, Assessing the calibration of high-dimensional ensemble
forecasts using rank histograms, J. Comput. Graph. Stat. 25 (2016) 105-122.
"""

import numpy as np


def energy_score(draws: np.ndarray, outcome: np.ndarray) -> float:
    """Return the energy score; less is better. For one number it is the continuous ranked probability score.

    ``mean |x - y| - sum |x - x'| / (2 m (m - 1))``, fair for a small number m of draws (Ferro 2014).

    Parameters
    ----------
    draws
        Shape (m, k).
    outcome
        Outcome, shape (k,).
    """
    count = len(draws)
    apart = np.linalg.norm(draws[:, None] - draws[None], axis=2).sum() / (2 * count * (count - 1))
    return float(np.linalg.norm(draws - outcome, axis=1).mean() - apart)


def central_rank(draws: np.ndarray, outcome: np.ndarray) -> float:
    """Return the centre-outward rank of the outcome: 0 in the middle of the draws, 1 beyond all of them.

    Draws and outcome are ranked by their Mahalanobis distance from their mean; for a calibrated prediction all ranks
    have the same probability (Thorarinsdottir et al. 2016).
    """
    together = np.vstack([outcome, draws])
    off = together - together.mean(axis=0)
    distance = np.einsum("ni,ni->n", off, np.linalg.solve(off.T @ off, off.T).T)
    return float((np.count_nonzero(distance[1:] < distance[0]) + 0.5) / len(together))
