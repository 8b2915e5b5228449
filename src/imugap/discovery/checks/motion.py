"""Does something else that goes with the motion explain a term better than its name does?"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.special import xlogy

from imugap import log
from imugap.discovery.checks.misfit import LEVEL, Misfit, divergence, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit, Description, jacobian
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Key, Search, log_chance, removed
from imugap.discovery.unnamed.hysteresis import play
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY

HALVES = 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0
"""Halves of plays, in standard deviations of the input."""
WAVES, WITHIN = 12, (0.01, 0.99)
"""Waves of the error over the range of the own input, and the quantiles between which that is."""
SHARES, FEW = 5, 20
"""Equal shares of the samples by the size of a motion; samples told apart, below which they are not looked at."""
PAUSE, STILL = 1.0, 0.05
"""Time [s] over which an input is at rest that moves by less than this share of its usual rate."""
TURN, HEADINGS = 1.0, 3
"""Angle [rad] that a motion turns through at least, and waves in a turn, of an error that goes with the heading."""
OTHER_FUNCTION = "another function of the motion explains it better"
NONE = Misfit(OTHER_FUNCTION, 0.0)


def term_against_motion(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Weigh what has no name in the place of a term that answers the motion, and ask what the term says beside it."""
    term = fit.description.terms[key.index]
    if not term.free:
        return NONE
    base = replace(fit, description=removed(fit.description, key))
    own = base.whiten(jacobian((term,), fit.sequence))
    named = log_chance(*base.joint_gain(own))
    others = [_instead(base, own, way, search.log_alpha) for way in _ways(fit.sequence.conditions)]
    margin = np.log(max(len(others), 1)) + UNNAMED_MARGIN
    log_p = min((log_p_against(named, other + margin, search.log_alpha) for other in others), default=0.0)
    return Misfit(OTHER_FUNCTION, log_p)


def _instead(base: AxisFit, own: np.ndarray, way: np.ndarray, log_alpha: float) -> float:
    """Return the log-probability of what a way gains by chance, or zero where a term still says something beside it.

    ``own`` are the whitened columns of the term, ``way`` those of the error.
    """
    columns = base.whiten(way)
    gain, rank = base.joint_gain(columns)
    both, more = base.joint_gain(np.column_stack([columns, own]))
    silent = rank and more > rank and log_chance(both - gain, more - rank) > log_alpha
    return log_chance(gain, rank) if silent else 0.0


def all_against_motion(search: Search, fit: AxisFit) -> Misfit:
    """Weigh what has no name in the place of all that was added, or of all terms; outliers are samples again."""
    if fit.sequence.conditions.ideal is None:
        return NONE
    sequence, found, without = _with_outliers(search, fit)
    own = likelihood_with(without, jacobian(found.terms[len(search.start.terms) :], sequence))
    named = max(search.fitted(sequence, found).log_likelihood, own)
    more = motion_gain(search, fit) + search.fitted(sequence, found).log_likelihood - named
    return Misfit(OTHER_FUNCTION, min(LEVEL + UNNAMED_MARGIN - more, 0.0))


def motion_gain(search: Search, fit: AxisFit) -> float:
    """Return how much log-likelihood the best of what has no name and goes with the motion gains over a fit, if any.

    In the place of all that was added, or of all terms.
    """
    if fit.sequence.conditions.ideal is None:
        return -np.inf
    sequence, found, without = _with_outliers(search, fit)
    bases = search.fitted(sequence, replace(search.start, outliers=None)), without
    found_by = (likelihood_with(base, way) for way in _ways(sequence.conditions) for base in bases)
    return max(found_by, default=-np.inf) - search.fitted(sequence, found).log_likelihood


def _with_outliers(search: Search, fit: AxisFit) -> tuple[AxisSequence, Description, AxisFit]:
    """Return the samples of a fit with their outliers, what else describes them, and the fit without added terms."""
    sequence = search.raw.get(fit.description.outliers, fit.sequence)
    found = replace(fit.description, outliers=None)
    return sequence, found, search.fitted(sequence, replace(found, terms=search.start.terms))


