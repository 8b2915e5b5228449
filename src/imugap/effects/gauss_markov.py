"""First-order Gauss-Markov process."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.polynomial.polynomial import polyval
from scipy.special import factorial

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, Start, StochasticEffect, Transform, parameter
from imugap.effects.residual import Residual
from imugap.numerics.first_order import recurse
from imugap.numerics.state_space import StateSpace

FLAT_TOP = 1.89
"""Averaging time, in correlation times, at which the Allan deviation is largest (Farrell et al. 2022, eq. 37)."""
ORDER = np.arange(3, 21)
BRACKET = np.r_[0.0, (-1.0) ** ORDER * (4 - 2.0**ORDER) / factorial(ORDER)]
"""Taylor coefficients of (2 x - 3 + 4 exp(-x) - exp(-2 x))/x^2."""
SINH = np.r_[0.0, (ORDER % 2) / factorial(ORDER)]
"""Taylor coefficients of (sinh x - x)/x^2."""

MOST = 3
"""Largest number of processes on one axis in a search."""
TIMES, STARTS = 16, 2
"""Correlation times of the grid of a search, and those from which it starts."""
BESIDES = 2.0
"""Number of independent correlation times of a log, in addition to the parameter."""


@dataclass(frozen=True)
class GaussMarkov(StochasticEffect):
    """Exponentially correlated process zdot = -z/T + w, with w of PSD S_B = 2 std^2/T (Farrell et al. 2022, eq. 33)."""

    name: ClassVar[str] = "gauss_markov"
    title: ClassVar[str] = "Gauss-Markov"
    slow: ClassVar[bool] = True
    std: float = parameter("{u}", "stationary standard deviation")
    correlation_time: float = parameter("s", "T", low=TINY)

    @property
    def driving_psd(self) -> float:
        """Return S_B, the two-sided PSD of the driving noise [unit^2/s^2/Hz]."""
        return 2 * self.std**2 / self.correlation_time

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the exactly discretised process from its stationary distribution."""
        decay, share = self._discretised(conditions.interval)
        noise = self.std * rng.standard_normal(len(conditions))
        noise[1:] *= share
        return recurse(decay, noise)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds the process to one part after the other."""
        decay, share = self._discretised(run.interval)
        last = None

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal last
            noise = self.std * rng.standard_normal(len(sequence))
            noise[0 if last is not None else 1 :] *= share
            values = recurse(decay, noise, last or 0.0)
            last = values[-1]
            return sequence + values

        return transform

    def _discretised(self, interval: float) -> tuple[float, float]:
        """Return the decay over an interval [s], and the share of the standard deviation that is drawn anew."""
        x = interval / self.correlation_time
        return np.exp(-x), np.sqrt(-np.expm1(-2 * x))

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        x = interval / self.correlation_time
        drive = self.std * np.sqrt(-np.expm1(-2 * x))
        return Block(_step, {"std": self.std, "decay": np.exp(-x), "drive": drive, "level": 0.0}, _start)

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the correlation times, from a grid, with the largest expected gain."""
        if sum(type(effect) is cls for effect in fit.description.noise) >= MOST:
            return
        conditions = fit.sequence.conditions
        times = np.geomspace(conditions.interval, conditions.interval * len(conditions) / 2, TIMES)
        rooms = np.array([fit.room(cls(1.0, time)) for time in times])
        gains = [fit.gain_of(cls(room, time)) for room, time in zip(rooms, times, strict=True)]
        for index in np.argsort(gains)[: -STARTS - 1 : -1]:
            if rooms[index] > 0:
                start = cls(float(rooms[index]), float(times[index]))
                yield Start(start, ("std", "correlation_time"), trials=BESIDES, gain=gains[index])

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return S_B/(w^2 + 1/T^2) (Farrell et al. 2022, eq. 35)."""
        return self.driving_psd / ((2 * np.pi * np.asarray(frequency, float)) ** 2 + self.correlation_time**-2)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return S_B T^2/tau (1 - T/(2 tau) (3 - 4 exp(-tau/T) + exp(-2 tau/T))) (Farrell et al. 2022, eq. 36)."""
        return self.std**2 * _bracket(np.asarray(tau, float) / self.correlation_time)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return interval std^2 (1 - p^2)/|1 - p exp(-2 pi i f interval)|^2, p = exp(-interval/T)."""
        x = interval / self.correlation_time
        sine = np.sin(np.pi * np.asarray(frequency, float) * interval)
        return interval * self.std**2 * -np.expm1(-2 * x) / (np.expm1(-x) ** 2 + 4 * np.exp(-x) * sine**2)

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return std^2/(n (1 - p))^2 (n (1 - p^2) - p (3 - 4 p^n + p^(2n))), p = exp(-interval/T).

        It is the variance of the sum of n samples less the covariance of neighbouring sums, over n^2; with x =
        interval/T written (x/(1 - p))^2 (discretisation/n + p bracket(n x)), two positive terms that do not cancel.
        """
        x, n = interval / self.correlation_time, np.asarray(averaging, float)
        sampled = _discretisation(x) / n + np.exp(-x) * _bracket(n * x)
        return (self.std * x / np.expm1(-x)) ** 2 * sampled

    def state_space(self) -> StateSpace:
        """Return one decaying state that starts stationary."""
        return StateSpace.first_order(1 / self.correlation_time, self.driving_psd, self.std**2)


def _bracket(x: np.ndarray) -> np.ndarray:
    """Return (2 x - 3 + 4 exp(-x) - exp(-2 x))/x^2; below 1/2, where this cancels, its Taylor series."""
    large = np.maximum(x, 0.5)
    closed = (2 * large - 3 + 4 * np.exp(-large) - np.exp(-2 * large)) / large**2
    return np.where(x < 0.5, polyval(np.minimum(x, 0.5), BRACKET), closed)


def _discretisation(x: float) -> float:
    """Return (1 - exp(-2 x) - 2 x exp(-x))/x^2 = 2 exp(-x) (sinh x - x)/x^2; below 1/2 by the series of the latter."""
    if x < 0.5:
        return float(2 * np.exp(-x) * polyval(x, SINH))
    return float((-np.expm1(-2 * x) - 2 * x * np.exp(-x)) / x**2)


def _start(own, x, now):
    own.level = own.std * own.draw.normal()


def _step(own, x, now):
    y = x + own.level
    own.level = own.decay * own.level + own.drive * own.draw.normal()
    return y
