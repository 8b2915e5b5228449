"""Ends of confidence intervals: where the profile of a deviance has risen to its quantile."""

from collections.abc import Callable

import numpy as np

TRIALS = 30
ACCURACY = 1e-3
"""Relative error of the root of the deviance at an end."""
SHORTEST_STEP = 0.05
LONGEST_STEP = 2.0
"""Steps of a log parameter on the way outwards."""


def end(deviance: Callable[[float], float], target: float, first: float, limit: float = np.inf) -> float:
    """Return the distance at which ``deviance`` (0 at distance 0, rising) reaches ``target``; infinity if nowhere.

    Secants on its root, which is nearly linear in the log of a parameter.

    Parameters
    ----------
    first, limit
        Distance to try first, and the largest one to try.
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
    """Return the next distance to try: linear in the root between two points, else outwards, up to the limit."""
    if outer is not None:
        share = (goal - inner[1]) / (outer[1] - inner[1])
        return inner[0] + float(np.clip(share, 0.05, 0.95)) * (outer[0] - inner[0])
    ahead = inner[0] * (goal / max(inner[1], 1e-3) - 1)
    return min(inner[0] + float(np.clip(1.1 * ahead, SHORTEST_STEP, LONGEST_STEP)), limit)
