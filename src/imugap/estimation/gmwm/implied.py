"""Implied GMWM parameters: the wavelet variances of a composition as a function of its parameters, and derivatives.

In indirect inference this is the binding function (Gourieroux, Monfort, Renault 1993, Journal of Applied Econometrics
8, S85-S118).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from imugap.effects import GaussMarkov
from imugap.effects.effect import AllanEffect
from imugap.estimation.likelihood import Composition
from imugap.estimation.variances import wavelet_variance

SHORTEST, LONGEST = 0.05, 100.0
"""Limits of the correlation time, in sampling intervals (white noise) and in the longest averaging time."""
STEP = 0.1
"""Step of the logarithm of a correlation time in the table of Gauss-Markov processes."""


@dataclass(frozen=True)
class Family:
    """Family of models of one composition, and the wavelet analysis of a log.

    Attributes
    ----------
    composition
        Processes; a ramp counts as a process with one density.
    interval, count, levels, width
        Sampling interval [s], number of samples, number of levels and width of the wavelet filter.
    """

    composition: Composition
    interval: float
    count: int
    levels: int
    width: int

    @property
    def limits(self) -> tuple[float, float]:
        """Return the logarithms of the shortest and the longest correlation time."""
        return float(np.log(SHORTEST * self.interval)), float(np.log(LONGEST * self.interval * 2.0**self.levels))

    @cached_property
    def densities(self) -> np.ndarray:
        """Return the wavelet variances of the one-density processes at unit density, shape (levels, densities)."""
        columns = [_column(kind(1.0), self.interval, self.levels, self.width) for kind in self.composition.densities]
        return np.array(columns).reshape(-1, self.levels).T

    def markov(self, times: np.ndarray) -> np.ndarray:
        """Return those of Gauss-Markov processes of unit std, shape (levels, len(times)); ``times`` are logarithms."""
        return np.exp(_table(self.levels, self.width)[0](times - np.log(self.interval))).T

    def slopes(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return :meth:`markov` with its first and second derivative in the logarithms of the times."""
        logs, first, second = (spline(times - np.log(self.interval)).T for spline in _table(self.levels, self.width))
        values = np.exp(logs)
        return values, values * first, values * (second + first**2)


def _column(effect: AllanEffect, interval: float, levels: int, width: int) -> np.ndarray:
    return wavelet_variance.implied(effect, interval, levels, width)


@lru_cache
def _table(levels: int, width: int) -> tuple[BSpline, BSpline, BSpline]:
    """Return the log wavelet variances of Gauss-Markov processes over log T in intervals, and two derivatives.

    A spline of degree 7 in steps of :data:`STEP` is exact to 1e-11, and ten times as fast.
    """
    first, last = np.log(SHORTEST), np.log(LONGEST * 2.0**levels)
    times = np.arange(first - 4 * STEP, last + 4 * STEP, STEP)
    rows = [_column(GaussMarkov(1.0, float(np.exp(time))), 1.0, levels, width) for time in times]
    spline = make_interp_spline(times, np.log(rows), k=7)
    return spline, spline.derivative(), spline.derivative(2)
