"""Does a mean that dies away, with others beside it, stand for one transient of another shape?

What relaxes by many processes at once ages with the logarithm of time, a power of it, a hyperbola, or a stretched
exponential (Kohlrausch 1854, Annalen der Physik 167, 56-82). A warm-up, a ramp and a step together come close.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from imugap.discovery.axis import AxisFit
from imugap.discovery.doubt.beside import likelihood_beside
from imugap.discovery.doubt.doubt import LEVEL, Doubt, over
from imugap.discovery.search import Key, Search, at, log_chance, without
from imugap.effects import BiasStep, RateRamp, Temperature, WarmUp

REASON = "it fades away in another way"
SEVERAL = 2
"""Steps within a transient from which on they shape it."""
FADED = 5.0
"""Time constants after which a warm-up is over: 0.7 % of it are left."""
POWERS = np.r_[np.arange(0.1, 1.0, 0.1), 1.5, 2.0, 3.0]
STRETCHED = np.arange(0.3, 0.9, 0.1)
HYPERBOLIC = 0.5, 1.0, 2.0
TIMES = 20
"""Times of a transient at which a search looks."""
PARAMETERS = 3
"""Size, time and shape of a transient."""


def of_transients(search: Search, fit: AxisFit, keys: Sequence[Key]) -> dict[Key, Doubt]:
    """Return the doubts of a warm-up among ``keys`` and of what shapes it: steps before it is over, and a ramp.

    Several steps need no rival: a transient has none.
    """
    effects = {key: at(fit.description, key) for key in keys}
    warm = next((key for key, effect in effects.items() if isinstance(effect, WarmUp)), None)
    if warm is None:
        return {}
    over_at = FADED * effects[warm].time_constant
    steps = [key for key, effect in effects.items() if isinstance(effect, BiasStep) and effect.time < over_at]
    ramps = [key for key, effect in effects.items() if isinstance(effect, RateRamp)]
    if len(steps) >= SEVERAL:
        return dict.fromkeys([warm, *steps], Doubt(REASON, -np.inf))
    if not steps and not ramps:
        return {}
    shaped = [warm, *steps, *ramps]
    temperatures = [key for key, effect in effects.items() if isinstance(effect, Temperature)]
    weighed = {some: _another_shape(search, fit, some) for some in {tuple(shaped), (*shaped, *temperatures)}}
    some, log_p = min(weighed.items(), key=lambda one: one[1])
    return dict.fromkeys(some, Doubt(REASON, log_p)) if log_p < LEVEL else {}


def _another_shape(search: Search, fit: AxisFit, keys: Sequence[Key]) -> float:
    """Return the log-probability of a doubt whether some means are surer than one transient in their place."""
    bare = without(fit, keys)
    best = max((_best(bare, some) for some in _shapes(fit.sequence.conditions.time)), key=lambda one: one[0])[1]
    more = fit.description.size() - bare.description.size()
    named = log_chance(fit.log_likelihood - bare.log_likelihood, more)
    other = log_chance(likelihood_beside(bare, best) - bare.log_likelihood, PARAMETERS)
    return over(named, other, search.log_alpha)


def _best(bare: AxisFit, shapes: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the largest gain of log-likelihood by one of some shapes, and that one, shape (n, 1)."""
    gains = bare.gains(bare.whiten(shapes))
    return float(gains.max()), shapes[:, [np.argmax(gains)]]


def _shapes(time: np.ndarray) -> Iterator[np.ndarray]:
    """Yield transients of other shapes over a time from its begin, shape (n, shapes)."""
    since = time - time[0]
    yield (since / since[-1])[:, None] ** POWERS
    for scale in np.geomspace(10 * since[1], since[-1] / 2, TIMES):
        aged = since / scale
        stretched = (np.exp(-(aged**power)) for power in STRETCHED)
        yield np.column_stack([np.log1p(aged), *stretched, *((1 + aged) ** -power for power in HYPERBOLIC)])
