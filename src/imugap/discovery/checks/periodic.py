"""Likelihood-ratio test of an effect against a periodic term of any shape, which can imitate steps and slow noise."""

import numpy as np

from imugap.discovery.checks.misfit import Misfit, log_p_against
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, log_chance
from imugap.discovery.unnamed import periodic as waves


def effect_against_periodic(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Test an effect against a periodic term (a fundamental and its harmonics) in its place."""
    own, without = search.likelihood_ratio(fit, key)
    wave = log_chance(waves.gain(without), waves.MORE) + np.log(waves.TRIALS)
    return Misfit("a wave of one period explains it better", log_p_against(own.log_p, wave, search.log_alpha))
