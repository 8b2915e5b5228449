"""Tests of a change of variance: constant within its interval, equal at all frequencies, of no other cause."""

import numpy as np
from scipy.fft import rfft

from imugap.discovery.checks.misfit import MAX_LOG_P, Misfit, divergence, log_p_against
from imugap.discovery.checks.motion import variance_against_motion
from imugap.discovery.search.search import Candidate, log_p_of_gain
from imugap.effects.effect import TINY, Effect, Role

MAX_BLOCKS = 12
"""Maximum number of blocks of time, and of bands of frequency, whose variances are compared."""
TEMPERATURE_BLOCKS = 400
"""Blocks of time whose variances are compared with their temperatures."""
MIN_SWING_DEGC = 1e-3
"""Smallest standard deviation of a temperature that varies [degC]."""
SCORING_STEPS, MAX_EXPONENT = 30, 50.0
"""Steps of Fisher scoring, and largest logarithm of the change of the variance."""
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
        Misfit("the variance goes with the temperature", _against_temperature(candidate)),
        Misfit("the rounding to a coarse lattice makes as much of it", _against_rounding(candidate)),
        key=lambda misfit: misfit.log_p,
    )


def _against_temperature(candidate: Candidate) -> float:
    """Compare all changes of variance with one that is exponential in the temperature; return the log-probability."""
    conditions = candidate.fit.sequence.conditions
    if conditions.temperature is None or conditions.temperature.std() < MIN_SWING_DEGC:
        return 0.0
    known = candidate.fit.description.keeping(lambda entry: entry.known or entry.effect.role is not Role.VARIANCE)
    steady = candidate.search.fitted(candidate.fit.sequence, known)
    gain = temperature_gain(steady.unrounded**2, conditions.temperature)
    change = candidate.fit.log_likelihood - steady.log_likelihood
    more = candidate.fit.description.size() - known.size()
    log_p = log_p_of_gain(change, more) + float(np.log(candidate.trial.trials))
    return log_p_against(log_p, log_p_of_gain(gain, 1), candidate.search.log_alpha)


def temperature_gain(energies: np.ndarray, temperature: np.ndarray) -> float:
    """Return the log-likelihood gain of a variance exponential in the temperature over a constant one.

    Gamma regression of block means with a logarithmic link, by Fisher scoring (McCullagh & Nelder 1989, section 8.3).

    Parameters
    ----------
    energies, temperature
        Squares of white noise and temperature [degC] of the samples, shape (n,) each.
    """
    blocks = min(TEMPERATURE_BLOCKS, len(energies))
    number = np.array([len(one) for one in np.array_split(energies, blocks)])
    power, degrees = (
        np.array([one.mean() for one in np.array_split(part, blocks)]) for part in (energies, temperature)
    )
    degrees = degrees - np.average(degrees, weights=number)
    slope, information = 0.0, float(number @ degrees**2)
    most = MAX_EXPONENT / max(np.abs(degrees).max(), TINY)
    for _ in range(SCORING_STEPS if information else 0):
        slope = min(max(slope, -most), most)
        ratio = power * np.exp(-slope * degrees)
        ratio /= np.average(ratio, weights=number)
        slope += float(number @ (degrees * (ratio - 1))) / information
    slope = min(max(slope, -most), most)
    level, variance = (np.average(part, weights=number) for part in (power, power * np.exp(-slope * degrees)))
    return float(number.sum() / 2 * np.log(level / variance))


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
