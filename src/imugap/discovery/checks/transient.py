"""Likelihood-ratio test of a warm-up and the terms around it against one transient of another shape.

The relaxation of many processes follows the logarithm of time, a power of it, a hyperbola, or a stretched exponential
(Kohlrausch 1854, Annalen der Physik 167, 56-82). The sum of a warm-up, a ramp and a step approximates these.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, log_p_against
from imugap.discovery.checks.unnamed_mean import likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Candidate, log_p_of_gain, without

REASON = "it fades away in another way"
MIN_STEPS = 2
"""Minimum number of steps during a transient for rejecting the exponential shape."""
DURATION = 2.0
"""Duration of a warm-up [time constants], after which 86 % of it has decayed."""
START_TIMES, MAX_EVALUATIONS = 8, 60
"""Number of start values of the time of a transient, and maximum evaluations of the optimiser."""
MAX_LOG_EXTENSION, MAX_EXPONENT = 3.0, 4.0
"""Maximum logarithm of the time over half the log, and maximum exponent."""
PARAMETERS = 3
"""Number of parameters of a transient: amplitude, time and exponent."""


def transient_misfits(added: Sequence[Candidate]) -> dict[Candidate, Misfit]:
    """Test an added warm-up, with the steps during it and the ramps, against a transient of another shape.

    Several steps during the warm-up reject it without a comparison.
    """
    warm = next((one for one in added if one.effect.transient), None)
    if warm is None:
        return {}
    over_at = DURATION * warm.effect.time_constant
    steps = [one for one in added if one.effect.event and one.effect.time < over_at]
    ramps = [one for one in added if one.effect.of_time and not (one.effect.event or one.effect.transient)]
    if len(steps) >= MIN_STEPS:
        return dict.fromkeys([warm, *steps], Misfit(REASON, -np.inf))
    if not steps and not ramps:
        return {}
    shaped = [warm, *steps, *ramps]
    temperatures = [one for one in added if one.effect.of_temperature]
    tested = {some: _against_transient(some) for some in (tuple(shaped), (*shaped, *temperatures))}
    some, log_p = min(tested.items(), key=lambda one: one[1])
    return dict.fromkeys(some, Misfit(REASON, log_p)) if log_p < MAX_LOG_P else {}


def _against_transient(some: Sequence[Candidate]) -> float:
    """Return the log-probability of some terms against one transient in their place, relative to the level."""
    fit = some[0].fit
    bare = without(fit, some)
    time = fit.sequence.conditions.time
    best = max(
        (_fit_transient(bare, time, kind) for kind in (_ageing, _stretched_exponential)),
        key=lambda shape: _gain(bare, shape),
    )
    more = fit.description.size() - bare.description.size()
    named = log_p_of_gain(fit.log_likelihood - bare.log_likelihood, more)
    other = log_p_of_gain(likelihood_with(bare, best) - bare.log_likelihood, PARAMETERS)
    return log_p_against(named, other, some[0].search.log_alpha)


def _fit_transient(bare: AxisFit, time: np.ndarray, kind: Callable) -> np.ndarray:
    """Maximise the likelihood gain of a transient over time and exponent; return its column, shape (n, 1)."""
    since, spans = time - time[0], np.log(np.geomspace(10 * (time[1] - time[0]), np.ptp(time) / 2, START_TIMES))
    tried = [(span, power) for span in spans for power in START_EXPONENTS[kind]]

    def loss(place: np.ndarray) -> float:
        return -_gain(bare, kind(since, *place))

    begin = min(tried, key=loss)
    bounds = [(spans[0], spans[-1] + MAX_LOG_EXTENSION), (-MAX_EXPONENT, MAX_EXPONENT)]
    found = minimize(loss, begin, method="Nelder-Mead", bounds=bounds, options={"maxfev": MAX_EVALUATIONS})
    return kind(since, *found.x)


def _gain(bare: AxisFit, shape: np.ndarray) -> float:
    return float(bare.gains(bare.whiten(shape))[0])


def _ageing(since: np.ndarray, span: float, power: float) -> np.ndarray:
    """Return (1 + t/T)^power with T = exp(span) [s], shape (n, 1); a small power approximates the logarithm."""
    return ((1 + since / np.exp(span)) ** power)[:, None]


def _stretched_exponential(since: np.ndarray, span: float, power: float) -> np.ndarray:
    """Return exp(-(t/T)^|power|) with T = exp(span) [s], shape (n, 1)."""
    return np.exp(-((since / np.exp(span)) ** abs(power)))[:, None]


START_EXPONENTS = {_ageing: (-2.0, -1.0, -0.5, -0.1, 0.1, 0.3, 0.6, 1.5), _stretched_exponential: (0.3, 0.5, 0.7, 0.85)}
"""Start values of the exponent for each shape of a transient."""
