"""Consistency of the ends of walks with their covariance: means of squared errors over walks, shares in ellipses."""

import numpy as np

from imugap.numerics.fitting import block_bootstrap
from imugap.numerics.samples.chi_square import squared_radius

SQUARES = {"nees": ("NEES, position", 2), "heading_nees": ("NEES, heading", 1)}
"""Normalised squared errors of the end: title and degrees of freedom."""
ENDS = "", "_low", "_high"
"""Endings of the names of a mean and of its interval."""


def interval_columns(name: str) -> list[str]:
    """Return the names of the columns of a mean and of its interval."""
    return [name + end for end in ENDS]


def mean_row(name: str, values: np.ndarray, rng: np.random.Generator) -> dict[str, float]:
    """Return mean and 95 % bootstrap interval of independent values, shape (n,), by :func:`interval_columns`."""
    found = block_bootstrap.mean(values, rng, block=1)
    return dict(zip(interval_columns(name), (found.value, found.low, found.high), strict=True))


def in_ellipse(nees: np.ndarray, probability: float) -> np.ndarray:
    """Return whether each end, by its NEES of the horizontal position, is in the ellipse of this probability."""
    return nees < squared_radius(probability)
