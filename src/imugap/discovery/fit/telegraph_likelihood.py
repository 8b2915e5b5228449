"""Two values or a continuum? Gauss-Markov and random telegraph noise have one spectrum; their samples differ.

Both are weighed beside a random walk and white noise, the walk for whatever else is slow. Two values on a walk have a
likelihood of as many terms as there are paths: the moments of the walk given the value are kept, as in the interacting
multiple model (Blom and Bar-Shalom 1988). That is enough to weigh the two. To measure, two Gaussians are kept for each
value, and those merged that lose least by it (Runnalls 2007, doi:10.1109/TAES.2007.4383588): beside a process as large
as the step the likelihood of one has several tops.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numba import njit

from imugap.discovery.fit import matched_filters as scans
from imugap.discovery.fit.axis_fit import AxisFit, scale
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import GaussMarkov, RandomTelegraph
from imugap.effects.effect import StochasticEffect, VarianceEffect
from imugap.numerics.fitting.bhhh import Maximum, maximise
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

BLOCKS_PER_TIME = 48
"""Blocks per correlation time, as far as the filter lets a step be over within one."""
SETTLED_SHARE = 0.01
"""Share of a step that is left to come behind a filter when it is over."""
TIMES_PER_LOG = 20.0
"""Correlation times in a log, where nothing tells more."""
MIN_START_NOISE, MAX_NOISE_LOG_RATIO = 1e-3, 10.0
"""White noise over the slow process: least share at the start, and logarithm of the least share at all."""
WALK_STARTS = (0.03, 0.3)
"""Steps of the walk from block to block over the slow process, at the start."""
MAX_BLOCKS = 60_000
"""Blocks at most."""
TIME_FACTORS, RATE_FACTORS = (0.1, 1.0, 8.0), (0.3, 1.0, 3.0)
"""Correlation times and rates at the start, over those of the spectrum."""
MIN_LOG_WEIGHT = np.log(1e-12)
"""Least log-probability of a Gaussian that is kept."""
FIRST_STEP, MAX_STEP = 0.02, 0.3
"""First and longest step of a difference quotient at the top."""
SCORE_ROUNDS = 3
"""Times that the scores are taken, each over steps that those before tell."""
GAUSSIANS = 2
"""Gaussians for each value, to measure with."""
MAX_LOGARITHM = 300.0
"""Logarithm that stands for none or no bound."""
MAX_RATE_LOG_RATIO = 0.5 * np.log(3.0)
"""Half the logarithm of the ratio of two rates, up and down, up to which they are one: real ones are not quite."""
MIN_LOG_SWITCHES, MAX_LOG_SWITCHES = np.log(1e-9), np.log(1e3)
"""Logarithm of the least and of the largest number of switches per block that is asked for."""


@dataclass(frozen=True, eq=False)
class Blocks:
    """Block means of what a fit leaves, on the scale of its slow processes.

    Attributes
    ----------
    means
        Shape (blocks,).
    profile
        Standard deviation of the white noise over its own outside of changes of variance, shape (blocks,).
    width
        Samples of a block.
    step
        From one block to the next [s].
    time
        Shortest correlation time of the slow processes [s].
    white, std
        Standard deviation of the noise that is white on this scale, and of what else the means have.
    """

    means: np.ndarray
    profile: np.ndarray
    width: int
    step: float
    time: float
    white: float
    std: float

    @classmethod
    def of(cls, fit: AxisFit, slow: tuple[StochasticEffect, ...], fine: float = BLOCKS_PER_TIME) -> "Blocks":
        """Cut the residual of a fit in blocks, in which only its processes besides the slow ones are white noise.

        There are ``fine`` blocks, or as many as there are samples, to the shortest correlation time, if the log has as
        many.
        """
        interval, count = fit.sequence.conditions.interval, len(fit.sequence.values)
        lorentzian = [one.equivalent if isinstance(one, RandomTelegraph) else one for one in slow]
        times = [one.correlation_time for one in lorentzian if isinstance(one, GaussMarkov)]
        time = min(times, default=interval * count / TIMES_PER_LOG)
        width = max(
            min(max(int(time / fine / interval), _settling(fit)), count // BLOCKS_PER_TIME), count // MAX_BLOCKS, 1
        )
        means = scans.block_means(fit.residual * fit.scale, width)
        profile = _profile(fit.sequence, fit.description.changes, width)
        rest = [one for one in fit.description.noise.effects if one not in slow]
        step = width * interval
        density = sum(effect.sampled_psd(np.array([0.25 / step]), interval)[0] for effect in rest)
        white = float(np.sqrt(density / step))
        std = float(np.sqrt(max(means.var() - white**2, 0.01 * means.var())))
        return cls(means, profile, width, step, time, white, std)

    def changed(self, sequence: AxisSequence, changes: tuple[VarianceEffect, ...]) -> "Blocks":
        """Return them with other changes of the variance of their white noise."""
        return replace(self, profile=_profile(sequence, changes, self.width))


def _settling(fit: AxisFit) -> int:
    """Return after how many samples a step is over behind the output filter of a fit."""
    passes = fit.description.noise.output_filter
    if passes is None:
        return 0
    left = passes.decay(len(fit.sequence.values), fit.sequence.conditions.interval)
    return int(np.sum(np.abs(left) > SETTLED_SHARE))


def _profile(sequence: AxisSequence, changes: tuple[VarianceEffect, ...], width: int) -> np.ndarray:
    factor = np.broadcast_to(scale(sequence, changes), len(sequence.values))
    return np.sqrt(scans.block_means(factor**2, width))


@dataclass(frozen=True, eq=False)
class TelegraphComparison:
    """Two values and a continuum on the same block means.

    Attributes
    ----------
    blocks
        The block means.
    smooth, two
        Gauss-Markov and telegraph noise at their highest likelihoods.
    """

    blocks: Blocks
    smooth: Maximum
    two: Maximum

    @property
    def gain(self) -> float:
        """Return the log-likelihood of telegraph noise less that of a Gauss-Markov process."""
        return self.two.log_likelihood - self.smooth.log_likelihood

    @property
    def effect(self) -> RandomTelegraph:
        """Return the telegraph noise at its highest likelihood."""
        step, rate = self._measured[:2]
        return RandomTelegraph(_positive(step), _positive(rate))

    @cached_property
    def intervals(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the 95 % intervals of its step and rate."""
        top = self._measured
        error = errors(self._parted, top)
        ends = [[_positive(top[i] + side * NORMAL_QUANTILE * error[i]) for side in (-1, 1)] for i in (0, 1)]
        return tuple(ends[0]), tuple(ends[1])

    @cached_property
    def _measured(self) -> np.ndarray:
        """Return its parameters where a switch may fall within a block, the mean of which is between the two values.

        Taken for one of them it draws both to each other. In the likelihood that is weighed against a continuum there
        are no such blocks: noise of many values would take them for its own.
        """
        return maximise(self._parted, [self.two.theta]).theta

    def _parted(self, theta: np.ndarray) -> np.ndarray:
        """Return the log-density of each block, within which a switch may fall."""
        return _telegraph_densities(self.blocks, theta, self.blocks.width, GAUSSIANS)

    @cached_property
    def uneven(self) -> float:
        """Return the gain of log-likelihood of two rates, up and down, that are farther apart than those of a name."""
        return uneven(partial(_telegraph_densities, self.blocks), self.two)


