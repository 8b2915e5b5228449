"""The methods of estimation that the study compares, behind one signature: a sequence in, a fit out."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from imugap.estimation import allan_slopes as piecewise
from imugap.estimation import maximum_likelihood
from imugap.estimation.gmwm import estimator as indirect
from imugap.estimation.gmwm.estimator import Weighting
from imugap.estimation.result import Fit

Method = Callable[[np.ndarray, float, Sequence[type]], Fit]

METHODS: dict[str, Method] = {
    "allan": partial(piecewise.fit, separated=False),
    "allan_separated": piecewise.fit,
    "indirect_interval": partial(indirect.fit, weighting=Weighting.INTERVAL),
    "indirect_diagonal": partial(indirect.fit, weighting=Weighting.DIAGONAL),
    "indirect_full": partial(indirect.fit, weighting=Weighting.FULL),
    "likelihood": maximum_likelihood.fit,
}
"""Allan readings (the top of a Gauss-Markov process as it stands, or without white noise); wavelet variances by weight;
the exact likelihood."""
