"""First-order Gauss-Markov process."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.signal import lfilter

from imugap.effects.effect import TINY, Conditions, StochasticEffect, parameter
from imugap.statespace import StateSpace

FLAT_TOP = 1.89
"""Averaging time, in correlation times, at which the Allan deviation is largest (Farrell et al. 2022, eq. 37)."""


@dataclass(frozen=True)
class GaussMarkov(StochasticEffect):
    """Exponentially correlated process zdot = -z/T + w, with w of PSD S_B = 2 std^2/T (Farrell et al. 2022, eq. 33)."""

    name: ClassVar[str] = "gauss_markov"
    std: float = parameter("{u}", "stationary standard deviation")
    correlation_time: float = parameter("s", "T", low=TINY)

    @property
    def driving_psd(self) -> float:
        """Return S_B, the two-sided PSD of the driving noise [unit^2/s^2/Hz]."""
        return 2 * self.std**2 / self.correlation_time

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the exactly discretised process from its stationary distribution."""
        decay = np.exp(-conditions.interval / self.correlation_time)
        noise = self.std * rng.standard_normal(len(conditions))
        noise[1:] *= np.sqrt(-np.expm1(-2 * conditions.interval / self.correlation_time))
        return lfilter([1.0], [1.0, -decay], noise)

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return S_B/(w^2 + 1/T^2) (Farrell et al. 2022, eq. 35)."""
        return self.driving_psd / ((2 * np.pi * np.asarray(frequency, float)) ** 2 + self.correlation_time**-2)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return S_B T^2/tau (1 - T/(2 tau) (3 - 4 exp(-tau/T) + exp(-2 tau/T))) (Farrell et al. 2022, eq. 36).

        For tau << T the closed form cancels; its series in x = tau/T takes over:
        2 std^2 (x/3 - x^2/4 + 7 x^3/60 - x^4/24).
        """
        x = np.asarray(tau, float) / self.correlation_time
        series = x / 3 - x**2 / 4 + 7 * x**3 / 60 - x**4 / 24
        large = np.maximum(x, 1e-2)
        closed = (1 - (3 - 4 * np.exp(-large) + np.exp(-2 * large)) / (2 * large)) / large
        return 2 * self.std**2 * np.where(x < 1e-2, series, closed)

    def state_space(self) -> StateSpace:
        """Return one decaying state that starts stationary."""
        return StateSpace.first_order(1 / self.correlation_time, self.driving_psd, self.std**2)
