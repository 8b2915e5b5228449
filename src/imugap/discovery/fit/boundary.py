"""What the samples of a log hold from outside of it.

Differences of rounding errors, S ~ f^2, are as smooth at the ends of a log as the cosines need but for those before the
first sample and at the last; they are replaced by nothing where the log tells them (their posterior mean), and stay
where other noise hides them. A filter of the output has still to let go of what was there before the log, of which
nothing is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from imugap.discovery.fit.whittle import Noise
from imugap.discovery.preparation.cosine_bins import cosine_coefficients
from imugap.effects.effect import TINY, FilterEffect
from imugap.numerics.fitting import normal_equations

EPSILON = float(np.finfo(float).eps)
CUTOFF_LOG_STD = 0.03
"""Standard deviation of the logarithm of a cutoff, as far as what a filter lets go of may say."""


@dataclass(frozen=True, eq=False)
class Outside:
    """What may be in the samples from outside of the log, and how well the log tells how much of it is.

    Attributes
    ----------
    columns
        Cosine coefficients k = 1..n-1 of each, shape (n - 1, m).
    weighed
        The same over the variance of each coefficient.
    known
        Inverse of the variance of each size a priori, shape (m,).
    filtered
        Whether the last is what a slightly lower cutoff would change of the last but one, and is as large.
    """

    columns: np.ndarray
    weighed: np.ndarray
    known: Sequence[float]
    filtered: bool

    @classmethod
    def of(cls, noise: Noise, count: int, interval: float, root: np.ndarray) -> "Outside | None":
        """Return what the noise and the filter of an axis bring in, if anything.

        Parameters
        ----------
        noise
            Random effects and filter.
        count, interval
            Number of samples n and sampling interval [s].
        root
            Standard deviation of each cosine coefficient, infinite where it is not used, shape (n - 1,).
        """
        filtered = noise.output_filter is not None
        known = (*[max(step**2, TINY) ** -1 for step in _steps(noise, interval)] * 2, *[0.0, 1.0] * filtered)
        if not known:
            return None
        columns = cosine_coefficients(over_time(noise, count, interval)) if filtered else _of_ends(count)
        return cls(columns, columns / root[:, None] ** 2, known, filtered)

    @cached_property
    def precision(self) -> np.ndarray:
        """Inverse of the covariance of the sizes that the samples alone give, shape (m, m)."""
        return self.columns.T @ self.weighed

    def sizes(self, seen: np.ndarray) -> np.ndarray:
        """Return how much of each is in the samples of cosine coefficients ``seen``, shape (m,)."""
        precision, right = self.precision, self.weighed.T @ seen
        units = np.ones(len(right))
        if self.filtered:
            units[-1] = _solved(precision[:-1, :-1], right[:-1], self.known[:-1])[-1]
        return units * _solved(precision * np.outer(units, units), right * units, self.known)

    def without(self, seen: np.ndarray) -> np.ndarray:
        """Return cosine coefficients, shape (n - 1,), without what is from outside."""
        return seen - self.columns @ self.sizes(seen)


def over_time(noise: Noise, count: int, interval: float) -> np.ndarray:
    """Return what may be in the samples from outside as it is over time, shape (count, m), as columns of Outside."""
    output_filter, rounded = noise.output_filter, bool(_steps(noise, interval))
    ends = np.hstack([np.eye(count, 1), np.eye(count, 1, 1 - count)]) if rounded else np.empty((count, 0))
    if output_filter is None:
        return ends
    passed = output_filter.passed(ends, interval) if rounded else ends
    return np.column_stack([passed, *_decay(output_filter, count, interval)])


def _steps(noise: Noise, interval: float) -> list[float]:
    """Return the standard deviation of a difference that one rounding error makes, where there are such errors."""
    return [error for effect in noise.effects if (error := effect.end_error(interval))][:1]


@lru_cache(maxsize=2)
def _of_ends(count: int) -> np.ndarray:
    """Return the cosine coefficients k = 1..n-1 of a one at the first and at the last sample, shape (n - 1, 2)."""
    order = np.arange(1, count)
    first = np.sqrt(2 / count) * np.cos(np.pi * order / (2 * count))
    columns = np.array([first, np.where(order % 2, -first, first)]).T
    columns.flags.writeable = False
    return columns


def _decay(output_filter: FilterEffect, count: int, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return how a filter lets go of what was before the log, and how else it would do so by a lower cutoff."""
    lower = output_filter.adjusted_to(output_filter.adjusted * (1 - CUTOFF_LOG_STD))
    decay = output_filter.decay(count, interval)
    return decay, lower.decay(count, interval) - decay


def _solved(precision: np.ndarray, right: np.ndarray, known: Sequence[float]) -> np.ndarray:
    """Return sizes of least squares, each zero to 1/sqrt(``known``) a priori."""
    return normal_equations.solution(precision + np.diag(known), right, EPSILON * len(right))
