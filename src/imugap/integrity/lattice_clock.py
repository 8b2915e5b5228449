"""Even clock with lost samples: the steps of its stamps are multiples of its interval.

The phase of the clock is tracked over blocks of rows, so that the count is right also for a slightly wrong interval or
a wandering clock.
"""

import numpy as np
from scipy.optimize import isotonic_regression

LOWEST = 0.05
"""Quantile of the steps that is about one interval."""
RANGE = (0.6, 1.5)
"""Range of the interval, relative to that quantile."""
TRIALS = 4001
"""Trial values of the interval, evenly spaced on a log axis."""
REACH = 8.0
"""Steps up to so many of the lowest quantile are compared: larger ones ask for too fine an interval."""
MOST = 4000
"""Largest number of steps that are compared."""
COHERENT = 0.4
"""Length of the mean vector of the phases of the steps, below which they are no multiples."""
EQUAL = 0.97
"""Share of the largest coherence from which the larger interval counts: its fractions are as coherent."""
COARSE = 0.2
"""Rounding of the stamps, in intervals, above which the phases of stamps are compared in place of those of steps."""
SHARED = 0.02
"""Largest share of steps that are no interval at all."""
BLOCK = 128
"""Rows over which the phase of the clock is averaged."""
BLOCKS = 40
"""Number of blocks from which the interval is estimated."""
DETUNED = 5e-4 * np.arange(-40, 41)
"""Trial values of the relative error of the interval."""
DOUBTFUL = 0.2
"""Distance from a sample [intervals] above which the first or last stamp may belong to its neighbour."""
FEWEST = 32
"""Fewest steps."""


def lattice_interval(time: np.ndarray, rounding: float) -> float | None:
    """Return the largest interval [s] that divides all steps of increasing stamps, shape (n,).

    The phases of the steps, 2 pi step/interval, are then near zero. None if those of no interval are, or if two rows
    lie in one interval. ``rounding`` [s] is that of the stamps.
    """
    steps = np.diff(time)
    if len(steps) < FEWEST:
        return None
    low = max(float(np.quantile(steps, LOWEST)), rounding)
    near = steps[steps < REACH * low]
    near = near[:: max(len(near) // MOST, 1)]
    trials = low * np.geomspace(*RANGE, TRIALS)
    if rounding < COARSE * low:
        coherence = np.array([np.cos(2 * np.pi * near / trial).mean() for trial in trials])
    else:
        coherence = _block_coherence(time, trials)
    best = int(np.flatnonzero(coherence > EQUAL * coherence.max())[-1])
    if coherence[best] < COHERENT:
        return None
    interval = float(trials[best])
    multiples = np.rint(near / interval)
    if np.mean(multiples == 0) > SHARED:
        return None
    return float(near @ multiples / (multiples @ multiples))


def lattice_slots(time: np.ndarray, interval: float) -> np.ndarray:
    """Return the index of the sample at each increasing stamp, shape (n,), from 0, for a nearly right interval [s]."""
    interval = _tuned(time, interval)
    cycles = (time - time[0]) / interval
    edges = np.arange(0, max(len(time) - BLOCK // 2, 1), BLOCK)
    real, imaginary = (np.add.reduceat(part(2 * np.pi * cycles), edges) for part in (np.cos, np.sin))
    turns = real + 1j * imaginary
    sizes = np.diff(np.r_[edges, len(time)])
    phase = np.unwrap(np.angle(turns) / (2 * np.pi), period=1.0)
    cycles -= np.interp(np.arange(len(time)), edges + (sizes - 1) / 2, phase)
    late = np.rint(cycles) - np.arange(len(time))
    for end, inner in ((0, late[:5]), (-1, late[-5:])):
        if abs(late[end] - np.median(inner)) == 1 and abs(cycles[end] - np.rint(cycles[end])) > DOUBTFUL:
            late[end] = np.median(inner)
    order = np.rint(isotonic_regression(late).x) + np.arange(len(time))
    return (order - order[0]).astype(int)


def _tuned(time: np.ndarray, interval: float) -> float:
    """Return the interval [s] near the given one that maximises the phase coherence of the stamps within blocks."""
    if len(time) < BLOCK:
        return interval
    return interval * (1 + float(DETUNED[np.argmax(_block_coherence(time, interval * (1 + DETUNED)))]))


def _block_coherence(time: np.ndarray, trials: np.ndarray) -> np.ndarray:
    """Return the mean length of the mean vector of the phases of stamps, shape (n,), in a block, by interval."""
    blocks = max(len(time) // BLOCK, 1)
    chosen = np.unique(np.linspace(0, blocks - 1, min(blocks, BLOCKS)).astype(int))
    parts = time[: blocks * BLOCK].reshape(blocks, -1)[chosen]
    parts = parts - parts[:, :1]
    return np.array([np.abs(np.exp(2j * np.pi / trial * parts).mean(axis=1)).mean() for trial in trials])
