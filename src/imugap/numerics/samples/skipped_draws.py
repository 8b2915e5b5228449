"""Random generators ahead of another one, for draws that come part by part."""

from collections.abc import Callable
from copy import deepcopy

import numpy as np

MOST = 1_000_000
"""Largest number of values that are drawn at once."""


def skipped(
    rng: np.random.Generator, draw: Callable[[np.random.Generator, int], object], count: int
) -> np.random.Generator:
    """Return a copy of a generator as it is after ``draw(rng, count)``, in bounded memory."""
    later = deepcopy(rng)
    for first in range(0, count, MOST):
        draw(later, min(MOST, count - first))
    return later
