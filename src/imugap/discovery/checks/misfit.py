"""A doubt: why a name is withheld, and the level from which it is."""

from dataclasses import dataclass

import numpy as np

LEVEL = np.log(3e-3)
"""Log-probability of chance below which a name is in doubt."""


@dataclass(frozen=True)
class Misfit:
    """Why a name is withheld, and the log-probability that chance makes as much of it."""

    reason: str
    log_p: float


def log_p_against(named: float, other: float, log_alpha: float) -> float:
    """Return the log-probability of a doubt that is at the level where something else does as well as what is named."""
    return LEVEL + other - named if other < log_alpha else 0.0


def divergence(power: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Return the gain of log-likelihood of a free variance in each band."""
    ratio = power / number
    return 0.5 * number * (ratio - 1 - np.log(ratio))