def compare(fit: AxisFit, slow: tuple[StochasticEffect, ...]) -> TelegraphComparison:
    """Weigh telegraph noise against Gauss-Markov noise in the place of the slow processes of a fit.

    The noise besides is white on the scale of the blocks, or wanders from one to the next.
    """
    blocks = Blocks.of(fit, slow)
    starts = [
        np.r_[np.log([blocks.std, blocks.time * factor]), calm] for factor in TIME_FACTORS for calm in _beside(blocks)
    ]
    return TelegraphComparison(blocks, maximise(partial(_markov_densities, blocks), starts), likeliest(blocks))


def likeliest(blocks: Blocks) -> Maximum:
    """Return telegraph noise in block means at its highest likelihood: logarithms of its step and rate come first."""
    size, rate = 2 * blocks.std, 0.5 / blocks.time
    starts = [np.r_[np.log([size, rate * factor]), calm] for factor in RATE_FACTORS for calm in _beside(blocks)]
    return maximise(partial(_telegraph_densities, blocks), starts)


def uneven(densities: Callable[[np.ndarray], np.ndarray], even: Maximum) -> float:
    """Return the gain of log-likelihood of unequal rates up and down over rates within :data:`MAX_RATE_LOG_RATIO`.

    ``densities`` takes half the logarithm of their ratio as a parameter more than ``even`` has.
    """
    apart = maximise(densities, [np.r_[even.theta, side] for side in (-1.0, 1.0)])
    side = np.clip(apart.theta[-1], -MAX_RATE_LOG_RATIO, MAX_RATE_LOG_RATIO)
    near = maximise(lambda theta: densities(np.r_[theta, side]), [apart.theta[:-1]])
    return apart.log_likelihood - max(near.log_likelihood, even.log_likelihood)


