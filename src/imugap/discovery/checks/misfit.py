"""Misfit of a named effect: the reason for withholding its name, and the level of the tests."""

from dataclasses import dataclass

import numpy as np

MAX_LOG_P = np.log(3e-3)
"""Maximum log p-value for withholding a name."""


@dataclass(frozen=True)
class Misfit:
    """Reason for withholding a name, and the log p-value of the test."""

    reason: str
    log_p: float


def log_p_against(named: float, alternative: float, log_alpha: float) -> float:
    """Compare the log p-values of a named effect and of an alternative.

    Returns :data:`MAX_LOG_P` where both are equal, less where the alternative has the smaller p-value, and 0 where the
    alternative is not significant at ``log_alpha``.
    """
    return MAX_LOG_P + alternative - named if alternative < log_alpha else 0.0


def divergence(power: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the log-likelihood gain of a free variance in each band, from relative power and degrees of freedom."""
    ratio = power / number
    return 0.5 * number * (ratio - 1 - np.log(ratio))
