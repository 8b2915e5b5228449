"""Telegraph noise beside a process that reverts to its mean: one spectrum, but two values in the samples.

A search by spectra cannot tell two Lorentzians apart and ends with steps beside one of them. The samples can
(:mod:`imugap.discovery.fit.telegraph_likelihood`, the walk of which gives way to a Gauss-Markov process): what switches
is found, taken out of the samples, and the search starts again with what is left.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numba import njit

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.telegraph_likelihood import GAUSSIANS, Blocks, compare, errors, filtered, uneven
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import log_p_of_gain
from imugap.effects import RandomTelegraph
from imugap.effects.effect import StochasticEffect
from imugap.numerics.fitting.bhhh import maximise
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.stream import stream

TIME_FACTORS = (1.0, 5.0)
"""Correlation times of the process beside, over the shortest that there is, from which a fit starts."""
MAX_LOGARITHM = 60.0
"""Logarithm that stands for none or no bound."""


@dataclass(frozen=True, eq=False)
class Switching:
    """Telegraph noise that its samples tell beside another process.

    Attributes
    ----------
    effect
        The telegraph noise.
    intervals
        95 % intervals of its parameters, by name.
    gain
        Log-likelihood over that of a continuum.
    path
        Its values at the samples, plus or minus half its step, drawn given all of them, shape (n,).
    """

    effect: RandomTelegraph
    intervals: dict[str, tuple[float, float]]
    gain: float
    path: np.ndarray

    @property
    def log_p(self) -> float:
        """Return the log p-value of the gain over a continuum."""
        return log_p_of_gain(self.gain, len(self.intervals))

    def without(self, sequence: AxisSequence) -> AxisSequence:
        """Return the sequence without it."""
        return sequence.with_values(sequence.values - self.path)


def switching(found: AxisFit, slow: tuple[StochasticEffect, ...], log_alpha: float) -> Switching | None:
    """Return the telegraph noise among slow processes of a fit, if it is certain that another one is beside it.

    Or if a change of the variance is, which a search by spectra takes for one of the switches too. None where the
    samples do not show two values, or are at one of them more often than at the other.
    """
    comparison = compare(found, slow)
    blocks = comparison.blocks
    if log_p_of_gain(comparison.gain, 2) > log_alpha:
        return None
    first = np.log([comparison.effect.step, comparison.effect.rate, blocks.white, 0.5 * blocks.std])
    starts = [np.r_[first, np.log(blocks.time * factor), 0.0] for factor in TIME_FACTORS]
    best = maximise(lambda theta: _densities(blocks, _even(theta)), starts)
    if (
        log_p_of_gain(best.log_likelihood - comparison.two.log_likelihood, 2) > log_alpha
        and not found.description.changes
    ):
        return None
    if log_p_of_gain(uneven(lambda theta: _densities(blocks, theta), best), 1) < log_alpha:
        return None
    return _told(found, Blocks.of(found, slow, np.inf), best.theta, blocks.width, comparison.gain)


def _told(found: AxisFit, blocks: Blocks, near: np.ndarray, width: int, gain: float) -> Switching:
    """Return what blocks as fine as can be tell, within which a switch may fall; ``near`` is of coarser ones."""
    start = near.copy()
    start[2] += 0.5 * np.log(width / blocks.width)
    parted = partial(_parted, blocks)
    best = maximise(parted, [start]).theta
    error = errors(parted, best)
    ends = [tuple(float(np.exp(best[i] + side * NORMAL_QUANTILE * error[i])) for side in (-1, 1)) for i in (0, 1)]
    effect = RandomTelegraph(*np.exp(best[:2]).tolist())
    return Switching(effect, dict(zip(effect.parameters(), ends, strict=True)), gain, _path(found, blocks, best))


def _even(theta: np.ndarray) -> np.ndarray:
    """Return the parameters of as many switches up as down."""
    return np.r_[theta, 0.0]


def _parted(blocks: Blocks, theta: np.ndarray) -> np.ndarray:
    """Return the log-density of each block, within which a switch may fall."""
    return _densities(blocks, _even(theta), blocks.width, GAUSSIANS)


def _densities(blocks: Blocks, theta: np.ndarray, width: int = 1, kept: int = 1) -> np.ndarray:
    """Return the log-density of each block, given those before.

    A switch may fall among ``width`` samples of a block; ``kept`` Gaussians are kept for each value.

    ``theta`` has the logarithms of step, rate, white noise, and of standard deviation and correlation time of the
    process beside; its mean, over the scale of the blocks; the logarithm of the switches up over those on average.
    """
    step, rate, white, std, time = np.exp(np.clip(theta[:5], -MAX_LOGARITHM, MAX_LOGARITHM))
    up, down = blocks.step * rate * np.exp(np.clip([theta[6], -theta[6]], -MAX_LOGARITHM, MAX_LOGARITHM))
    values = blocks.means - theta[5] * blocks.std
    process = stationary_markov(std, np.exp(-blocks.step / time))
    return filtered(values, width, step / 2, up, down, white * blocks.profile, *process, kept)[0]


def stationary_markov(std: float, decay: float) -> tuple[float, float, float, float]:
    """Return decay, driving variance, mean and start variance of a stationary Gauss-Markov process."""
    return decay, std**2 * (1 - decay**2), 0.0, std**2


def _path(found: AxisFit, blocks: Blocks, theta: np.ndarray) -> np.ndarray:
    """Draw the values at the samples, given all of them, shape (n,).

    Without values so drawn samples scatter as those of a device that does not switch; without the likeliest ones they
    would scatter less, or more where these are wrong (data augmentation: Tanner and Wong 1987, doi:10.2307/2289457).
    """
    conditions = found.sequence.conditions
    step, rate, white, std, time = np.exp(np.clip(theta[:5], -MAX_LOGARITHM, MAX_LOGARITHM))
    decay, noise = np.exp(-conditions.interval / time), white * np.sqrt(blocks.width)
    each = rate * conditions.interval
    values = found.residual * found.scale - theta[5] * blocks.std
    noise *= np.broadcast_to(found.scale, len(values))
    known = filtered(values, 1, step / 2, each, each, noise, *stationary_markov(std, decay), GAUSSIANS)[1]
    rng = stream(0, "switching", conditions.axis)
    uniform, normal = rng.random(len(values)), rng.standard_normal(len(values))
    up = drawn_values(known, np.exp(-2 * each), decay, std, uniform, normal)
    return np.where(up, step / 2, -step / 2)


@njit(cache=True)
def drawn_values(known, correlation, decay, std, uniform, normal):
    """Return whether the value is + at each place, drawn backwards together with the process beside.

    ``known`` is what :func:`imugap.discovery.fit.telegraph_likelihood.filtered` knows, ``correlation`` that of the two
    values from one place to the next, with as many switches up as down.
    """
    count, few = known.shape[0], known.shape[1]
    up, driven, level = np.empty(count, np.bool_), std**2 * (1 - decay**2), 0.0
    weights = np.empty(few)
    for k in range(count - 1, -1, -1):
        for one in range(few):
            weights[one] = known[k, one, 0]
            if k < count - 1:
                total = decay**2 * known[k, one, 2] + driven
                stays = (one < few // 2) == up[k + 1]
                log_p = np.log((1 + correlation) / 2 if stays else (1 - correlation) / 2)
                weights[one] += log_p - 0.5 * (np.log(total) + (level - decay * known[k, one, 1]) ** 2 / total)
        shares = np.cumsum(np.exp(weights - weights.max()))
        one = np.searchsorted(shares, uniform[k] * shares[-1])
        up[k] = one < few // 2
        mean, variance = known[k, one, 1], known[k, one, 2]
        if k < count - 1:
            total = decay**2 * variance + driven
            mean, variance = mean + decay * variance / total * (level - decay * mean), variance * driven / total
        level = mean + np.sqrt(variance) * normal[k]
    return up
