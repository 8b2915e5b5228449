"""Withheld effects: the nearest name, the reason for withholding it, and its location in a view."""

from dataclasses import dataclass

import numpy as np

from imugap.discovery.checks import MIN_SHARE, Misfit, power_share
from imugap.discovery.finding import MIN_LOG_P, Discrepancy
from imugap.discovery.search.intervals import term_intervals
from imugap.discovery.search.search import Candidate
from imugap.effects.effect import Role


@dataclass(frozen=True)
class Withheld:
    """Nearest name of an effect that is not named, why, where, and the log p-values of the effect and of the reason."""

    name: str
    reason: str
    location: Discrepancy
    log_p: float
    misfit_log_p: float


def withheld(candidate: Candidate, misfit: Misfit) -> Withheld:
    """Return name, reason and location of an effect of a fit that has a misfit."""
    p_value = float(np.exp(np.clip(candidate.trial.log_p, MIN_LOG_P, 0.0)))
    place = Discrepancy(*_location(candidate), p_value)
    return Withheld(candidate.effect.name, misfit.reason, place, candidate.trial.log_p, misfit.log_p)


def _location(candidate: Candidate) -> tuple[str, str, float, float, str]:
    """Return view, axis, both ends of the location, and their unit."""
    fit, effect, conditions = candidate.fit, candidate.effect, candidate.fit.sequence.conditions
    axis, begin, end = conditions.axis, float(conditions.time[0]), float(conditions.time[-1])
    if effect.role is Role.NOISE:
        frequency = fit.sequence.bins.frequency
        own = power_share(fit, effect)
        mine = frequency[own >= min(MIN_SHARE, own.max())]
        return "spectrum", axis, float(mine[0]), float(mine[-1]), "Hz"
    if effect.role is Role.VARIANCE:
        return "variance", axis, max(effect.start, begin), min(effect.stop, end), "s"
    if effect.role is Role.OUTLIERS:
        return "extremes", axis, begin, end, "s"
    if effect.line:
        low, high = term_intervals(fit, candidate.index)["frequency"]
        return "line", axis, float(max(low, 0.0)), float(high), "Hz"
    if effect.event:
        return "change", axis, effect.time, effect.time, "s"
    return "mean", axis, begin, end, "s"
