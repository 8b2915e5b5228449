"""Random runs of samples (gaps, repeats): simulation as a two-state Markov chain, and estimation of its parameters."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import betaincinv, expit, logit, logsumexp

from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.skipped_draws import MOST, skipped

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(9)
"""Gauss-Hermite nodes [standard deviations] and weights of normal noise."""
TINY = 1e-9
"""Lower limit of the probability that a run ends."""
NARROW = 0.4
"""Standard deviation of the logarithm of the narrowness k of the probability of a repeat over the levels."""
LARGE = 2.0
"""Largest logarithm of k."""


def simulate_runs(count: int, probability: float, length: float, rng: np.random.Generator) -> np.ndarray:
    """Return which of ``count`` samples are inside a run, shape (count,), bool.

    After each sample outside of a run, a run begins with ``probability``; the number of its samples is geometric
    with mean ``length``. The first sample is outside. The samples form a two-state Markov chain: far from the start the
    share of those inside is p/(p + 1/length).

    Parameters
    ----------
    count
        Number of samples.
    probability
        Probability p that a run begins, in [0, 1].
    length
        Mean number of samples of a run, at least 1.
    rng
        Random generator.
    """
    return runs_in_parts(count, probability, length, rng)(count)


def runs_in_parts(
    count: int, probability: float, length: float, rng: np.random.Generator
) -> Callable[[int], np.ndarray]:
    """Return a function that gives :func:`simulate_runs` for so many samples more, in bounded memory."""
    ends = _ends(count, probability, length, rng)
    waiting, first, within = np.zeros(0, int), 0, False

    def following(size: int) -> np.ndarray:
        nonlocal waiting, first, within
        while not len(waiting) or waiting[-1] < first + size:
            more = next(ends, None)
            if more is None:
                break
            waiting = np.r_[waiting, more]
        here = waiting[: np.searchsorted(waiting, first + size)]
        flips = np.zeros(size, bool)
        flips[here - first] = True
        inside = within ^ np.logical_xor.accumulate(flips)
        waiting, first, within = waiting[len(here) :], first + size, within ^ bool(len(here) % 2)
        return inside

    return following


def _ends(count: int, probability: float, length: float, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield where stretches outside and inside of runs end in turn, increasing, until past ``count``."""
    if probability == 0:
        return
    cycles = int(np.ceil(2 * count / (1 / probability + length))) + 8
    start = 0
    while start < count:
        later = skipped(rng, lambda rng, size: rng.geometric(probability, size), cycles)
        for done in range(0, cycles, MOST):
            size = min(MOST, cycles - done)
            free = np.minimum(rng.geometric(probability, size), count)
            held = np.minimum(later.geometric(1 / length, size), count)
            ends = start + np.cumsum(np.column_stack([free, held]).ravel())
            start = int(ends[-1])
            yield ends
            if start >= count:
                return
        rng = later


@dataclass(frozen=True)
class RunEstimate:
    """Probability and mean length of runs, each with its 95 % interval, and the p-value of their absence.

    Attributes
    ----------
    probability, length
        Value, lower and upper limit.
    log_p
        Logarithm of the p-value of the hypothesis that there are no runs.
    least
        Repeats in a row from which on a run is more probable than free samples.
    """

    probability: tuple[float, float, float]
    length: tuple[float, float, float]
    log_p: float
    least: int = 1


def estimate_from_runs(runs: np.ndarray, free: int) -> RunEstimate:
    """Estimate from runs that are known.

    Parameters
    ----------
    runs
        Number of samples of each run, shape (runs,).
    free
        Number of samples after which a run could have begun.
    """
    begun, held = len(runs), int(np.sum(runs))
    ends = _binomial(begun, held)
    return RunEstimate(_binomial(begun, free), (held / begun, 1 / ends[2], 1 / ends[1]), -np.inf)


def _binomial(hits: int, trials: int) -> tuple[float, float, float]:
    """Return a share and its interval (Clopper and Pearson 1934)."""
    low = float(betaincinv(hits, trials - hits + 1, 0.025)) if hits else 0.0
    high = float(betaincinv(hits + 1, trials - hits, 0.975)) if hits < trials else 1.0
    return hits / trials, low, high


