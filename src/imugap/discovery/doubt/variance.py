"""Is a change of variance what its name says? One of white noise, and of all of it."""

import numpy as np
from scipy.fft import rfft

from imugap.discovery.axis import AxisFit
from imugap.discovery.doubt.doubt import Doubt, divergence
from imugap.discovery.doubt.motion import variance_in_motion
from imugap.discovery.search import Key, Search, log_chance

BLOCKS = 12
"""Blocks of a stretch of another variance, and bands of its frequencies, that have to agree."""
INNER = 0.95
"""Share of the frequencies in use whose power no edge of a stretch makes less."""


def change_doubt(search: Search, fit: AxisFit, key: Key) -> Doubt:
    """Compare the energies of blocks within the stretch, those of bands of the frequency, and those of motions."""
    inside = fit.whitened[fit.description.changes[key.index].within(fit.sequence.conditions.time)]
    used = fit.sequence.bins.last / len(fit.coefficients)
    power = np.abs(rfft(inside - inside.mean()))[1 : int(INNER * used * len(inside) / 2)] ** 2
    return min(
        Doubt("the variance changes within the stretch", _scatter(inside**2, 1)),
        Doubt("the variance of some frequencies changes more than that of others", _scatter(power, 2)),
        Doubt("the variance goes with the motion", variance_in_motion(search, fit, key)),
        key=lambda doubt: doubt.log_p,
    )


def _scatter(energies: np.ndarray, each: int) -> float:
    """Return the log-probability that the means of blocks of energies, of ``each`` degrees of freedom, scatter so."""
    count = min(BLOCKS, each * len(energies) // 8)
    if count < 2:
        return 0.0
    blocks = np.array_split(energies, count)
    number = each * np.array([len(block) for block in blocks])
    power = np.array([block.mean() for block in blocks]) / energies.mean() * number
    return log_chance(float(divergence(power, number).sum()), count - 1)
