"""Does it repeat itself? A wave of one period, in whatever shape, jumps and wanders as steps and slow noise do."""

import numpy as np

from imugap.discovery.checks.misfit import Misfit, log_p_against
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, log_chance
from imugap.discovery.unnamed import periodic as waves


def effect_against_periodic(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Weigh a wave in the place of an effect."""
    own, without = search.likelihood_ratio(fit, key)
    wave = log_chance(waves.gain(without), waves.MORE) + np.log(waves.TRIALS)
    return Misfit("a wave of one period explains it better", log_p_against(own.log_p, wave, search.log_alpha))
