"""Is a change of variance what its name says? One of white noise, and of all of it."""

import numpy as np
from scipy.fft import rfft

from imugap.discovery.checks.misfit import LEVEL, Misfit, divergence
from imugap.discovery.checks.motion import variance_against_motion
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Key, Search, log_chance
from imugap.effects.effect import Effect

BLOCKS = 12
"""Blocks of a stretch of another variance, and bands of its frequencies, that have to agree."""
INNER = 0.95
"""Share of the frequencies in use whose power no edge of a stretch makes less."""


def variance_misfit(search: Search, fit: AxisFit, key: Key) -> Misfit:
    """Compare the energies of blocks within the stretch, those of bands of the frequency, and those of motions.

    On a coarse lattice the change has to be one of the noise ahead of the rounding.
    """
    change = fit.description.changes[key.index]
    inside = fit.unrounded[change.within(fit.sequence.conditions.time)]
    used = fit.sequence.bins.last / len(fit.coefficients)
    power = np.abs(rfft(inside - inside.mean()))[1 : int(INNER * used * len(inside) / 2)] ** 2
    return min(
        Misfit("the variance changes within the stretch", _scatter(inside**2, 1)),
        Misfit("the variance of some frequencies changes more than that of others", _scatter(power, 2)),
        Misfit("the variance goes with the motion", variance_against_motion(search, fit, key)),
        Misfit("the rounding to a coarse lattice makes as much of it", _of_rounding(search, fit, key)),
        key=lambda misfit: misfit.log_p,
    )


def _of_rounding(search: Search, fit: AxisFit, key: Key) -> float:
    """Return the log-probability of a doubt whether noise ahead of a coarse lattice changes for certain."""
    own, without = search.likelihood_ratio(fit, key)
    if without.cells is None:
        return 0.0
    gain = _gain(without.unrounded**2, fit.description.changes[key.index], without.sequence.conditions.time)
    ahead = log_chance(gain, own.parameters) + float(np.log(own.trials))
    return min(LEVEL + search.log_alpha - ahead, 0.0)


def _gain(energies: np.ndarray, change: Effect, time: np.ndarray) -> float:
    """Return the gain of log-likelihood of a change, as it is, of squares of white noise."""
    factor = change.factor(time)
    return float(0.5 * (len(energies) * np.log(energies.mean() / np.mean(energies / factor)) - np.log(factor).sum()))


def _scatter(energies: np.ndarray, each: int) -> float:
    """Return the log-probability that the means of blocks of energies, of ``each`` degrees of freedom, scatter so."""
    count = min(BLOCKS, each * len(energies) // 8)
    if count < 2:
        return 0.0
    blocks = np.array_split(energies, count)
    number = each * np.array([len(block) for block in blocks])
    power = np.array([block.mean() for block in blocks]) / energies.mean() * number
    return log_chance(float(divergence(power, number).sum()), count - 1)
