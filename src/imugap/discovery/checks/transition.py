"""Do steps that go one way, or slow noise, stand for one gradual transition between two levels?

Three steps make a staircase that is close to any passage that takes its time, and slow noise follows it.
"""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from scipy.optimize import minimize
from scipy.special import ndtr

from imugap.discovery.checks.misfit import LEVEL, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, at, coloured, log_chance, without

REASON = "one gradual transition explains it better"
WIDTHS, EVALUATIONS = np.geomspace(0.003, 0.2, 7), 60
"""Widths of a transition over the duration, and evaluations from the best one on, with which a search looks."""
NEAR = 0.5
"""Share of the gain of what has a name that the best of these widths has to make for more to be evaluated."""
PARAMETERS = 3
"""Size, time and width of a transition."""
PLACES = 100.0
"""Independent transitions in a log, on the safe side."""


def transition_misfits(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return the doubts of several steps that follow each other one way, and of slow noise with all steps."""
    steps = [key for key in keys if at(fit.description, key).event]
    slow = [key for key in keys if coloured(at(fit.description, key))]
    steps.sort(key=lambda key: at(fit.description, key).time)
    ways = (list(way) for _, way in groupby(steps, lambda key: at(fit.description, key).step > 0))
    misfits = {tuple(way): _instead(search, fit, way) for way in ways if len(way) > 1}
    if slow:
        misfits[*steps, *slow] = _instead(search, fit, [*steps, *slow], UNNAMED_MARGIN)
    return {key: Misfit(REASON, log_p) for some, log_p in misfits.items() if log_p < LEVEL for key in some}


def _instead(search: Search, fit: AxisFit, keys: Sequence[Key], clearly: float = 0.0) -> float:
    """Return the log-probability of a doubt whether some effects are surer than a transition in their place."""
    bare = without(fit, keys)
    gain, more = fit.log_likelihood - bare.log_likelihood, fit.description.size() - bare.description.size()
    named = log_chance(gain, more) + sum(np.log(search.likelihood_ratio(fit, key)[0].trials) for key in keys)
    best = _best(bare, NEAR * gain)
    if best is None:
        return 0.0
    other = log_chance(likelihood_with(bare, best) - bare.log_likelihood, PARAMETERS) + np.log(PLACES)
    return log_p_against(named, other + clearly, search.log_alpha)


def _best(bare: AxisFit, least: float) -> np.ndarray | None:
    """Return the likeliest transition, shape (n, 1), if one at the highest step gains as much as the least."""
    time = bare.sequence.conditions.time
    duration = np.ptp(time)

    def gain(place: np.ndarray) -> float:
        return float(bare.gains(bare.whiten(_transition(time, *place)))[0])

    begin = max(((time[np.argmax(bare.steps.gains)], np.log(width * duration)) for width in WIDTHS), key=gain)
    if gain(begin) < least:
        return None
    bounds = [(time[0], time[-1]), tuple(np.log(WIDTHS[[0, -1]] * duration))]
    simplex = np.array([begin, [begin[0] + np.exp(begin[1]), begin[1]], [begin[0], begin[1] + 0.5]])
    options = {"maxfev": EVALUATIONS, "initial_simplex": np.clip(simplex, *np.transpose(bounds))}
    found = minimize(lambda place: -gain(place), begin, method="Nelder-Mead", bounds=bounds, options=options)
    return _transition(time, *found.x)


def _transition(time: np.ndarray, middle: float, log_width: float) -> np.ndarray:
    """Return a passage from zero to one around a time, of a normal law's shape and deviation, shape (n, 1)."""
    return ndtr((time - middle) / np.exp(log_width))[:, None]
