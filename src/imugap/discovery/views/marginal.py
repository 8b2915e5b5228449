"""View of the values: histogram of the whitened residual against the normal distribution."""

import numpy as np
from scipy.stats import norm

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.views.curve import Curve

CELL_WIDTH = 0.25
"""Width of a cell [standard deviations]."""
MIN_EXPECTED = 5.0
"""Expected number of samples in the outermost, open cells."""


def of_marginal(fit: AxisFit) -> Curve:
    """Return the counts of the whitened residual in cells against the normal distribution (Anscombe 1948, score).

    The unit of the location is the standard deviation; the first and the last cell are open. The cells depend
    on the length of the log only, not on the number of flawed samples, which differs between replicates.
    """
    values = fit.whitened[~fit.sequence.flawed]
    reach = CELL_WIDTH * max(int(norm.isf(min(MIN_EXPECTED / len(fit.whitened), 0.25)) / CELL_WIDTH), 1)
    edges = np.arange(-reach, reach + CELL_WIDTH / 2, CELL_WIDTH)
    index = np.clip(np.floor((values + reach) / CELL_WIDTH), -1, len(edges) - 1).astype(np.int64) + 1
    counts = np.bincount(index, minlength=len(edges) + 1)
    expected = len(values) * np.diff(np.r_[0.0, norm.cdf(edges), 1.0])
    statistic = 2 * (np.sqrt(counts + 0.375) - np.sqrt(expected + 0.375))
    low, high = np.r_[min(values.min(), -reach), edges], np.r_[edges, max(values.max(), reach)]
    return Curve("marginal", fit.sequence.conditions.axis, low, high, "1", statistic)