def outliers_against_motion(fit: AxisFit, flagged: np.ndarray) -> float:
    """Return the log-probability that flagged samples, shape (n,), come as unevenly over the sizes of the motion."""
    if flagged.sum() < FEW:
        return 0.0
    counts = [np.bincount(shares[flagged], minlength=SHARES) for shares in _shares(fit.sequence.conditions)]
    gains = (float(np.sum(xlogy(count, SHARES * count / count.sum()))) for count in counts)
    return _least([log_chance(gain, SHARES - 1) for gain in gains])


def variance_against_motion(search: Search, fit: AxisFit, key: Key) -> float:
    """Weigh a variance that goes with the motion in the place of one that changes in time.

    One that goes with its size has to be surer; one of the rests between motions only as sure: it is at the same times.
    """
    own, without = search.likelihood_ratio(fit, key)
    energies = without.unrounded**2
    conditions = fit.sequence.conditions
    sizes = _least([log_chance(_gain(energies, shares), SHARES - 1) for shares in _shares(conditions)])
    rests = _least([log_chance(_gain(energies, rest.astype(int)), 1) for rest in _rests(conditions)])
    return log_p_against(own.log_p, min(sizes + UNNAMED_MARGIN, rests), search.log_alpha)


def _gain(energies: np.ndarray, groups: np.ndarray) -> float:
    """Return the gain of log-likelihood of a variance of its own for each group of samples."""
    number = np.bincount(groups)
    power = np.bincount(groups, energies) / energies.mean()
    return float(divergence(power[number > 0], number[number > 0]).sum())


def _least(chances: list[float]) -> float:
    return min(min(chances) + float(np.log(len(chances))), 0.0) if chances else 0.0


def _shares(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield the share of the samples, shape (n,), that each is in by the size of an input or of its derivative."""
    for axis in log.AXES:
        if conditions.knows([axis]):
            values = conditions.ideal[axis].to_numpy(float)
            for motion in (values, np.gradient(values, conditions.interval)):
                size = np.abs(motion - np.median(motion))
                yield np.argsort(np.argsort(size)) * SHARES // len(size)


def _rests(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield which samples, shape (n,), are within a stretch in which an input hardly moves, where there is one."""
    span = max(round(PAUSE / conditions.interval), 2)
    for axis in log.AXES:
        if conditions.knows([axis]):
            power = np.gradient(conditions.ideal[axis].to_numpy(float), conditions.interval) ** 2
            rest = maximum_filter1d(uniform_filter1d(power, span) < STILL**2 * power.mean(), span)
            if 0 < np.count_nonzero(rest) < len(rest):
                yield rest


def _ways(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield what an error may go with, columns of shape (n, m): inputs, their powers, products and derivatives, and
    the squares of these.

    All of a triad at a time, cubes about the mean, as gravity makes those about zero straight lines; of each turn the
    angle; of the own axis what it drags along with some play, a share that drifts, and any other function of it.
    """
    turns, forces = (
        np.array([conditions.ideal[axis].to_numpy(float) for axis in triad if conditions.knows([axis])])
        for triad in (log.GYRO, log.ACCEL)
    )
    for inputs in (turns, forces):
        if len(inputs):
            yield inputs.T
            first = np.gradient(inputs.T, conditions.interval, axis=0)
            yield first
            yield np.hstack([first, np.gradient(first, conditions.interval, axis=0)]) ** 2
            yield np.column_stack([a * b for a, b in combinations_with_replacement(inputs, 2)])
            about_mean = inputs - inputs.mean(axis=1, keepdims=True)
            yield np.vstack([about_mean**3, np.abs(inputs)]).T
    if len(turns) and len(forces):
        yield np.column_stack([turn * force for turn in turns for force in forces])
    for axis in log.GYRO:
        if conditions.knows([axis]):
            angle = np.cumsum(conditions.ideal[axis].to_numpy(float)) * conditions.interval
            if np.ptp(angle) > TURN:
                headings = np.exp(1j * np.outer(angle, np.arange(1, HEADINGS + 1)))
                yield np.column_stack([headings.real, headings.imag])
    if conditions.knows([conditions.axis]):
        own = np.ascontiguousarray(conditions.error_free)
        yield np.column_stack([play(own, half * own.std()) for half in HALVES])
        yield (own * np.linspace(-1.0, 1.0, len(own)))[:, None]
        span = max(np.ptp(np.quantile(own, WITHIN)), TINY)
        waves = np.exp(2j * np.pi * np.outer(own, np.arange(1, WAVES + 1)) / span)
        yield np.column_stack([waves.real, waves.imag])
