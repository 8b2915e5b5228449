"""Jitter of the time stamps."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.special import chdtrc, chdtri

from imugap.effects.block import Block, inf, isnan, nextafter, require_short
from imugap.effects.effect import TINY, ClockEffect, Evidence, parameter
from imugap.integrity.timestamps import LEAST, ROUNDED, Stamps

COLOURED = 0.15
"""Correlation of neighbouring displacements above which the clock wanders."""
DISORDER = 10.0
"""Distance [standard deviations] beyond which no two stamps of a log change places."""
BOUNDED = 2.3
"""Kurtosis below which displacements are by rounding (uniform: 1.8, normal: 3)."""


@dataclass(frozen=True)
class TimestampJitter(ClockEffect):
    """Stamps displaced independently by N(0, std^2); the samples themselves are taken at the right time.

    Displaced stamps are sorted, so that time increases.
    """

    name: ClassVar[str] = "timestamp_jitter"
    displaces: ClassVar[bool] = True
    std: float = parameter("s", "standard deviation of the displacement")

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the log with displaced, strictly increasing stamps."""
        return next(self.keep_parts(iter([log]), len(log), rng))

    def keep_parts(self, parts: Iterator[pd.DataFrame], count: int, rng: np.random.Generator) -> Iterator[pd.DataFrame]:
        """Yield the rows whose stamp no later one can precede (:data:`DISORDER`), with their stamps."""
        parts = (part for part in parts if len(part))
        rows, stamps, last, following = None, np.zeros(0), -np.inf, next(parts, None)
        while following is not None:
            rows = following if rows is None else pd.concat([rows, following])
            drawn = following.index.to_numpy() + self.std * rng.standard_normal(len(following))
            stamps = np.sort(np.r_[stamps, drawn])
            following = next(parts, None)
            sure = len(stamps)
            if following is not None:
                sure = int(np.searchsorted(stamps, rows.index[-1] - DISORDER * self.std))
            if sure:
                ready = _increasing(np.r_[last, stamps[:sure]])[1:]
                yield rows.iloc[:sure].set_axis(pd.Index(ready, name=rows.index.name))
                rows, stamps, last = rows.iloc[sure:], stamps[sure:], ready[-1]

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step: the lowest of the displaced stamps that may be out of order comes first."""
        require_short(self.name, DISORDER * self.std / interval)
        ahead = max(int(np.ceil(DISORDER * self.std / interval)) - 1, 0)
        waiting = {"waiting": np.full(ahead + 1, np.inf), "ahead": ahead, "free": ahead, "last": -np.inf}
        return Block(_step, {"std": self.std, **waiting}, _start, ahead=ahead)

    @classmethod
    def found(cls, stamps: Stamps) -> Evidence | None:
        """Return the jitter of stamps that scatter independently, beyond their rounding, or None.

        A variance of n values of kurtosis k is as uncertain as one of 2 n/(k - 1) normal values: of stamps written in
        coarse ticks few are displaced at all.
        """
        if not stamps.even or stamps.scatter.size < LEAST:
            return None
        excess = stamps.variance - stamps.rounding_variance
        if stamps.variance < ROUNDED * stamps.rounding_variance or not independent(stamps.scatter):
            return None
        freedom = 2 * stamps.freedom / (_kurtosis(stamps.scatter) - 1)
        limits = stamps.variance * freedom / chdtri(freedom, [0.025, 0.975]) - stamps.rounding_variance
        low, high = (float(np.sqrt(max(limit, 0.0))) for limit in limits)
        p_value = chdtrc(stamps.freedom, stamps.variance * stamps.freedom / stamps.rounding_variance)
        log_p = float(np.log(max(p_value, TINY)))
        return Evidence(cls(float(np.sqrt(excess))), {"std": (low, high)}, log_p, np.zeros(len(stamps.time), bool))


def _increasing(stamps: np.ndarray) -> np.ndarray:
    """Return sorted stamps; equal ones are moved up to the next number."""
    for row in np.flatnonzero(np.diff(stamps) <= 0) + 1:
        stamps[row] = np.nextafter(stamps[row - 1], np.inf)
    return stamps


def independent(scatter: np.ndarray) -> bool:
    """Return whether displacements, shape (windows, rows), are independent with unbounded distribution.

    Neighbours are uncorrelated, so that the steps of the stamps have the correlation -1/2; those of a clock that
    wanders are not. A line is fitted to each window of m rows, which leaves the correlation -4/m at most.
    """
    variance = np.mean(scatter**2)
    correlation = [np.mean(scatter[:, lag:] * scatter[:, :-lag]) / variance for lag in (1, 2, 3)]
    allowed = COLOURED + 3 / np.sqrt(scatter.size)
    return bool(_kurtosis(scatter) > BOUNDED and np.all(np.abs(correlation) < allowed))


def _kurtosis(values: np.ndarray) -> float:
    """Return the fourth central moment of values over their squared variance: 3 for normal ones."""
    squares = (values - values.mean()) ** 2
    return float(np.mean(squares**2) / np.mean(squares) ** 2)


def _start(own, x, now):
    for k in range(own.ahead):
        if now.known(k):
            own.waiting[k] = now.time(k) + own.std * own.draw.normal()


def _step(own, x, now):
    if now.known(own.ahead):
        own.waiting[own.free] = now.time(own.ahead) + own.std * own.draw.normal()
    own.free = 0
    for k in range(1, len(own.waiting)):
        if own.waiting[k] < own.waiting[own.free]:
            own.free = k
    y = x + (own.waiting[own.free] - now.time(0))
    own.waiting[own.free] = inf
    if y <= own.last:
        y = nextafter(own.last, inf)
    if not isnan(y):
        own.last = y
    return y
