"""Tests of a change of variance: constant within its interval, equal at all frequencies, and not caused by motion."""

import numpy as np
from scipy.fft import rfft

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, divergence
from imugap.discovery.checks.motion import variance_against_motion
from imugap.discovery.search.search import Candidate, log_p_of_gain
from imugap.effects.effect import Effect

MAX_BLOCKS = 12
"""Maximum number of blocks of time, and of bands of frequency, whose variances are compared."""
USED_SHARE = 0.95
"""Fraction of the used frequencies that are tested; above it the edges of the interval reduce the power."""


def variance_misfit(candidate: Candidate) -> Misfit:
    """Test the variance within the interval of the change for equality over time and frequency, and against motion.

    On a coarse lattice the noise ahead of the rounding has to change significantly.
    """
    fit, change = candidate.fit, candidate.effect
    inside = fit.unrounded[change.within(fit.sequence.conditions.time)]
    used = fit.sequence.bins.last / len(fit.coefficients)
    power = np.abs(rfft(inside - inside.mean()))[1 : int(USED_SHARE * used * len(inside) / 2)] ** 2
    return min(
        Misfit("the variance changes within the stretch", _homogeneity_log_p(inside**2, 1)),
        Misfit("the variance of some frequencies changes more than that of others", _homogeneity_log_p(power, 2)),
        Misfit("the variance goes with the motion", variance_against_motion(candidate)),
        Misfit("the rounding to a coarse lattice makes as much of it", _against_rounding(candidate)),
        key=lambda misfit: misfit.log_p,
    )


def _against_rounding(candidate: Candidate) -> float:
    """Return the log-probability of the change of the noise ahead of a coarse lattice, relative to the level."""
    own, without = candidate.trial, candidate.without
    if without.cells is None:
        return 0.0
    gain = _change_gain(without.unrounded**2, candidate.effect, without.sequence.conditions.time)
    ahead = log_p_of_gain(gain, own.parameters) + float(np.log(own.trials))
    return min(MAX_LOG_P + candidate.search.log_alpha - ahead, 0.0)


def _change_gain(energies: np.ndarray, change: Effect, time: np.ndarray) -> float:
    """Return the log-likelihood gain of a change of variance for energies (squares) of white noise, shape (n,)."""
    factor = change.factor(time)
    return float(0.5 * (len(energies) * np.log(energies.mean() / np.mean(energies / factor)) - np.log(factor).sum()))


def _homogeneity_log_p(energies: np.ndarray, each: int) -> float:
    """Return the log-probability of the homogeneity of block means of energies with ``each`` degrees of freedom."""
    count = min(MAX_BLOCKS, each * len(energies) // 8)
    if count < 2:
        return 0.0
    blocks = np.array_split(energies, count)
    number = each * np.array([len(block) for block in blocks])
    power = np.array([block.mean() for block in blocks]) / energies.mean() * number
    return log_p_of_gain(float(divergence(power, number).sum()), count - 1)
