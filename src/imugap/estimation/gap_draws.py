"""Draw the samples of long gaps from an error model, given all samples that were measured.

The mean of the states given the measured samples is that of the fixed-interval smoother; with a simulated log whose own
smoothed mean is subtracted it becomes a draw (Durbin and Koopman 2002, doi:10.1093/biomet/89.3.603).
"""

import numpy as np
from numba import njit
from scipy.ndimage import uniform_filter1d

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.likelihood import Composition, Cosines
from imugap.estimation.maximum_likelihood import LikelihoodProblem
from imugap.estimation.screening import Screened, is_scattered

KINDS = (WhiteNoise, GaussMarkov, RandomWalk)
"""Processes of the model from which gaps are drawn: of any log at rest it has the spectrum nearly."""
ROUNDS = 6
"""Rounds of fit and draw."""
AROUND = 64
"""Measured samples of the local mean from which the rounds start."""
DIFFUSE = 1e4
"""Variance of the unknown start of a random walk, over that of the log."""


def with_gaps_drawn(screened: Screened, interval: float, rng: np.random.Generator) -> np.ndarray:
    """Return the samples of a screened log, shape (n,), with gaps beyond the reach of an autoregression drawn anew."""
    if is_scattered(screened.replaced):
        return screened.values
    return draw_gaps(screened.values, screened.replaced, interval, rng)


def draw_gaps(values: np.ndarray, missing: np.ndarray, interval: float, rng: np.random.Generator) -> np.ndarray:
    """Draw missing samples, alternately with a fit of the model of the log to what was drawn (stochastic EM).

    Parameters
    ----------
    values
        Samples, shape (n,), with anything in the place of those that are missing.
    missing
        Which are missing, shape (n,).
    interval
        Sampling interval [s].
    """
    values = _bridged(values, missing, rng)
    for _ in range(ROUNDS):
        model = _fitted(values, interval)
        values = drawn(model, values, missing, interval, rng)
    return values


def _bridged(values: np.ndarray, missing: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return the samples with noise about a local mean of the measured ones in the place of the missing."""
    present = np.flatnonzero(~missing)
    measured = values[present]
    level = uniform_filter1d(measured, min(AROUND, len(measured)), mode="nearest")
    noise = np.std(np.diff(measured)) / np.sqrt(2)
    bridge = np.interp(np.arange(len(values)), present, level) + noise * rng.standard_normal(len(values))
    return np.where(missing, bridge, values)


def _fitted(values: np.ndarray, interval: float) -> AxisModel:
    composition = Composition.of(*KINDS)
    return composition.model(LikelihoodProblem(composition, Cosines.of(values, interval)).maximise()[0])


def drawn(
    model: AxisModel, values: np.ndarray, missing: np.ndarray, interval: float, rng: np.random.Generator
) -> np.ndarray:
    """Draw missing samples from a model with a state space, given the others; all shapes (n,)."""
    system, level = model.state_space(), float(values[~missing].mean())
    white = np.sqrt(system.output_psd / interval) * rng.standard_normal(len(values))
    if not len(system.output):
        return np.where(missing, level + white, values)
    transition, process = system.discretise(interval)
    roots = [_root(covariance) for covariance in (process, system.initial_covariance)]
    noise = rng.standard_normal((len(values), len(system.output))) @ roots[0].T
    noise[0] = roots[1] @ rng.standard_normal(len(system.output))
    simulated = _states(transition, noise)
    start = system.initial_covariance + 0.0
    still = np.diag(start) == 0
    start[still, still] = DIFFUSE * values[~missing].var()
    rest = values - level - simulated @ system.output - white
    smoothed = _smoothed(rest, missing, transition, process, system.output, system.output_psd / interval, start)
    return np.where(missing, level + smoothed + simulated @ system.output + white, values)


def _root(covariance: np.ndarray) -> np.ndarray:
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0))


@njit(cache=True)
def _states(transition, noise):
    states = noise.copy()
    for k in range(1, len(noise)):
        for i in range(noise.shape[1]):
            for j in range(noise.shape[1]):
                states[k, i] += transition[i, j] * states[k - 1, j]
    return states


@njit(cache=True)
def _smoothed(values, missing, transition, process, output, white, covariance):
    """Return the smoothed mean of the output without its white noise, shape (n,)."""
    count, size = len(values), len(output)
    predicted, spread = np.zeros((count, size)), np.empty((count, size, size))
    error, variance = np.zeros(count), np.ones(count)
    state, before = np.zeros(size), covariance.copy()
    for k in range(count):
        predicted[k], spread[k] = state, before
        after, gain = before, np.zeros(size)
        if not missing[k]:
            across = before @ output
            variance[k] = output @ across + white
            error[k] = values[k] - output @ state
            gain = across / variance[k]
            after = before - np.outer(gain, across)
        state = transition @ (state + gain * error[k])
        before = transition @ after @ transition.T + process
        before = (before + before.T) / 2
    result, pull = np.empty(count), np.zeros(size)
    for k in range(count - 1, -1, -1):
        pull = transition.T @ pull
        if not missing[k]:
            gain = spread[k] @ output / variance[k]
            pull = pull + output * (error[k] / variance[k] - gain @ pull)
        result[k] = output @ (predicted[k] + spread[k] @ pull)
    return result
