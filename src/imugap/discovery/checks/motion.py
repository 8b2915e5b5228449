"""Likelihood-ratio tests of effects against unnamed functions of the motion."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.special import xlogy

from imugap import log
from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, divergence, log_p_against
from imugap.discovery.checks.unnamed_mean import UNNAMED_MARGIN, likelihood_with
from imugap.discovery.fit.axis_fit import AxisFit, jacobian
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Candidate, Search, log_p_of_gain
from imugap.discovery.unnamed.hysteresis import play
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Role

PLAY_HALF_WIDTHS = 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0
"""Half-widths of play operators [standard deviations of the input]."""
HARMONICS, RANGE_QUANTILES = 12, (0.01, 0.99)
"""Number of harmonics over the range of the own input, and the quantiles that define the range."""
SIZE_CLASSES, MIN_FLAGGED = 5, 20
"""Number of equal classes of samples by the size of a motion; minimum number of flagged samples for a test."""
REST_TIME_S, MAX_REST_RATE = 1.0, 0.05
"""Minimum duration [s] of rest of an input, and maximum rate of change at rest over its RMS."""
MIN_TURN, HEADING_HARMONICS = 1.0, 3
"""Minimum turn [rad] for an error over the heading, and number of its harmonics."""
OTHER_FUNCTION = "another function of the motion explains it better"
NO_MISFIT = Misfit(OTHER_FUNCTION, 0.0)


def term_against_motion(candidate: Candidate) -> Misfit:
    """Test a term against generic functions of the motion, in its place and in addition to it."""
    fit, log_alpha = candidate.fit, candidate.search.log_alpha
    if not candidate.entry.free:
        return NO_MISFIT
    base = replace(fit, description=fit.description.without([candidate.index]))
    own = base.whiten(jacobian((candidate.entry,), fit.sequence))
    named = log_p_of_gain(*base.joint_gain(own))
    functions = _motion_functions(fit.sequence.conditions)
    others = [_alternative_log_p(base, own, error, log_alpha) for error in functions]
    margin = np.log(max(len(others), 1)) + UNNAMED_MARGIN
    log_p = min((log_p_against(named, other + margin, log_alpha) for other in others), default=0.0)
    return Misfit(OTHER_FUNCTION, log_p)


def _alternative_log_p(base: AxisFit, own: np.ndarray, error: np.ndarray, log_alpha: float) -> float:
    """Return the log-probability of a function of the motion, or zero where the term remains significant next to it.

    ``own`` are the whitened columns of the term, ``error`` the columns of the function, shape (n, m).
    """
    columns = base.whiten(error)
    gain, rank = base.joint_gain(columns)
    both, more = base.joint_gain(np.column_stack([columns, own]))
    silent = rank and more > rank and log_p_of_gain(both - gain, more - rank) > log_alpha
    return log_p_of_gain(gain, rank) if silent else 0.0


def all_against_motion(search: Search, fit: AxisFit) -> Misfit:
    """Test all added effects, and all added terms, against generic functions of the motion; outliers are restored."""
    if fit.sequence.conditions.ideal is None:
        return NO_MISFIT
    sequence, found, without = _with_outlier_samples(search, fit)
    own = likelihood_with(without, jacobian(found.terms[len(search.start.terms) :], sequence))
    named = max(search.fitted(sequence, found).log_likelihood, own)
    more = motion_gain(search, fit) + search.fitted(sequence, found).log_likelihood - named
    return Misfit(OTHER_FUNCTION, min(MAX_LOG_P + UNNAMED_MARGIN - more, 0.0))


def motion_gain(search: Search, fit: AxisFit) -> float:
    """Return the log-likelihood gain over a fit of the best generic function of the motion, -inf at rest.

    The function takes the place of all added effects, or of all added terms.
    """
    if fit.sequence.conditions.ideal is None:
        return -np.inf
    sequence, found, without = _with_outlier_samples(search, fit)
    bases = search.fitted(sequence, search.start.exchanging(Role.OUTLIERS)), without
    found_by = (likelihood_with(base, error) for error in _motion_functions(sequence.conditions) for base in bases)
    return max(found_by, default=-np.inf) - search.fitted(sequence, found).log_likelihood


def _with_outlier_samples(search: Search, fit: AxisFit) -> tuple[AxisSequence, Description, AxisFit]:
    """Return the samples with their outliers, their description without outliers, and the fit without added terms."""
    sequence = search.raw.get(fit.description.outliers, fit.sequence)
    found = fit.description.exchanging(Role.OUTLIERS)
    return sequence, found, search.fitted(sequence, found.exchanging(Role.MEAN, search.start.terms))


def outliers_against_motion(fit: AxisFit, flagged: np.ndarray) -> float:
    """Return the log-probability that flagged samples, shape (n,), are independent of the size of the motion."""
    if flagged.sum() < MIN_FLAGGED:
        return 0.0
    counts = [np.bincount(shares[flagged], minlength=SIZE_CLASSES) for shares in _size_classes(fit.sequence.conditions)]
    gains = (float(np.sum(xlogy(count, SIZE_CLASSES * count / count.sum()))) for count in counts)
    return _smallest_log_p([log_p_of_gain(gain, SIZE_CLASSES - 1) for gain in gains])


def variance_against_motion(candidate: Candidate) -> float:
    """Test a change of variance in time against a variance that depends on the motion.

    Dependence on its size needs :data:`.UNNAMED_MARGIN`; a difference between rest and motion does not, as it occurs at
    the same times.
    """
    energies = candidate.without.unrounded**2
    conditions = candidate.fit.sequence.conditions
    sizes = _smallest_log_p(
        [
            log_p_of_gain(_group_variance_gain(energies, shares), SIZE_CLASSES - 1)
            for shares in _size_classes(conditions)
        ]
    )
    rests = _smallest_log_p(
        [log_p_of_gain(_group_variance_gain(energies, rest.astype(int)), 1) for rest in _rest_periods(conditions)]
    )
    return log_p_against(candidate.trial.log_p, min(sizes + UNNAMED_MARGIN, rests), candidate.search.log_alpha)


def _group_variance_gain(energies: np.ndarray, groups: np.ndarray) -> float:
    """Return the log-likelihood gain of a separate variance for each group of samples."""
    number = np.bincount(groups)
    power = np.bincount(groups, energies) / energies.mean()
    return float(divergence(power[number > 0], number[number > 0]).sum())


def _smallest_log_p(log_ps: list[float]) -> float:
    return min(min(log_ps) + float(np.log(len(log_ps))), 0.0) if log_ps else 0.0


def _size_classes(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield the class of each sample, shape (n,), by the size of an input or of its derivative."""
    for axis in log.AXES:
        if conditions.knows([axis]):
            values = conditions.signals[axis]
            for motion in (values, np.gradient(values, conditions.interval)):
                size = np.abs(motion - np.median(motion))
                yield np.argsort(np.argsort(size)) * SIZE_CLASSES // len(size)


