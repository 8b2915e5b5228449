"""Protocol of the residual of a fit, from which an effect proposes itself as the missing one."""

from collections.abc import Callable
from typing import Any, Protocol, Self, TypeVar

import numpy as np

from imugap.effects.conditions import Conditions

Made = TypeVar("Made")


class Process(Protocol):
    """A random process."""

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz], aliases included, of its samples, at ``frequency`` [Hz]."""


class Samples(Protocol):
    """The samples of one axis."""

    @property
    def conditions(self) -> Conditions:
        """Conditions of the samples."""


class StepGains(Protocol):
    """Matched filters of a step of the mean at each sample."""

    @property
    def gains(self) -> np.ndarray:
        """Gain of log-likelihood of a step at each sample, shape (n,)."""

    def places(self, gain: float) -> float:
        """Return the number of independent places among which a step of that gain is the highest."""


class Residual(Protocol):
    """Residual of a fit to the n samples of one axis.

    Cosine coefficients are those of the type-II transform, k = 1..n-1, over their standard deviations.
    """

    @property
    def sequence(self) -> Samples:
        """Samples that were fitted."""

    @property
    def description(self) -> Any:
        """Description that was fitted."""

    @property
    def residual(self) -> np.ndarray:
        """Samples less the fitted mean, of equal variance over time [unit of the axis], shape (n,)."""

    @property
    def unrounded(self) -> np.ndarray:
        """Whitened residual, before the rounding where that is coarse, shape (n,)."""

    @property
    def coefficients(self) -> np.ndarray:
        """Cosine coefficients of the residual, shape (n - 1,)."""

    @property
    def lines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Frequencies [Hz], gain of log-likelihood of a sinusoid at each, and the level of the power around it."""

    @property
    def ripples(self) -> tuple[np.ndarray, np.ndarray]:
        """Size and gain of log-likelihood of an echo, to second order, by its delay of 1, 2, ... samples."""

    @property
    def steps(self) -> StepGains:
        """Matched filters of a step of the mean."""

    @property
    def stretch(self) -> tuple[float, int, int]:
        """Gain, first sample and last sample + 1 of the stretch whose variance differs most."""

    @property
    def swing(self) -> tuple[float, float, float, float]:
        """Frequency [Hz], depth, phase [rad] and gain of the most likely periodic change of the variance."""

    @property
    def top(self) -> float:
        """Excess of the power in the upper fifth of the used frequencies, in standard deviations."""

    def once(self, make: Callable[[Self], Made]) -> Made:
        """Return ``make(self)``, computed at the first call: a search asks one residual time and again."""

    def has(self, kind: type) -> bool:
        """Return whether the description has an effect of a kind."""

    def whiten(self, columns: np.ndarray) -> np.ndarray:
        """Return the cosine coefficients of columns of the error, shape (n, m), as shape (n - 1, m)."""

    def beyond(self, columns: np.ndarray) -> np.ndarray:
        """Return whitened columns less their projection on the fitted terms, shape (n - 1, m)."""

    def gains(self, columns: np.ndarray) -> np.ndarray:
        """Return the gain of log-likelihood of each whitened column alone, shape (m,)."""

    def joint_gain(self, columns: np.ndarray) -> tuple[float, int]:
        """Return the gain of log-likelihood of whitened columns together, and their rank beyond the terms."""

    def room(self, effect: Process) -> float:
        """Return the factor of an effect's amplitude at which the spectrum has most room for it."""

    def gain_of(self, effect: Process) -> float:
        """Return the gain of log-likelihood, to second order, of adding an effect of the given size."""
