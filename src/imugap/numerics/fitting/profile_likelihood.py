"""Limits of confidence intervals: where a profile deviance equals a quantile."""

from collections.abc import Callable

import numpy as np

TRIALS = 30
ACCURACY = 1e-3
"""Relative error of the square root of the deviance at a limit."""
SHORTEST_STEP = 0.05
LONGEST_STEP = 2.0
"""Limits of the steps of a log parameter outwards."""


def end(deviance: Callable[[float], float], target: float, first: float, limit: float = np.inf) -> float:
    """Return the distance at which ``deviance`` (0 at distance 0, increasing) equals ``target``; infinity if nowhere.

    Secant method on its square root, which is nearly linear in the log of a parameter.

    Parameters
    ----------
    first, limit
        First and largest trial distance.
    """
    goal = np.sqrt(target)
    inner, outer, distance = (0.0, 0.0), None, min(first, limit)
    for _ in range(TRIALS):
        root = np.sqrt(max(deviance(distance), 0.0))
        if abs(root - goal) < ACCURACY * goal:
            break
        if root > goal:
            outer = (distance, root)
        elif distance >= limit:
            return np.inf
        else:
            inner = (distance, root)
        distance = _next(inner, outer, goal, limit)
    return distance


def _next(inner: tuple[float, float], outer: tuple[float, float] | None, goal: float, limit: float) -> float:
    """Return the next trial distance: by linear interpolation between two points, else outwards, to the limit."""
    if outer is not None:
        share = (goal - inner[1]) / (outer[1] - inner[1])
        return inner[0] + float(np.clip(share, 0.05, 0.95)) * (outer[0] - inner[0])
    ahead = inner[0] * (goal / max(inner[1], 1e-3) - 1)
    return min(inner[0] + float(np.clip(1.1 * ahead, SHORTEST_STEP, LONGEST_STEP)), limit)
