"""Damped steps towards an optimum (Levenberg 1944; Marquardt 1963, doi:10.1137/0111030)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

Point = TypeVar("Point")


@dataclass(frozen=True)
class Damping:
    """Damping of the information matrix: reduced after a step that improves, increased after one that does not.

    Attributes
    ----------
    first
        Initial value.
    least, most
        Lower limit after an improvement, upper limit.
    floor
        Lower limit after a step that does not improve.
    down, up
        Factors of reduction and increase.
    """

    first: float
    floor: float
    least: float = 0.0
    most: float = np.inf
    down: float = 10.0
    up: float = 10.0

    def after(self, value: float, improved: bool) -> float:
        """Return the damping after a step with damping ``value``."""
        return max(value / self.down, self.least) if improved else min(max(value * self.up, self.floor), self.most)


def optimise(
    start: Point,
    propose: Callable[[list[Point], float], Point | None],
    better: Callable[[Point, Point], bool],
    damping: Damping,
    iterations: int,
) -> tuple[list[Point], bool]:
    """Return the points of damped steps from ``start``, each better than the one before, and whether they converged.

    Parameters
    ----------
    propose
        Function of the points so far and the damping: the next trial point, or None where the steps have converged.
    better
        Function of two points: whether the first is better.
    iterations
        Largest number of trial points.
    """
    path, value = [start], damping.first
    for _ in range(iterations):
        trial = propose(path, value)
        if trial is None:
            return path, True
        improved = better(trial, path[-1])
        if improved:
            path.append(trial)
        value = damping.after(value, improved)
    return path, False
