"""Stretches of samples that begin at random and last a random number of samples: gaps, repeats."""

import numpy as np


def stretches(count: int, probability: float, length: float, rng: np.random.Generator) -> np.ndarray:
    """Return which of ``count`` samples lie in a stretch, shape (count,), bool.

    At each sample after one that is free a stretch begins with ``probability``; the number of its samples is geometric
    with mean ``length``. The first sample is free. The samples form a two-state Markov chain: far from the start the
    share of those in a stretch is p/(p + 1/length).

    Parameters
    ----------
    count
        Number of samples.
    probability
        Probability p that a stretch begins, in [0, 1].
    length
        Mean number of samples of a stretch, at least 1.
    rng
        Source of the random numbers.
    """
    inside = np.zeros(count, bool)
    if probability == 0:
        return inside
    cycles = int(np.ceil(2 * count / (1 / probability + length))) + 8
    start = 0
    while start < count:
        free = np.minimum(rng.geometric(probability, cycles), count)
        held = np.minimum(rng.geometric(1 / length, cycles), count)
        edges = start + np.cumsum(np.column_stack([free, held]).ravel())
        flips = edges[edges < count]
        inside[flips] = True
        start = int(edges[-1])
    return np.logical_xor.accumulate(inside)