def _beside(blocks: Blocks) -> list[np.ndarray]:
    """Return starts of the logarithms of the noise of a block and of the step of the walk between two."""
    return [np.log([max(blocks.white, MIN_START_NOISE * blocks.std), calm * blocks.std]) for calm in WALK_STARTS]


def _noise(blocks: Blocks, theta: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the noise of each block and the step of the walk."""
    white, walk = np.exp(np.maximum(theta[2:4], np.log(blocks.std) - MAX_NOISE_LOG_RATIO))
    return white * blocks.profile, walk


def _telegraph_densities(blocks: Blocks, theta: np.ndarray, width: int = 1, kept: int = 1) -> np.ndarray:
    """Return the log-density of each block; a fifth parameter is the logarithm of the switches up over the average.

    A switch may fall among ``width`` samples of a block; ``kept`` Gaussians are kept for each value.
    """
    side = theta[4] if len(theta) > 4 else 0.0
    switched = np.exp(
        np.clip(np.log(blocks.step) + theta[1] + np.array([side, -side]), MIN_LOG_SWITCHES, MAX_LOG_SWITCHES)
    )
    white, walk = _noise(blocks, theta)
    slow = 1.0, walk**2, blocks.means.mean(), blocks.means.var()
    return filtered(blocks.means, width, np.exp(theta[0]) / 2, *switched, white, *slow, kept)[0]


def _markov_densities(blocks: Blocks, theta: np.ndarray) -> np.ndarray:
    """Return the log-density of each block of a Gauss-Markov process, given by its size and correlation time."""
    decay = np.exp(-blocks.step / np.exp(theta[1]))
    return continuum_log_densities(blocks.means, np.exp(theta[0]), decay, *_noise(blocks, theta), blocks.means.var())


def _positive(logarithm: float) -> float:
    return float(np.exp(np.clip(logarithm, -MAX_LOGARITHM, MAX_LOGARITHM)))


def errors(densities: Callable[[np.ndarray], np.ndarray], top: np.ndarray) -> np.ndarray:
    """Return the standard deviations of parameters at the highest likelihood, shape (p,).

    By the outer products of the scores, which are difference quotients over about a standard deviation given the other
    parameters: which Gaussians are merged changes from place to place, so that over much shorter ones the likelihood is
    not smooth.
    """
    steps = np.full(len(top), FIRST_STEP)
    for _ in range(SCORE_ROUNDS):
        scores = [(densities(top + one) - densities(top - one)) / (2 * one.max()) for one in np.diag(steps)]
        information = np.array(scores) @ np.transpose(scores)
        steps = 1 / np.sqrt(np.diag(information) + MAX_STEP**-2)
    return np.sqrt(np.diag(np.linalg.pinv(information, hermitian=True)))


@njit(cache=True, error_model="numpy")
def filtered(values, width, half, rise, fall, white, decay, driven, begin, spread, kept=1):
    """Return the log-density of each value, +- half beside a slow process in white noise, and what is known with it.

    Each value is the mean of ``width`` samples; with a switch among these it has a mean and a variance between + and -.
    ``white`` is the noise of each value, shape (n,); ``rise`` and ``fall`` are switches per value; the process keeps a
    share ``decay`` of itself from one value to the next, ``driven`` is the variance that it gains, ``begin`` and
    ``spread`` are its mean and variance before the first. A walk keeps all, a Gauss-Markov process reverts.

    Of the paths that lead to either value ``kept`` Gaussians are kept. They come after the densities, those of + before
    those of -, each as its log-probability, and mean and variance of the process, shape (n, 2 kept, 3).
    """
    mean_up, same = rise / (rise + fall), np.exp(-(rise + fall))
    to_up, to_down = mean_up * (1 - same), (1 - mean_up) * (1 - same)
    rises, falls, stays_up, stays_down = np.log(to_up), np.log(to_down), np.log1p(-to_down), np.log1p(-to_up)
    between, scatter = half / width, half**2 * (1 - 1 / width**2) / 3
    densities, known = np.empty(len(values)), np.empty((len(values), 2 * kept, 3))
    state, ups, downs = np.empty((2 * kept, 3)), np.empty((2 * kept, 3)), np.empty((2 * kept, 3))
    state[:kept, 0], state[kept:, 0] = np.log(mean_up / kept), np.log((1 - mean_up) / kept)
    state[:, 1], state[:, 2] = begin, spread
    for k in range(len(values)):
        noise, high, low = white[k] ** 2, values[k] - half, values[k] + half
        for one in range(2 * kept):
            log_p, mean, variance = state[one, 0], decay * state[one, 1], decay**2 * state[one, 2] + driven
            if one < kept:
                _way(ups, one, log_p + stays_up, high, mean, variance, noise)
                _way(downs, one, log_p + falls, values[k] + between, mean, variance, noise + scatter)
            else:
                _way(ups, one, log_p + rises, values[k] - between, mean, variance, noise + scatter)
                _way(downs, one, log_p + stays_down, low, mean, variance, noise)
        _merge(ups, kept)
        _merge(downs, kept)
        total = _together(ups, downs, kept)
        densities[k] = total - 0.5 * np.log(2 * np.pi)
        for one in range(kept):
            for i in range(3):
                state[one, i], state[kept + one, i] = ups[one, i], downs[one, i]
        for one in range(2 * kept):
            state[one, 0] = max(state[one, 0] - total, MIN_LOG_WEIGHT)
            for i in range(3):
                known[k, one, i] = state[one, i]
    return densities, known


@njit(cache=True, error_model="numpy")
def _way(ways, one, log_p, value, mean, variance, noise):
    """Fill in the log-probability of a value of a normal process in white noise, its mean and variance given that."""
    total, apart = variance + noise, value - mean
    ways[one, 0] = log_p - 0.5 * (np.log(total) + apart**2 / total)
    ways[one, 1], ways[one, 2] = mean + variance / total * apart, variance * noise / total


@njit(cache=True, error_model="numpy")
def _together(ups, downs, kept):
    """Return the log-probability of all."""
    top, total = -np.inf, 0.0
    for one in range(kept):
        top = max(top, ups[one, 0], downs[one, 0])
    for one in range(kept):
        total += np.exp(ups[one, 0] - top) + np.exp(downs[one, 0] - top)
    return top + np.log(total)


@njit(cache=True, error_model="numpy")
def _merge(ways, kept):
    """Merge Gaussians, log-probability, mean and variance each, in place until as many are left, which come first.

    Each is merged with another with the moments of both.
    """
    for count in range(len(ways), kept, -1):
        one, other = _closest(ways, count) if count > 2 else (0, 1)
        top, apart = max(ways[one, 0], ways[other, 0]), ways[one, 1] - ways[other, 1]
        first, second = np.exp(ways[one, 0] - top), np.exp(ways[other, 0] - top)
        share = first / (first + second)
        ways[one, 0] = top + np.log(first + second)
        ways[one, 1] = ways[other, 1] + share * apart
        ways[one, 2] = share * ways[one, 2] + (1 - share) * ways[other, 2] + share * (1 - share) * apart**2
        for i in range(3):
            ways[other, i] = ways[count - 1, i]


@njit(cache=True, error_model="numpy")
def _closest(ways, count):
    """Return which two of the first Gaussians lose least if they are merged (Runnalls 2007, eq. 21)."""
    top, least, pair = -np.inf, np.inf, (0, 1)
    for one in range(count):
        top = max(top, ways[one, 0])
    for one in range(count):
        first = np.exp(ways[one, 0] - top)
        for other in range(one):
            second, apart = np.exp(ways[other, 0] - top), ways[one, 1] - ways[other, 1]
            share = first / (first + second)
            both = share * ways[one, 2] + (1 - share) * ways[other, 2] + share * (1 - share) * apart**2
            loss = first * np.log(both / ways[one, 2]) + second * np.log(both / ways[other, 2])
            if loss < least:
                least, pair = loss, (other, one)
    return pair


@njit(cache=True)
def continuum_log_densities(means, std, decay, white, walk, wide):
    """Return the log-density of each value of a Gauss-Markov process on a walk in white noise (Kalman filter)."""
    state, level, densities = 0.0, means.mean(), np.empty(len(means))
    own, shared, other = std**2, 0.0, wide + walk**2
    for k in range(len(means)):
        innovation, total = means[k] - state - level, own + 2 * shared + other + white[k] ** 2
        densities[k] = -0.5 * (np.log(2 * np.pi * total) + innovation**2 / total)
        first, second = (own + shared) / total, (shared + other) / total
        state, level = decay * (state + first * innovation), level + second * innovation
        own = decay**2 * (own - first**2 * total) + (1 - decay**2) * std**2
        shared = decay * (shared - first * second * total)
        other += walk**2 - second**2 * total
    return densities
