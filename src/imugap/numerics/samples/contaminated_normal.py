"""Single samples far off: a mixture of two normal laws in what should be one (Tukey 1960)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.special import expit, logit, pdtrc

from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.chi_square import log_tail

STARTS = ((1e-4, 20.0), (1e-3, 8.0), (1e-2, 4.0), (0.1, 2.0))
"""Shares of the wide law, and its width over that of the narrow one, from which the mixture is fitted."""
BINS = 1000
"""Bins of the squares below the largest, and number of the largest, that are kept one by one."""
MAX_ITERATIONS = 500
MIN_GAIN = 1e-4
"""Gain of log-likelihood below which the mixture is fitted."""
DIFFERENCE_STEP = 1e-3
"""Step of a parameter in a difference quotient."""
MAX_LOG_STD = 100.0
"""Largest standard deviation of a logarithm that is told from no knowledge at all."""
MIN_POSTERIOR = 0.5
"""Posterior probability above which a sample counts as an outlier."""
MIN_PER_PART, MAX_PARTS = 5, 50
"""Outliers in each part of the log that are expected at least, and parts at most, of which the numbers are compared."""


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
        return self.posterior > MIN_POSTERIOR

    @property
    def clustered(self) -> float:
        """Return the log p-value of the number of neighbouring pairs of outliers (test of independence)."""
        flagged = self.flagged
        pairs = int(np.sum(flagged[1:] & flagged[:-1]))
        if not pairs:
            return 0.0
        with np.errstate(divide="ignore"):
            return float(np.log(pdtrc(pairs - 1, flagged.mean() * flagged.sum())))

    @property
    def uneven(self) -> float:
        """Return the log p-value of the numbers of outliers in equal parts of the log (chi-square test)."""
        count = int(self.flagged.sum()) // MIN_PER_PART
        if count < 2:
            return 0.0
        counts = np.array([part.sum() for part in np.array_split(self.flagged, min(count, MAX_PARTS))])
        return log_tail(np.sum((counts - counts.mean()) ** 2) / counts.mean(), len(counts) - 1)

    @property
    def beating(self) -> float:
        """Return the log p-value of a periodicity of the outliers at any period (Rayleigh's test)."""
        flagged = self.flagged
        even, share = next_fast_len(len(flagged), real=True), flagged.mean()
        power = np.abs(rfft(flagged - share, even)[1:]) ** 2 / (flagged.sum() * (1 - share))
        return min(float(np.log(len(power)) - power.max()), 0.0)


def parted_tails(sequence: np.ndarray, share: float, response: np.ndarray) -> Tails:
    """Fit the mixture to a sequence in which an outlier at one sample shows at its neighbours as well.

    Parameters
    ----------
    sequence, share
        As in :func:`tails`.
    response
        What a deviation of one of a sample adds to that sample, which is one, and to the 1st, 2nd, ... on either side.
    """
    found = tails(sequence, share)
    if np.abs(response[1:]).max(initial=0.0) * np.abs(sequence).max() < found.narrow:
        return found
    return tails(_parted(sequence, found, response), share)


def _parted(sequence: np.ndarray, found: Tails, response: np.ndarray) -> np.ndarray:
    """Return a sequence less what its outliers add to other samples (matching pursuit: Mallat and Zhang 1993).

    The largest comes first; a sample that is no outlier without the larger ones beside it adds to none.
    """
    parted, reach = sequence.copy(), len(response) - 1
    around = np.r_[response[:0:-1], 0.0, response[1:]]
    flagged = np.flatnonzero(found.flagged)
    least = np.abs(sequence[flagged]).min(initial=np.inf)
    for place in flagged[np.argsort(-np.abs(sequence[flagged]), kind="stable")]:
        if np.abs(parted[place]) >= least:
            first, last = max(place - reach, 0), min(place + reach + 1, len(parted))
            parted[first:last] -= parted[place] * around[first - place + reach : last - place + reach]
    return parted


def tails(sequence: np.ndarray, share: float = 1.0) -> Tails:
    """Fit the mixture by expectation and maximisation, from several starts.

    Parameters
    ----------
    sequence
        Samples of zero mean, shape (n,).
    share
        Of the frequencies that they hold: so many of the samples are told by the others, and count for nothing.
    """
    squares = sequence**2
    binned = _binned(squares, share)
    robust = np.median(np.abs(sequence)) / 0.6745
    starts = ((rare, robust, factor * robust) for rare, factor in STARTS)
    value, *best = max((_climb(*binned, *start) for start in starts), key=lambda found: found[0])
    single = -0.5 * binned[1].sum() * (np.log(squares.mean()) + 1)
    return Tails(*best, value - single, _posterior(squares, *best), _intervals(*binned, *best))


def _binned(squares: np.ndarray, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Return means of the squares within bins of equal numbers, the largest one by one, and what the numbers count."""
    ordered = np.sort(squares)
    single = min(len(squares) // 2, BINS)
    edges = np.unique(np.linspace(0, len(squares) - single, BINS).astype(int)[:-1])
    edges = np.r_[edges, np.arange(len(squares) - single, len(squares))]
    number = np.diff(np.r_[edges, len(squares)])
    return np.add.reduceat(ordered, edges) / number, number * share


def _log_densities(squares, share, narrow, wide):
    low = np.log1p(-share) - np.log(narrow) - squares / (2 * narrow**2)
    return low, np.log(share) - np.log(wide) - squares / (2 * wide**2)


def _posterior(squares, share, narrow, wide):
    """Return the probability of each sample to be of the wide law, in the memory of its square."""
    squares *= 0.5 / narrow**2 - 0.5 / wide**2
    squares += logit(share) + np.log(narrow) - np.log(wide)
    return expit(squares, out=squares)


def _climb(squares, number, share, narrow, wide):
    last, total = -np.inf, number.sum()
    for _ in range(MAX_ITERATIONS):
        low, high = _log_densities(squares, share, narrow, wide)
        odds = np.exp(-np.abs(high - low))
        value = float(number @ (np.maximum(low, high) + np.log(1 + odds)))
        if value - last < MIN_GAIN:
            break
        last, weight = value, number * np.where(high > low, 1.0, odds) / (1 + odds)
        hit = max(weight.sum(), 1e-9)
        share = float(np.clip(hit / total, 1e-9, 0.5))
        wide = float(np.sqrt((weight @ squares) / hit))
        narrow = float(np.sqrt(((number - weight) @ squares) / (total - hit)))
        wide = max(wide, narrow * (1 + 1e-6))
    return value, share, narrow, wide


def _intervals(squares, number, share, narrow, wide):
    """Return 95 % intervals of share and excess from the observed information in logit and logs."""

    def cost(theta):
        low, high = _log_densities(squares, expit(theta[0]), np.exp(theta[1]), np.exp(theta[2]))
        return -float(number @ np.logaddexp(low, high))

    low, high = ends(cost, np.array([logit(share), np.log(narrow), np.log(wide)]))
    excess = tuple(np.sqrt(max(np.exp(2 * end[2]) - narrow**2, 0.0)) for end in (low, high))
    return (float(expit(low[0])), float(expit(high[0]))), tuple(map(float, excess))


def ends(cost: Callable[[np.ndarray], float], top: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return both ends of 95 % intervals of the parameters at the minimum of a negative log-likelihood, each (m,)."""
    units = np.eye(len(top)) * DIFFERENCE_STEP
    hessian = [
        [
            (cost(top + a + b) - cost(top + a - b) - cost(top - a + b) + cost(top - a - b)) / (4 * DIFFERENCE_STEP**2)
            for b in units
        ]
        for a in units
    ]
    variances = np.abs(np.diag(np.linalg.pinv(np.array(hessian), hermitian=True)))
    reach = NORMAL_QUANTILE * np.sqrt(variances).clip(max=MAX_LOG_STD)
    return top - reach, top + reach
