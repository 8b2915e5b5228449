"""Global envelope test of a curve: its largest deviation against those of replicates of the model.

The studentised maximum deviation (Myllymaki et al. 2017, J. R. Stat. Soc. B 79, 381-404), with a generalised Pareto
tail, so that few replicates suffice for small probabilities (Knijnenburg et al. 2009, Bioinformatics 25, i161-i168).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from imugap.discovery.views.curve import Curve

TAIL_SHARE = 0.25
"""Share of the replicates in the tail."""
MIN_RELATIVE_STD = 0.2
"""Minimum standard deviation of a location, over the median one."""
MAX_SEPARATION = 2
"""Maximum number of locations between two parts of one place."""


@dataclass(frozen=True, eq=False)
class Envelope:
    """Replicates of a curve under the model.

    Attributes
    ----------
    replicates
        Their statistics, shape (b, m).
    signed
        Whether the test is two-sided.
    """

    replicates: np.ndarray
    signed: bool

    @cached_property
    def _varied(self) -> np.ndarray:
        """Return the mask of the locations at which the replicates differ; in a window without samples they do not."""
        return np.ptp(self.replicates, axis=0) > 0

    @cached_property
    def mean(self) -> np.ndarray:
        """Return the mean of the replicates at each location."""
        return np.where(self._varied, self.replicates.mean(axis=0), self.replicates[0])

    @cached_property
    def spread(self) -> np.ndarray:
        """Return the standard deviation of the replicates at each location; for gains, the median of all locations."""
        return self._limited(self.replicates.var(axis=0, ddof=1))

    def _limited(self, variance: np.ndarray) -> np.ndarray:
        spread = np.sqrt(np.maximum(variance, 0.0))
        usual = np.median(spread[..., self._varied], axis=-1, keepdims=True) if self._varied.any() else 0.0
        return np.maximum(spread, MIN_RELATIVE_STD * usual) if self.signed else np.broadcast_to(usual, spread.shape)

    def _evidence(self, deviation: np.ndarray, degrees: int) -> np.ndarray:
        """Transform studentised deviations to a scale with an exponential tail.

        Those of gains have one already. A signed one is Student's t with d degrees of freedom; the tail of
        (d/2) log(1 + t^2/d) is exponential of scale 1.
        """
        return degrees / 2 * np.log1p(deviation**2 / degrees) if self.signed else deviation

    def deviation(self, statistic: np.ndarray) -> np.ndarray:
        """Return the deviation of a curve from the replicates at each location, on a scale with an exponential tail."""
        return self._evidence(_studentised(statistic - self.mean, self.spread), len(self.replicates) - 1)

    @cached_property
    def maxima(self) -> np.ndarray:
        """Return the largest deviation of each replicate from the others, in increasing order, shape (b,)."""
        b, x = len(self.replicates), self.replicates
        mean = (b * self.mean - x) / (b - 1)
        variance = (b * (x**2).mean(axis=0) - x**2 - (b - 1) * mean**2) / (b - 2)
        deviation = _studentised(np.where(self._varied, x - mean, 0.0), self._limited(variance))
        return np.sort(self._evidence(deviation, b - 2).max(axis=1))

    @cached_property
    def _tail(self) -> tuple[float, float, int]:
        """Return threshold and mean excess of the tail, and the number of replicates in it."""
        number = max(round(TAIL_SHARE * len(self.maxima)), 1)
        threshold = self.maxima[-number - 1]
        return float(threshold), float(np.mean(self.maxima[-number:] - threshold)), number

    def p_value(self, largest: float | np.ndarray) -> np.ndarray:
        """Return the probability, under the model, of as large a deviation anywhere.

        The excess over a threshold that k of b replicates exceed is exponential; with its scale estimated by their
        mean excess, the excess of a new curve has the generalised Pareto distribution of shape 1/k.
        """
        threshold, scale, number = self._tail
        b = len(self.maxima)
        rank = (1 + b - np.searchsorted(self.maxima, largest)) / (b + 1)
        excess = np.maximum(np.asarray(largest) - threshold, 0.0)
        with np.errstate(divide="ignore"):  # all replicates may be alike
            relative = np.divide(excess, number * scale, out=np.zeros(np.shape(excess)), where=excess > 0)
        tail = (number + 1) / (b + 1) * (1 + relative) ** -float(number)
        return np.where(np.asarray(largest) >= threshold, tail, rank)

    def critical(self, probability: float) -> float:
        """Return the deviation that a curve of the model reaches anywhere with this probability, or a smaller one."""
        threshold, scale, number = self._tail
        b = len(self.maxima)
        share = (number + 1) / (b + 1)
        if probability > share:
            return float(self.maxima[int(np.ceil((b + 1) * (1 - probability) - 1e-9))])
        return threshold + number * scale * ((probability / share) ** (-1 / number) - 1)

    def bounds(self, probability: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and the upper bound that a curve of the model crosses anywhere with this probability.

        Gains have no lower bound.
        """
        evidence, degrees = self.critical(probability), len(self.replicates) - 1
        if not self.signed:
            return np.full(self.mean.shape, -np.inf), self.mean + evidence * self.spread
        reach = np.sqrt(degrees * np.expm1(2 * evidence / degrees)) * self.spread
        return self.mean - reach, self.mean + reach

    def places(self, curve: Curve, level: float) -> list[tuple[float, float, float]]:
        """Return (low, high, p-value) of each range of locations beyond the envelope at a level."""
        deviation = self.deviation(curve.statistic)
        beyond = np.flatnonzero((deviation >= self.critical(level)) & (deviation > 0))
        groups = _runs(beyond, deviation, curve.point) if curve.windows is None else _apart(beyond, deviation, curve)
        return [
            (float(curve.low[group].min()), float(curve.high[group].max()), float(self.p_value(deviation[group].max())))
            for group in groups
        ]


def _runs(beyond: np.ndarray, deviation: np.ndarray, point: bool) -> list[np.ndarray]:
    """Return the locations beyond the envelope in runs of neighbours; for ``point``, the peak of each run only."""
    runs = np.split(beyond, np.flatnonzero(np.diff(beyond) > MAX_SEPARATION + 1) + 1) if len(beyond) else []
    return [run[[np.argmax(deviation[run])]] if point else run for run in runs]


def _apart(beyond: np.ndarray, deviation: np.ndarray, curve: Curve) -> list[np.ndarray]:
    """Return the windows of largest deviation that do not overlap, neighbouring ones in one group."""
    first, last = curve.windows
    taken = np.empty(0, int)
    for window in beyond[np.argsort(-deviation[beyond])]:
        if np.all((first[taken] >= last[window]) | (last[taken] <= first[window])):
            taken = np.append(taken, window)
    ordered = taken[np.argsort(first[taken])]
    between = first[ordered[1:]] - last[ordered[:-1]]
    return np.split(ordered, np.flatnonzero(between > MAX_SEPARATION) + 1) if len(ordered) else []


def _studentised(difference: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Return differences over their spread; 0 where there is no difference, at a location without spread too."""
    with np.errstate(divide="ignore"):
        return np.divide(difference, spread, out=np.zeros(np.shape(difference)), where=difference != 0)
