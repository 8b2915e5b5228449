"""Estimation methods that the study compares, with one signature: (samples, interval, kinds) to a fit."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from imugap.estimation import maximum_likelihood
from imugap.estimation.gmwm import estimator
from imugap.estimation.gmwm.estimator import GmwmOptions, Weighting
from imugap.estimation.result import Fit
from imugap.estimation.variances import allan_slopes

Estimator = Callable[[np.ndarray, float, Sequence[type]], Fit]

METHODS: dict[str, Estimator] = {
    "allan": partial(allan_slopes.fit, separated=False),
    "allan_separated": allan_slopes.fit,
    "indirect_interval": partial(estimator.fit, options=GmwmOptions(weighting=Weighting.INTERVAL)),
    "indirect_diagonal": partial(estimator.fit, options=GmwmOptions(weighting=Weighting.DIAGONAL)),
    "indirect_full": partial(estimator.fit, options=GmwmOptions(weighting=Weighting.FULL)),
    "likelihood": maximum_likelihood.fit,
}
"""Slopes of the Allan deviation (the peak of a Gauss-Markov process read with or without the white noise on it);
wavelet moments by weighting; maximum likelihood."""
