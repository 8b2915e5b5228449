"""Tests of a term of the mean: departures of its shape, unresolved parameters, and lines that belong to one signal."""

from itertools import combinations

import numpy as np

from imugap.discovery.checks.misfit import Misfit
from imugap.discovery.checks.motion import term_against_motion
from imugap.discovery.checks.periodic import effect_against_periodic
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.intervals import term_intervals
from imugap.discovery.search.search import Candidate, log_p_of_gain
from imugap.discovery.search.simpler_form import lost_essential
from imugap.discovery.unnamed.periodic import MIN_PERIODS
from imugap.discovery.unnamed.wandering_lines import MAX_DISTANCE
from imugap.effects.effect import TINY

MAX_HARMONIC, MAX_TOLERANCE = 9, 0.1
"""Maximum harmonic number of a line, and maximum tolerance relative to its frequency or spacing."""
SIDEBAND_SPACING = 0.01
"""Maximum relative spacing of two lines that may be sidebands of a suppressed carrier."""


def mean_misfit(candidate: Candidate) -> Misfit | None:
    """Test whether a term is resolved, is no part of a composite line, and has the shape of its kind."""
    fit, index = candidate.fit, candidate.index
    unresolved = _unresolved_parameter(candidate)
    if unresolved is not None:
        return unresolved
    if _is_drift(candidate):
        return Misfit(f"it has fewer than {MIN_PERIODS} periods, as a drift of any shape may have", -np.inf)
    if candidate.effect.periodic or _has_harmonic(fit, index):
        return Misfit("lines at its multiples make it a wave of another shape", -np.inf)
    if _has_close_line(fit, index) or _has_sidebands(fit, index):
        return Misfit("lines beside it make it one that swells or drifts", -np.inf)
    shape = Misfit("the mean is not quite of its shape", shape_log_p(fit, index))
    if candidate.effect.of_motion:
        return min(shape, term_against_motion(candidate), key=lambda misfit: misfit.log_p)
    if not candidate.effect.event:
        return shape
    return min(shape, effect_against_periodic(candidate), key=lambda misfit: misfit.log_p)


def _is_drift(candidate: Candidate) -> bool:
    """Return whether a tone that changes its frequency has too few periods in the log to be one."""
    effect, sequence = candidate.effect, candidate.fit.sequence
    duration = sequence.conditions.interval * len(sequence.values)
    return effect.tonal and not effect.line and sum(effect.reach(duration)) / 2 * duration < MIN_PERIODS


def shape_log_p(fit: AxisFit, index: int) -> float:
    """Score-test a term against each departure of its shape; return the smallest log-probability (Bonferroni)."""
    ways = fit.description.terms[index].effect.near_misses(fit.sequence.conditions)
    found = [log_p_of_gain(gain, rank) for gain, rank in (fit.joint_gain(fit.whiten(way)) for way in ways) if rank]
    return min(found, default=0.0) + np.log(max(len(found), 1))


def _has_harmonic(fit: AxisFit, own: int) -> bool:
    """Return whether a line is a harmonic or the fundamental of another, both frequencies being known well enough."""
    lines = _lines(fit)
    if own not in lines:
        return False
    for index, other in lines.items():
        (slow, slow_width), (fast, fast_width) = sorted([lines[own], other])
        ratio = np.rint(fast / slow)
        tolerance = fast_width + ratio * slow_width
        if index != own and 2 <= ratio <= MAX_HARMONIC and abs(fast - ratio * slow) < tolerance < MAX_TOLERANCE * slow:
            return True
    return False


def _lines(fit: AxisFit) -> dict[int, tuple[float, float]]:
    """Return frequency and width of its 95 % interval [Hz] of each line, by the index of its term."""
    return {
        index: (term.effect.frequency, np.diff(term_intervals(fit, index)["frequency"])[0])
        for index, term in enumerate(fit.description.terms)
        if term.effect.line
    }


def _has_close_line(fit: AxisFit, own: int) -> bool:
    """Return whether another line is so close that both may be one line of varying amplitude or frequency."""
    lines = _lines(fit)
    duration = fit.sequence.conditions.interval * len(fit.sequence.values)
    return own in lines and any(
        abs(line - lines[own][0]) < max(MAX_DISTANCE / duration, SIDEBAND_SPACING * line)
        for index, (line, _) in lines.items()
        if index != own
    )


def _has_sidebands(fit: AxisFit, index: int) -> bool:
    """Return whether a line is one of three at equal spacing, a carrier and its sidebands, the spacing well known."""
    lines = sorted((*line, place) for place, line in _lines(fit).items())
    for (low, left, first), (middle, width, second), (high, right, third) in combinations(lines, 3):
        tolerance = left + 2 * width + right
        even = abs(low + high - 2 * middle) < tolerance < MAX_TOLERANCE * (high - low) / 2
        if even and index in (first, second, third):
            return True
    return False


def _unresolved_parameter(candidate: Candidate) -> Misfit | None:
    """Return a misfit where the interval of a positive parameter reaches zero, or that of an essential one, or None."""
    limits = candidate.effect.limits()
    ends = term_intervals(candidate.fit, candidate.index)
    lost = [name for name, (low, _) in ends.items() if limits[name][0] == TINY and low <= TINY]
    essential = lost_essential(candidate)
    lost += [] if essential is None else [essential]
    return Misfit(f"the log does not tell its {lost[0].replace('_', ' ')}", -np.inf) if lost else None
