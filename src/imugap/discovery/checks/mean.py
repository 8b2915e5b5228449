"""Is a term of the mean what its name says? Its near misses, and the other lines beside a line."""

from itertools import combinations

import numpy as np

from imugap.discovery.checks.misfit import Misfit
from imugap.discovery.checks.motion import term_against_motion
from imugap.discovery.checks.periodic import effect_against_periodic
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.intervals import term_intervals
from imugap.discovery.search.search import Key, Search, at, log_chance
from imugap.discovery.unnamed.wandering_lines import NEAR
from imugap.effects.effect import TINY

HARMONICS, ALONE = 9, 0.1
"""Highest multiple of a line, and share of its frequency, or of the distance of lines, within which these are known."""
BESIDE = 0.01
"""Distance of lines, over their frequency, within which they are sidebands of one that may not be there itself."""


def mean_misfit(search: Search, fit: AxisFit, key: Key) -> Misfit | None:
    """Doubt a term that the log does not resolve, that other lines say more of, or that is not quite of its shape."""
    unresolved = _unresolved(fit, key)
    if unresolved is not None:
        return unresolved
    if _harmonic(fit, key):
        return Misfit("lines at its multiples make it a wave of another shape", -np.inf)
    if _split(fit, key) or _modulated(fit, key):
        return Misfit("lines beside it make it one that swells or drifts", -np.inf)
    bent = Misfit("the mean is not quite of its shape", shape_log_p(fit, key.index))
    if at(fit.description, key).of_motion:
        return min(bent, term_against_motion(search, fit, key), key=lambda misfit: misfit.log_p)
    if not at(fit.description, key).event:
        return bent
    return min(bent, effect_against_periodic(search, fit, key), key=lambda misfit: misfit.log_p)


def shape_log_p(fit: AxisFit, index: int) -> float:
    """Return the log-probability that a term is as far from its shape, in the likeliest of the ways that it may be."""
    ways = fit.description.terms[index].effect.near_misses(fit.sequence.conditions)
    found = [log_chance(gain, rank) for gain, rank in (fit.joint_gain(fit.whiten(way)) for way in ways) if rank]
    return min(found, default=0.0) + np.log(max(len(found), 1))


def _harmonic(fit: AxisFit, key: Key) -> bool:
    """Return whether a line and another one are multiples of each other, of a frequency that is known well enough."""
    lines = _lines(fit)
    if key.index not in lines:
        return False
    for index, other in lines.items():
        (slow, slow_width), (fast, fast_width) = sorted([lines[key.index], other])
        ratio = np.rint(fast / slow)
        tolerance = fast_width + ratio * slow_width
        if index != key.index and 2 <= ratio <= HARMONICS and abs(fast - ratio * slow) < tolerance < ALONE * slow:
            return True
    return False


def _lines(fit: AxisFit) -> dict[int, tuple[float, float]]:
    """Return frequency [Hz] and width of its interval of each line, by the index of its term."""
    return {
        index: (term.effect.frequency, np.diff(term_intervals(fit, index)["frequency"])[0])
        for index, term in enumerate(fit.description.terms)
        if term.effect.line
    }


def _split(fit: AxisFit, key: Key) -> bool:
    """Return whether another line is so near to one that both may be parts of a line that is not steady."""
    lines = _lines(fit)
    duration = fit.sequence.conditions.interval * len(fit.sequence.values)
    return key.index in lines and any(
        abs(line - lines[key.index][0]) < max(NEAR / duration, BESIDE * line)
        for index, (line, _) in lines.items()
        if index != key.index
    )


def _modulated(fit: AxisFit, key: Key) -> bool:
    """Return whether a line is one of three of equal distance, which is known well enough: carrier and sidebands."""
    lines = sorted((*line, index) for index, line in _lines(fit).items())
    for (low, left, first), (middle, own, second), (high, right, third) in combinations(lines, 3):
        tolerance = left + 2 * own + right
        even = abs(low + high - 2 * middle) < tolerance < ALONE * (high - low) / 2
        if even and key.index in (first, second, third):
            return True
    return False


def _unresolved(fit: AxisFit, key: Key) -> Misfit | None:
    """Doubt an effect of which the log does not tell a parameter from nothing: a transient of a sample or two."""
    limits = at(fit.description, key).limits()
    ends = term_intervals(fit, key.index)
    lost = [name for name, (low, _) in ends.items() if limits[name][0] == TINY and low <= TINY]
    return Misfit(f"the log does not tell its {lost[0]}", -np.inf) if lost else None
