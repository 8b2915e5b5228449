"""Two values or a continuum? Gauss-Markov and random telegraph noise have one spectrum; their samples differ."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import minimize

from imugap.discovery.axis import AxisFit
from imugap.discovery.noise import Noise
from imugap.effects import GaussMarkov, RandomTelegraph

FINE = 12
"""Blocks per correlation time."""
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


def compare(fit: AxisFit, process: GaussMarkov) -> Verdict:
    """Weigh telegraph noise against a Gauss-Markov process of a fit; the noise besides is taken as white."""
    interval = fit.sequence.conditions.interval
    width = max(int(process.correlation_time / FINE / interval), len(fit.residual) // MOST, 1)
    blocks = len(fit.residual) // width
    means = fit.residual[: blocks * width].reshape(blocks, width).mean(axis=1)
    step = width * interval
    rest = Noise(tuple(one for one in fit.description.noise.effects if one is not process))
    frequency = np.array([0.25 / step])
    white = np.sqrt(float(rest.variance(frequency, interval)[0]) / width)

    def telegraph(theta):
        return -_two_values(means, np.exp(theta[0]) / 2, np.exp(theta[1]) * step, np.exp(theta[2]), theta[3] * scale)

    def markov(theta):
        decay = np.exp(-step / np.exp(theta[1]))
        return -_continuum(means, np.exp(theta[0]), decay, np.exp(theta[2]), theta[3] * scale)

    scale = process.std
    smooth = minimize(
        markov, [np.log(process.std), np.log(process.correlation_time), np.log(white), 0.0], method="Nelder-Mead"
    )
    starts = [
        [np.log(2 * process.std), np.log(0.5 / process.correlation_time * factor), np.log(white), 0.0]
        for factor in (0.5, 1.0, 2.0)
    ]
    options = {"maxiter": 2000, "xatol": 1e-4, "fatol": 1e-4}
    best = min((minimize(telegraph, start, method="Nelder-Mead", options=options) for start in starts), key=_value)
    error = _errors(telegraph, best.x)
    ends = [tuple(np.exp(best.x[i] + side * 1.96 * error[i]) for side in (-1, 1)) for i in (0, 1)]
    effect = RandomTelegraph(float(np.exp(best.x[0])), float(np.exp(best.x[1])))
    return Verdict(float(smooth.fun - best.fun), effect, (ends[0], ends[1]))


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
