"""Likelihood-ratio test of steps of one sign, or of slow noise, against one gradual transition between two levels.

Three steps approximate any gradual transition, and slow noise follows it.
"""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Candidate, coloured, log_p_of_gain, without

REASON = "one gradual transition explains it better"
WIDTHS, MAX_EVALUATIONS = np.geomspace(0.003, 0.2, 7), 60
"""Start values of the width of a transition over the duration, and maximum evaluations of the optimiser."""
MIN_START_GAIN = 0.5
"""Minimum gain of the best start value, as a fraction of that of the named effects, for the optimisation to run."""
PARAMETERS = 3
"""Number of parameters of a transition: size, time and width."""
TRIALS = 100.0
"""Upper bound on the independent transitions in a log (Bonferroni)."""


def transition_misfits(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Test successive steps of one sign, and slow noise together with all steps, against a gradual transition."""
    steps = sorted((one for one in added if one.effect.event), key=lambda one: one.effect.time)
    slow = [one for one in added if coloured(one.effect)]
    ways = (list(way) for _, way in groupby(steps, lambda one: one.effect.step > 0))
    misfits = {tuple(way): _against_transition(way) for way in ways if len(way) > 1}
    if slow:
        misfits[*steps, *slow] = _against_transition([*steps, *slow], UNNAMED_MARGIN)
    return {one: Misfit(REASON, log_p) for some, log_p in misfits.items() if log_p < MAX_LOG_P for one in some}


def _against_transition(some: Sequence[Candidate], margin: float = 0.0) -> float:
    """Return the log-probability of some effects against a transition in their place, relative to the level."""
    fit = some[0].fit
    bare = without(fit, some)
    gain, more = fit.log_likelihood - bare.log_likelihood, fit.description.size() - bare.description.size()
    named = log_p_of_gain(gain, more) + sum(np.log(one.trial.trials) for one in some)
    best = _fit_transition(bare, MIN_START_GAIN * gain)
    if best is None:
        return 0.0
    other = log_p_of_gain(likelihood_with(bare, best) - bare.log_likelihood, PARAMETERS) + np.log(TRIALS)
    return log_p_against(named, other + margin, some[0].search.log_alpha)


def _fit_transition(bare: AxisFit, least: float) -> np.ndarray | None:
    """Maximise the likelihood gain of a transition; return its column, shape (n, 1), or None below ``least``."""
    time = bare.sequence.conditions.time
    duration = np.ptp(time)

    def gain(place: np.ndarray) -> float:
        return float(bare.gains(bare.whiten(_transition(time, *place)))[0])

    begin = max(((time[np.argmax(bare.steps.gains)], np.log(width * duration)) for width in WIDTHS), key=gain)
    if gain(begin) < least:
        return None
    bounds = [(time[0], time[-1]), tuple(np.log(WIDTHS[[0, -1]] * duration))]
    simplex = np.array([begin, [begin[0] + np.exp(begin[1]), begin[1]], [begin[0], begin[1] + 0.5]])
    options = {"maxfev": MAX_EVALUATIONS, "initial_simplex": np.clip(simplex, *np.transpose(bounds))}
    found = minimize(lambda place: -gain(place), begin, method="Nelder-Mead", bounds=bounds, options=options)
    return _transition(time, *found.x)


def _transition(time: np.ndarray, middle: float, log_width: float) -> np.ndarray:
    """Return a normal distribution function over time as the transition from zero to one, shape (n, 1)."""
    return ndtr((time - middle) / np.exp(log_width))[:, None]
