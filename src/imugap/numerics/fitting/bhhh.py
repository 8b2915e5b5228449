"""Maximise a likelihood by BHHH from the log-densities of the single values.

Their gradients (scores) give the gradient of the likelihood and, by their outer products, its information (Berndt,
Hall, Hall and Hausman 1974, Annals of Economic and Social Measurement 3, 653-665); a step that does not increase the
likelihood is damped (Marquardt 1963, doi:10.1137/0111030).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

STEP = 1e-4
"""Step of a difference quotient."""
LONGEST = 1.0
"""Largest change of a parameter in one step."""
ROUNDS = 100
"""Largest number of steps."""
SETTLED = 1e-4
"""Predicted gain of log-likelihood below which a maximum is reached."""
DAMPING, LESS, MOST = 1e-3, 8.0, 1e8
"""Initial damping, factor of its changes, and largest damping."""
FLAT = 1e-6
"""Information added to that of a parameter without effect."""


@dataclass(frozen=True, eq=False)
class Maximum:
    """Maximum that was reached.

    Attributes
    ----------
    theta
        Parameters, shape (p,).
    densities
        Logarithm of the density of each value, shape (n,).
    """

    theta: np.ndarray
    densities: np.ndarray

    @property
    def log_likelihood(self) -> float:
        """Return the log-likelihood."""
        return float(np.sum(self.densities))


def maximise(densities: Callable[[np.ndarray], np.ndarray], starts: Iterable[np.ndarray]) -> Maximum:
    """Return the highest of the local maxima from several starts.

    ``densities`` returns the logarithm of the density of each value, given those before, for parameters of shape (p,)
    that are of order one, or logarithms.
    """
    return max(
        (_local_maximum(densities, np.asarray(start, float)) for start in starts), key=lambda one: one.log_likelihood
    )


def _local_maximum(densities: Callable[[np.ndarray], np.ndarray], start: np.ndarray) -> Maximum:
    here, damping = Maximum(start, densities(start)), DAMPING
    for _ in range(ROUNDS):
        units = STEP * np.eye(len(start))
        scores = np.array([densities(here.theta + unit) - here.densities for unit in units]) / STEP
        if not np.isfinite(scores).all():
            return here
        information, slope = scores @ scores.T, scores.sum(axis=1)
        if slope @ np.linalg.lstsq(information, slope)[0] / 2 < SETTLED:
            return here
        there = here
        while not there.log_likelihood > here.log_likelihood and damping < MOST:
            damped = information + damping * np.diag(np.diag(information) + FLAT)
            step = np.linalg.lstsq(damped, slope)[0]
            there = _moved(densities, here, step)
            damping *= LESS
        if not there.log_likelihood > here.log_likelihood:
            return here
        here, damping = _extended(densities, there, step), damping / LESS**2
    return here


def _extended(densities: Callable[[np.ndarray], np.ndarray], here: Maximum, step: np.ndarray) -> Maximum:
    """Repeat with twice the step while the likelihood increases: far from the maximum BHHH steps are short."""
    further = _moved(densities, here, step)
    if not further.log_likelihood > here.log_likelihood + SETTLED:
        return here
    return _extended(densities, further, 2 * step)


def _moved(densities: Callable[[np.ndarray], np.ndarray], here: Maximum, step: np.ndarray) -> Maximum:
    theta = here.theta + np.clip(step, -LONGEST, LONGEST)
    return Maximum(theta, densities(theta))