def estimate_from_repeats(
    lengths: np.ndarray, counts: np.ndarray, probability: float, spread: float, log_alpha: float
) -> RunEstimate | None:
    """Estimate from sequences of repeats, some of them random: maximum of the posterior and its curvature.

    A sequence ends with a sample that differs from the previous one, and is free. The samples are a Markov chain of two
    states: a free sample repeats at random, a stuck one always. The probability of a random repeat over the level is
    ``p exp(-k x^2/2)`` for x ~ N(0, 1): k is 1 for white noise, smaller for correlated neighbours, and larger
    where the variance changes; the prior of its logarithm is N(0, NARROW^2).

    Parameters
    ----------
    lengths, counts
        Numbers of repeats in a row, zero included, and the count of each, shape (m,).
    probability
        Mean probability that a free sample repeats the one before.
    spread
        Standard deviation of the logarithm of ``probability``.
    log_alpha
        Logarithm of the p-value above which the result is None.
    """

    def cost(theta: np.ndarray) -> float:
        prior = 0.5 * ((theta[0] - np.log(probability)) / spread) ** 2 + 0.5 * (theta[1] / NARROW) ** 2
        begin, end = expit(theta[2:]) if len(theta) > 2 else (0.0, 1.0)
        return prior - counts @ _log_runs(lengths, begin, end, *_levels(theta))

    plain = _least(cost, [[np.log(probability), 0.0]])
    total = counts.sum()
    # Of a gain g of log-likelihood by two parameters, chi-square with two degrees of freedom has the tail exp(-g).
    if -max(plain.fun + counts @ np.log(counts / total), 0.0) > log_alpha:
        return None
    starts = [[*plain.x, logit(share), logit(1 / mean)] for share, mean in ((30 / total, 1.5), (3e-3, 5), (3e-3, 50))]
    best = _least(cost, starts)
    errors = NORMAL_QUANTILE * np.sqrt(np.maximum(np.diag(np.linalg.pinv(_curvature(cost, best.x)))[2:], 0.0))
    begin, end = ([float(expit(x + k * e)) for k in (0, -1, 1)] for x, e in zip(best.x[2:], errors, strict=True))
    log_p = -max(float(plain.fun - best.fun), 0.0)
    free = _log_runs(lengths, 0.0, 1.0, *_levels(best.x)) + (lengths + 1) * np.log1p(-begin[0])
    stuck = free - _log_runs(lengths, begin[0], end[0], *_levels(best.x)) < np.log(0.5)
    least = int(lengths[stuck].min()) if stuck.any() else int(lengths.max()) + 1
    return RunEstimate(tuple(begin), tuple(1 / max(end[k], TINY) for k in (0, 2, 1)), log_p, least)


def _least(cost, starts: list[list[float]]):
    """Return the best of the minima of the simplex method from several starts."""
    options = {"xatol": 1e-3, "fatol": 1e-3, "maxiter": 600}
    fits = [minimize(cost, start, method="Nelder-Mead", options=options) for start in starts]
    return min(fits, key=lambda fit: fit.fun)


def _levels(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return probabilities of a repeat at several levels and the share of sequences from there, shape (levels,)."""
    narrow = np.exp(min(theta[1], LARGE))
    highest = np.exp(theta[0]) * np.sqrt(1 + narrow)
    probabilities = np.minimum(highest * np.exp(-0.5 * narrow * NODES**2), 1 - 1e-6)
    shares = WEIGHTS * (1 - probabilities)
    return probabilities, shares / shares.sum()


def _log_runs(
    repeats: np.ndarray, begin: float, end: float, probabilities: np.ndarray, shares: np.ndarray
) -> np.ndarray:
    """Return the log-probability of numbers of repeats until the next sample that differs, from a free sample on."""
    probability, length = probabilities[:, None], repeats[None, :]
    a, b, c, d = (1 - begin) * probability, begin, end * probability, 1 - end
    root = np.sqrt((a - d) ** 2 + 4 * b * c) + 1e-12
    high, low = (a + d + root) / 2, (a + d - root) / 2
    differs = (1 - begin) * (1 - probability), end * (1 - probability)
    first, second = ((a - other) * differs[0] + b * differs[1] for other in (low, high))
    log_run = length * np.log(high) + np.log(np.maximum((first - second * (low / high) ** length) / root, 1e-300))
    return logsumexp(log_run, axis=0, b=shares[:, None])


def _curvature(cost, at: np.ndarray, step: float = 0.02) -> np.ndarray:
    """Return the second derivatives of ``cost`` by central differences."""
    moves = step * np.eye(len(at))
    return np.array(
        [[(cost(at + u + v) - cost(at + u - v) - cost(at - u + v) + cost(at - u - v)) for v in moves] for u in moves]
    ) / (4 * step**2)
