"""Likelihood-ratio test of an effect against a periodic term of any shape, which can imitate steps and slow noise."""

import numpy as np

from imugap.discovery.checks.misfit import Misfit, log_p_against
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, log_chance
from imugap.discovery.unnamed import periodic


def effect_against_periodic(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Test an effect against a periodic term (a fundamental and its harmonics) in its place."""
    own, without = search.likelihood_ratio(fit, key)
    alternative = log_chance(periodic.gain(without), periodic.PARAMETERS) + np.log(periodic.TRIALS)
    return Misfit("a wave of one period explains it better", log_p_against(own.log_p, alternative, search.log_alpha))
