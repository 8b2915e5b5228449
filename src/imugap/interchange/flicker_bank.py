"""Approximation of flicker noise by a bank of Gauss-Markov states, for a filter of finite order.

No linear model of finite order has the spectrum B^2/(2 pi f), an odd power of f (Farrell et al. 2022, section on bias
instability). A sum of Gauss-Markov processes with correlation times evenly spaced on a log axis approximates its flat
Allan deviation over a given range of averaging times.
"""

from functools import lru_cache

import numpy as np
from scipy.optimize import linprog, minimize

from imugap.effects import BiasInstability, GaussMarkov
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP

POINTS_PER_DECADE = 40
"""Averaging times per decade at which the bank is fitted and its error computed."""


def bank(density_b: float, shortest: float, longest: float, states: int) -> AxisModel:
    """Return the sum of Gauss-Markov processes nearest to flicker noise over a range of averaging times.

    Correlation times and variances minimise the largest relative error of the Allan deviation over the range.

    Parameters
    ----------
    density_b
        B of the flicker noise [unit].
    shortest, longest
        Range of averaging times [s].
    states
        Number of processes.
    """
    if not 0 < shortest < longest < np.inf:
        raise ValueError(f"flicker bank: expected 0 < shortest < longest; found {shortest:g} and {longest:g} s")
    if states < 1:
        raise ValueError(f"flicker bank: expected at least one state; found {states}")
    unit = _unit_bank(longest / shortest, states)
    return AxisModel(tuple(GaussMarkov(density_b * std, shortest * time) for time, std in unit))


def error(model: AxisModel, density_b: float, shortest: float, longest: float) -> float:
    """Return the largest relative error of the model's Allan deviation against 0.664 B over a range of tau [s]."""
    tau = _range(longest / shortest) * shortest
    flat = BiasInstability(density_b).allan_variance(tau)
    return float(np.abs(np.sqrt(model.allan_variance(tau) / flat) - 1).max())


def _range(ratio: float) -> np.ndarray:
    return np.geomspace(1.0, ratio, int(np.ceil(POINTS_PER_DECADE * np.log10(ratio))) + 2)


@lru_cache
def _unit_bank(ratio: float, states: int) -> tuple[tuple[float, float], ...]:
    """Return pairs of correlation time and standard deviation for B = 1 and the range from 1 to ``ratio``."""
    middle, reach = np.log(ratio) / 2 - np.log(FLAT_TOP), np.log(ratio) / 2

    def times(place):
        return np.exp(middle + place[0] + (reach + place[1]) * np.linspace(-1, 1, states) * (states > 1))

    best = minimize(lambda place: _minimax(times(place), ratio)[1], np.zeros(2), method="Nelder-Mead", tol=1e-4)
    variances, bound = _minimax(times(best.x), ratio)
    balance = 2 / (np.sqrt(1 + bound) + np.sqrt(1 - bound))
    return tuple(zip(times(best.x).tolist(), (np.sqrt(variances) * balance).tolist(), strict=True))


def _minimax(times: np.ndarray, ratio: float) -> tuple[np.ndarray, float]:
    """Return the variances that minimise the largest relative error of the Allan variance, and that error."""
    tau = _range(ratio)
    flat = BiasInstability(1.0).allan_variance(tau)
    columns = np.array([GaussMarkov(1.0, time).allan_variance(tau) / flat for time in times]).T
    one = np.ones((len(tau), 1))
    upper, lower = np.hstack([columns, -one]), np.hstack([-columns, -one])
    found = linprog(np.r_[np.zeros(len(times)), 1], np.vstack([upper, lower]), np.r_[one[:, 0], -one[:, 0]])
    return found.x[:-1], min(float(found.fun), 1.0)
