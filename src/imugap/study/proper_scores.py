"""How well draws of a prediction foretell what came: proper scores, and where among the draws it lies.

Sources: T. Gneiting, A. E. Raftery, Strictly proper scoring rules, prediction, and estimation, J. Am. Stat. Assoc. 102
(2007) 359-378, section 4.3; C. A. T. Ferro, Fair scores for ensemble forecasts, Q. J. R. Meteorol. Soc. 140 (2014)
1917-1923; T. L. Thorarinsdottir, M. Scheuerer, C. Heinz, Assessing the calibration of high-dimensional ensemble
forecasts using rank histograms, J. Comput. Graph. Stat. 25 (2016) 105-122.
"""

import numpy as np


def energy_score(draws: np.ndarray, came: np.ndarray) -> float:
    """Return the energy score; of one number it is the continuous ranked probability score, and less is better.

    ``mean |x - y| - sum |x - x'| / (2 m (m - 1))``, fair to a small number m of draws (Ferro 2014).

    Parameters
    ----------
    draws
        Shape (m, k).
    came
        What came, shape (k,).
    """
    count = len(draws)
    apart = np.linalg.norm(draws[:, None] - draws[None], axis=2).sum() / (2 * count * (count - 1))
    return float(np.linalg.norm(draws - came, axis=1).mean() - apart)


def central_rank(draws: np.ndarray, came: np.ndarray) -> float:
    """Return where in the ranking from the middle outward what came lies: 0 in the middle, 1 beyond all draws.

    Draws and what came are ranked together by their distance from the middle of all, in the metric of their covariance;
    where the prediction is right all ranks have the same chance (Thorarinsdottir et al. 2016).
    """
    together = np.vstack([came, draws])
    off = together - together.mean(axis=0)
    distance = np.einsum("ni,ni->n", off, np.linalg.solve(off.T @ off, off.T).T)
    return float((np.count_nonzero(distance[1:] < distance[0]) + 0.5) / len(together))
