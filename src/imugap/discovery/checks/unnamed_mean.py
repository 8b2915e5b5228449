"""How likely a log is with something more in its mean that has no name, its noise fitted anew."""

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.whittle import fit as fit_noise

UNNAMED_MARGIN = 10.0
"""Log-probability by which something without a name has to be surer than what has one."""


def likelihood_with(base: AxisFit, way: np.ndarray) -> float:
    """Return the log-likelihood of a fit with columns of the error, shape (n, m), more, its noise fitted anew.

    Less what columns gain by chance on average.
    """
    _, rest = base.beside(base.whiten(way))
    bins, noise = base.sequence.bins, base.noise
    power = bins.sums(rest**2) * noise.noise.variance(bins)
    gain = fit_noise(noise.noise, bins, power).log_likelihood - noise.log_likelihood
    return base.log_likelihood + gain - 0.5 * way.shape[1]
