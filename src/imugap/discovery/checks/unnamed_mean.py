"""Likelihood of a fit with further columns in its mean that are no effect of the catalogue."""

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.whittle import fit as fit_noise

UNNAMED_MARGIN = 10.0
"""Minimum difference in log-probability for an unnamed alternative over a named effect."""


def likelihood_with(base: AxisFit, columns: np.ndarray) -> float:
    """Return the log-likelihood of a fit with further columns of the error, shape (n, m), and the noise refitted.

    The expected gain of m superfluous columns, m/2, is subtracted.
    """
    _, rest = base.beside(base.whiten(columns))
    bins, noise = base.sequence.bins, base.noise
    power = bins.sums(rest**2) * noise.noise.variance(bins)
    gain = fit_noise(noise.noise, bins, power).log_likelihood - noise.log_likelihood
    return base.log_likelihood + gain - 0.5 * columns.shape[1]
