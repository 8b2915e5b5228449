"""Two values or a continuum? Gauss-Markov and random telegraph noise have one spectrum; their samples differ."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import minimize

from imugap.discovery.axis import AxisFit
from imugap.effects import GaussMarkov, RandomTelegraph
from imugap.effects.effect import StochasticEffect

FINE = 12
"""Blocks per correlation time."""
LONG = 20.0
"""Correlation times in a log, where nothing tells more."""
QUIET, DEEP = 1e-3, 10.0
"""White noise over the slow process: least share at the start, and logarithm of the least share at all."""
MOST = 60_000
"""Blocks at most."""


@dataclass(frozen=True)
class Verdict:
    """The likelihoods of two values and of a continuum on the same block means.

    Attributes
    ----------
    gain
        Log-likelihood of telegraph noise less that of a Gauss-Markov process.
    effect
        Telegraph noise at its maximum of likelihood.
    intervals
        95 % intervals of its step and rate.
    """

    gain: float
    effect: RandomTelegraph
    intervals: tuple[tuple[float, float], tuple[float, float]]


def compare(fit: AxisFit, slow: tuple[StochasticEffect, ...]) -> Verdict:
    """Weigh telegraph noise against Gauss-Markov noise in the place of the slow processes of a fit.

    A Gauss-Markov process with a long correlation time stands for a random walk too. The noise besides is white on
    the scale of the blocks.
    """
    interval, count = fit.sequence.conditions.interval, len(fit.residual)
    time = min([one.correlation_time for one in slow if isinstance(one, GaussMarkov)], default=interval * count / LONG)
    width = max(int(time / FINE / interval), count // MOST, 1)
    means = fit.residual[: count // width * width].reshape(-1, width).mean(axis=1)
    rest = [one for one in fit.description.noise.effects if one not in slow]
    step = width * interval
    density = sum(effect.sampled_psd(np.array([0.25 / step]), interval)[0] for effect in rest)
    white = float(np.sqrt(density / step))
    std = float(np.sqrt(max(means.var() - white**2, 0.01 * means.var())))
    least = np.log(std) - DEEP

    def telegraph(theta):
        return -_two_values(
            means, np.exp(theta[0]) / 2, np.exp(theta[1]) * step, np.exp(max(theta[2], least)), theta[3] * std
        )

    def markov(theta):
        return -_continuum(
            means, np.exp(theta[0]), np.exp(-step / np.exp(theta[1])), np.exp(max(theta[2], least)), theta[3] * std
        )

    smooth = _lowest(
        markov, [[np.log(std), np.log(time * f), np.log(max(white, QUIET * std)), 0.0] for f in (1.0, 8.0)]
    )
    best = _lowest(
        telegraph,
        [[np.log(2 * std), np.log(0.5 / time * f), np.log(max(white, QUIET * std)), 0.0] for f in (0.3, 1.0, 3.0)],
    )
    error = _errors(telegraph, best.x)
    ends = [tuple(float(np.exp(best.x[i] + side * 1.96 * error[i])) for side in (-1, 1)) for i in (0, 1)]
    effect = RandomTelegraph(float(np.exp(best.x[0])), float(np.exp(best.x[1])))
    return Verdict(float(smooth.fun - best.fun), effect, (ends[0], ends[1]))


def _lowest(cost, starts):
    """Return the lowest of the minima that starts lead to."""
    options = {"maxiter": 2000, "xatol": 1e-4, "fatol": 1e-4}
    return min((minimize(cost, start, method="Nelder-Mead", options=options) for start in starts), key=_value)


def _value(result) -> float:
    return result.fun


def _errors(cost, top: np.ndarray) -> np.ndarray:
    step = 1e-3
    units = np.eye(len(top)) * step
    hessian = [
        [(cost(top + a + b) - cost(top + a - b) - cost(top - a + b) + cost(top - a - b)) / (4 * step**2) for b in units]
        for a in units
    ]
    return np.sqrt(np.abs(np.diag(np.linalg.pinv(np.array(hessian), hermitian=True))))


@njit(cache=True)
def _two_values(means, half, rate, white, offset):
    """Return the log-likelihood of offset +- half, switching ``rate`` times per block, in white noise."""
    switch = 0.5 * (1 - np.exp(-2 * rate))
    up, value = 0.5, 0.0
    for mean in means:
        high = np.exp(-0.5 * min(((mean - offset - half) / white) ** 2, 1400.0))
        low = np.exp(-0.5 * min(((mean - offset + half) / white) ** 2, 1400.0))
        total = up * high + (1 - up) * low + 1e-300
        value += np.log(total)
        up = up * high / total
        up = up * (1 - switch) + (1 - up) * switch
    return value - len(means) * (np.log(white) + 0.5 * np.log(2 * np.pi))


@njit(cache=True)
def _continuum(means, std, decay, white, offset):
    """Return the log-likelihood of a Gauss-Markov process in white noise (Kalman filter)."""
    state, variance, value = 0.0, std**2, 0.0
    for mean in means:
        innovation, total = mean - offset - state, variance + white**2
        value -= 0.5 * (np.log(2 * np.pi * total) + innovation**2 / total)
        gain = variance / total
        state = decay * (state + gain * innovation)
        variance = decay**2 * variance * (1 - gain) + (1 - decay**2) * std**2
    return value
