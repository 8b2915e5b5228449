"""Does a mean that dies away, with others beside it, stand for one transient of another shape?

What relaxes by many processes at once ages with the logarithm of time, a power of it, a hyperbola, or a stretched
exponential (Kohlrausch 1854, Annalen der Physik 167, 56-82). A warm-up, a ramp and a step together come close.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from imugap.discovery.checks.misfit import LEVEL, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, at, log_chance, without

REASON = "it fades away in another way"
SEVERAL = 2
"""Steps within a transient from which on they shape it."""
DURATION = 2.0
"""Time constants in which most of a warm-up goes by, 86 % of it."""
TIMES, EVALUATIONS = 8, 60
"""Times of a transient, and evaluations from the best one on, with which a search looks."""
LONGER, STEEPEST = 3.0, 4.0
"""Logarithm of how much longer than half the log a time may be, and the largest power."""
PARAMETERS = 3
"""Size, time and shape of a transient."""


def transient_misfits(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Misfit]:
    """Return the doubts of a warm-up among ``keys`` and of what shapes it: steps while it goes by, and a ramp.

    Several steps need no rival: a transient has none.
    """
    effects = {key: at(fit.description, key) for key in keys}
    warm = next((key for key, effect in effects.items() if effect.transient), None)
    if warm is None:
        return {}
    over_at = DURATION * effects[warm].time_constant
    steps = [key for key, effect in effects.items() if effect.event and effect.time < over_at]
    ramps = [key for key, effect in effects.items() if effect.of_time and not effect.event and not effect.transient]
    if len(steps) >= SEVERAL:
        return dict.fromkeys([warm, *steps], Misfit(REASON, -np.inf))
    if not steps and not ramps:
        return {}
    shaped = [warm, *steps, *ramps]
    temperatures = [key for key, effect in effects.items() if effect.of_temperature]
    weighed = {some: _another_shape(search, fit, some) for some in {tuple(shaped), (*shaped, *temperatures)}}
    some, log_p = min(weighed.items(), key=lambda one: one[1])
    return dict.fromkeys(some, Misfit(REASON, log_p)) if log_p < LEVEL else {}


def _another_shape(search: Search, fit: AxisFit, keys: Sequence[Key]) -> float:
    """Return the log-probability of a doubt whether some means are surer than one transient in their place."""
    bare = without(fit, keys)
    time = fit.sequence.conditions.time
    best = max((_best(bare, time, kind) for kind in (_aged, _stretched)), key=lambda shape: _gain(bare, shape))
    more = fit.description.size() - bare.description.size()
    named = log_chance(fit.log_likelihood - bare.log_likelihood, more)
    other = log_chance(likelihood_with(bare, best) - bare.log_likelihood, PARAMETERS)
    return log_p_against(named, other, search.log_alpha)


def _best(bare: AxisFit, time: np.ndarray, kind: Callable) -> np.ndarray:
    """Return the likeliest transient of a kind, shape (n, 1), from the best one of a few times and powers."""
    since, spans = time - time[0], np.log(np.geomspace(10 * (time[1] - time[0]), np.ptp(time) / 2, TIMES))
    tried = [(span, power) for span in spans for power in POWERS[kind]]

    def loss(place: np.ndarray) -> float:
        return -_gain(bare, kind(since, *place))

    begin = min(tried, key=loss)
    bounds = [(spans[0], spans[-1] + LONGER), (-STEEPEST, STEEPEST)]
    found = minimize(loss, begin, method="Nelder-Mead", bounds=bounds, options={"maxfev": EVALUATIONS})
    return kind(since, *found.x)


def _gain(bare: AxisFit, shape: np.ndarray) -> float:
    return float(bare.gains(bare.whiten(shape))[0])


def _aged(since: np.ndarray, span: float, power: float) -> np.ndarray:
    """Return a power of the age, over exp(span) [s], shape (n, 1); that of a power near zero is its logarithm."""
    return ((1 + since / np.exp(span)) ** power)[:, None]


def _stretched(since: np.ndarray, span: float, power: float) -> np.ndarray:
    """Return a stretched exponential, shape (n, 1)."""
    return np.exp(-((since / np.exp(span)) ** abs(power)))[:, None]


POWERS = {_aged: (-2.0, -1.0, -0.5, -0.1, 0.1, 0.3, 0.6, 1.5), _stretched: (0.3, 0.5, 0.7, 0.85)}
"""Powers from which transients of a kind are fitted."""
