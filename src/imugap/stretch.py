"""Stretches of samples that begin at random and last a random number of samples: gaps, repeats."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.special import expit, logit
from scipy.stats import beta, chi2


def stretches(count: int, probability: float, length: float, rng: np.random.Generator) -> np.ndarray:
    """Return which of ``count`` samples lie in a stretch, shape (count,), bool.

    At each sample after one that is free a stretch begins with ``probability``; the number of its samples is geometric
    with mean ``length``. The first sample is free. The samples form a two-state Markov chain: far from the start the
    share of those in a stretch is p/(p + 1/length).

    Parameters
    ----------
    count
        Number of samples.
    probability
        Probability p that a stretch begins, in [0, 1].
    length
        Mean number of samples of a stretch, at least 1.
    rng
        Source of the random numbers.
    """
    inside = np.zeros(count, bool)
    if probability == 0:
        return inside
    cycles = int(np.ceil(2 * count / (1 / probability + length))) + 8
    start = 0
    while start < count:
        free = np.minimum(rng.geometric(probability, cycles), count)
        held = np.minimum(rng.geometric(1 / length, cycles), count)
        edges = start + np.cumsum(np.column_stack([free, held]).ravel())
        flips = edges[edges < count]
        inside[flips] = True
        start = int(edges[-1])
    return np.logical_xor.accumulate(inside)


@dataclass(frozen=True)
class Estimate:
    """Probability and mean length of stretches, each with its 95 % interval, and the chance that there are none.

    Attributes
    ----------
    probability, length
        Value, lower and upper limit.
    log_p
        Logarithm of the probability of as much without any stretch.
    least
        Samples in a row from which on a run is rather a stretch than chance.
    """

    probability: tuple[float, float, float]
    length: tuple[float, float, float]
    log_p: float
    least: int = 1


def counted(runs: np.ndarray, free: int) -> Estimate:
    """Estimate from stretches that are seen for certain.

    Parameters
    ----------
    runs
        Number of samples of each stretch, shape (stretches,).
    free
        Number of samples after which a stretch could have begun.
    """
    begun, held = len(runs), int(np.sum(runs))
    ends = _binomial(begun, held)
    return Estimate(_binomial(begun, free), (held / begun, 1 / ends[2], 1 / ends[1]), -np.inf)


def _binomial(hits: int, trials: int) -> tuple[float, float, float]:
    """Return a share and its interval (Clopper and Pearson 1934)."""
    low = beta.ppf(0.025, hits, trials - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, trials - hits) if hits < trials else 1.0
    return hits / trials, float(low), float(high)


def disentangled(lengths: np.ndarray, counts: np.ndarray, chance: float, spread: float) -> Estimate:
    """Estimate from runs of repeats of which chance makes some; maximum of the posterior and its curvature.

    A run ends with a sample that differs from the one before, which is free. From there on a chain of two states,
    free and stuck, goes through the repeats: a free sample repeats by ``chance``, a stuck one always.

    Parameters
    ----------
    lengths, counts
        Numbers of repeats in a row, zero included, and how often each is found, shape (m,).
    chance
        Probability that a free sample repeats the one before.
    spread
        Standard deviation of the logarithm of ``chance``.
    """

    def cost(theta: np.ndarray) -> float:
        prior = 0.5 * ((theta[2] - np.log(chance)) / spread) ** 2
        return prior - counts @ _log_run(lengths, expit(theta[0]), expit(theta[1]), np.exp(min(theta[2], -1e-6)))

    def null(log_chance: float) -> float:
        return 0.5 * ((log_chance - np.log(chance)) / spread) ** 2 - counts @ (
            lengths * log_chance + np.log1p(-np.exp(log_chance))
        )

    without = minimize_scalar(null, bounds=(np.log(chance) - 5 * spread - 1, -1e-6), method="bounded").fun
    total = counts.sum()
    starts = [(logit(share), logit(1 / mean), np.log(chance)) for share in (30 / total, 3e-3) for mean in (1.5, 8, 60)]
    fits = [minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-4}) for start in starts]
    best = min(fits, key=lambda fit: fit.fun)
    errors = 1.96 * np.sqrt(np.diag(np.linalg.pinv(_curvature(cost, best.x)))[:2])
    begin, end = ([float(expit(x + k * e)) for k in (0, -1, 1)] for x, e in zip(best.x[:2], errors, strict=True))
    log_p = float(min(chi2.logsf(2 * max(without - best.fun, 0.0), 2), 0.0))
    free = lengths * best.x[2] + np.log1p(-np.exp(best.x[2])) + (lengths + 1) * np.log1p(-begin[0])
    stuck = free - _log_run(lengths, begin[0], end[0], np.exp(best.x[2])) < np.log(0.5)
    least = int(lengths[stuck].min()) if stuck.any() else int(lengths.max()) + 1
    return Estimate(tuple(begin), (1 / end[0], 1 / end[2], 1 / end[1]), log_p, least)


def _log_run(repeats: np.ndarray, begin: float, end: float, chance: float) -> np.ndarray:
    """Return the log-probability of so many repeats until the next sample that differs, from a free sample on."""
    a, b, c, d = (1 - begin) * chance, begin, end * chance, 1 - end
    root = np.sqrt((a - d) ** 2 + 4 * b * c) + 1e-12
    high, low = (a + d + root) / 2, (a + d - root) / 2
    last = np.array([(1 - begin) * (1 - chance), end * (1 - chance)])
    first, second = (a - low) * last[0] + b * last[1], (a - high) * last[0] + b * last[1]
    return repeats * np.log(high) + np.log(np.maximum((first - second * (low / high) ** repeats) / root, 1e-300))


def _curvature(cost, at: np.ndarray, step: float = 0.02) -> np.ndarray:
    """Return the second derivatives of ``cost`` by central differences."""
    moves = step * np.eye(len(at))
    return np.array(
        [[(cost(at + u + v) - cost(at + u - v) - cost(at - u + v) + cost(at - u - v)) for v in moves] for u in moves]
    ) / (4 * step**2)
