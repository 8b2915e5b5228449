"""Likelihood-ratio test of an effect against a periodic term of any shape, which can imitate steps and slow noise."""

import numpy as np

from imugap.discovery.checks.misfit import Misfit, log_p_against
from imugap.discovery.search.search import Candidate, log_p_of_gain
from imugap.discovery.unnamed import periodic


def effect_against_periodic(candidate: Candidate) -> Misfit:
    """Test an effect against a periodic term (a fundamental and its harmonics) in its place."""
    alternative = log_p_of_gain(periodic.gain(candidate.without), periodic.PARAMETERS) + np.log(periodic.TRIALS)
    log_p = log_p_against(candidate.trial.log_p, alternative, candidate.search.log_alpha)
    return Misfit("a wave of one period explains it better", log_p)