def _rest_periods(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield the samples, shape (n,), in periods in which an input is at rest, for each input that has some."""
    span = max(round(REST_TIME_S / conditions.interval), 2)
    for axis in log.AXES:
        if conditions.knows([axis]):
            power = np.gradient(conditions.signals[axis], conditions.interval) ** 2
            rest = maximum_filter1d(uniform_filter1d(power, span) < MAX_REST_RATE**2 * power.mean(), span)
            if 0 < np.count_nonzero(rest) < len(rest):
                yield rest


def _motion_functions(conditions: Conditions) -> Iterator[np.ndarray]:
    """Yield generic functions of the motion as columns of shape (n, m).

    Of each triad: inputs, powers, products, derivatives and their squares; cubes are about the mean, as with gravity
    those about zero are nearly linear. Of each rotation: harmonics of the angle. Of the own axis: play operators, a
    drifting scale factor, and a Fourier series of the input.
    """
    turns, forces = (
        np.array([conditions.signals[axis] for axis in triad if conditions.knows([axis])])
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
            angle = np.cumsum(conditions.signals[axis]) * conditions.interval
            if np.ptp(angle) > MIN_TURN:
                headings = np.exp(1j * np.outer(angle, np.arange(1, HEADING_HARMONICS + 1)))
                yield np.column_stack([headings.real, headings.imag])
    if conditions.knows([conditions.axis]):
        own = np.ascontiguousarray(conditions.error_free)
        yield np.column_stack([play(own, half * own.std()) for half in PLAY_HALF_WIDTHS])
        yield (own * np.linspace(-1.0, 1.0, len(own)))[:, None]
        span = max(np.ptp(np.quantile(own, RANGE_QUANTILES)), TINY)
        waves = np.exp(2j * np.pi * np.outer(own, np.arange(1, HARMONICS + 1)) / span)
        yield np.column_stack([waves.real, waves.imag])
