"""Single samples far off: a mixture of two normal laws in what should be one (Tukey 1960)."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, logit
from scipy.stats import poisson

STARTS = ((1e-4, 20.0), (1e-3, 8.0), (1e-2, 4.0), (0.1, 2.0))
"""Shares of the wide law, and its width over that of the narrow one, from which the mixture is fitted."""
ROUNDS = 200
SETTLED = 1e-8
FLAGGED = 0.5
"""Posterior probability above which a sample counts as an outlier."""


@dataclass(frozen=True, eq=False)
class Tails:
    """Two normal laws of zero mean in a sequence.

    Attributes
    ----------
    probability
        Share of the wide one.
    narrow, wide
        Their standard deviations.
    gain
        Gain of log-likelihood over one normal law.
    posterior
        Probability of each sample to come from the wide one, shape (n,).
    intervals
        95 % intervals of the probability and of the excess sqrt(wide^2 - narrow^2).
    """

    probability: float
    narrow: float
    wide: float
    gain: float
    posterior: np.ndarray
    intervals: tuple[tuple[float, float], tuple[float, float]]

    @property
    def excess(self) -> float:
        """Return the standard deviation of what outliers add."""
        return float(np.sqrt(max(self.wide**2 - self.narrow**2, 0.0)))

    @property
    def flagged(self) -> np.ndarray:
        """Return which samples are outliers rather than not."""
        return self.posterior > FLAGGED

    @property
    def clustered(self) -> float:
        """Return the log-probability of as many neighbouring pairs of outliers if they came independently."""
        flagged = self.flagged
        pairs = int(np.sum(flagged[1:] & flagged[:-1]))
        return float(poisson.logsf(pairs - 1, flagged.mean() * flagged.sum()))


def tails(sequence: np.ndarray) -> Tails:
    """Fit the mixture by expectation and maximisation, from several starts; ``sequence`` has zero mean, shape (n,)."""
    squares = sequence**2
    robust = np.median(np.abs(sequence)) / 0.6745
    starts = [
        (share, robust, factor * robust) for share, factor in ((1e-4, 20.0), (1e-3, 8.0), (1e-2, 4.0), (0.1, 2.0))
    ]
    best = max((_climb(squares, *start) for start in starts), key=lambda found: found[0])
    value, share, narrow, wide = best
    single = -0.5 * len(squares) * (np.log(squares.mean()) + 1)
    return Tails(
        share, narrow, wide, value - single, _posterior(squares, share, narrow, wide), _intervals(squares, *best[1:])
    )


def _log_densities(squares, share, narrow, wide):
    low = np.log1p(-share) - np.log(narrow) - squares / (2 * narrow**2)
    return low, np.log(share) - np.log(wide) - squares / (2 * wide**2)


def _posterior(squares, share, narrow, wide):
    low, high = _log_densities(squares, share, narrow, wide)
    return expit(high - low)


def _climb(squares, share, narrow, wide):
    last = -np.inf
    for _ in range(ROUNDS):
        low, high = _log_densities(squares, share, narrow, wide)
        value = float(np.logaddexp(low, high).sum())
        if value - last < SETTLED * len(squares):
            break
        last, weight = value, expit(high - low)
        total = max(weight.sum(), 1e-9)
        share = float(np.clip(total / len(squares), 1e-9, 0.5))
        wide = float(np.sqrt((weight @ squares) / total))
        narrow = float(np.sqrt(((1 - weight) @ squares) / (len(squares) - total)))
        wide = max(wide, narrow * (1 + 1e-6))
    return value, share, narrow, wide


def _intervals(squares, share, narrow, wide):
    """Return 95 % intervals of share and excess from the observed information in logit and logs."""

    def cost(theta):
        return -float(np.logaddexp(*_log_densities(squares, expit(theta[0]), np.exp(theta[1]), np.exp(theta[2]))).sum())

    top = minimize(cost, [logit(share), np.log(narrow), np.log(wide)], method="BFGS", options={"maxiter": 8}).x
    step = 1e-3
    units = np.eye(3) * step
    hessian = np.array(
        [
            [
                (cost(top + a + b) - cost(top + a - b) - cost(top - a + b) + cost(top - a - b)) / (4 * step**2)
                for b in units
            ]
            for a in units
        ]
    )
    error = np.sqrt(np.abs(np.diag(np.linalg.pinv(hessian, hermitian=True))))
    odds = [expit(logit(share) + side * 1.96 * error[0]) for side in (-1, 1)]
    ends = [np.sqrt(max((wide * np.exp(side * 1.96 * error[2])) ** 2 - narrow**2, 0.0)) for side in (-1, 1)]
    return (float(odds[0]), float(odds[1])), (float(ends[0]), float(ends[1]))
