"""Lines whose frequency sweeps: too thin at every frequency and at every time, but not along their own track.

The whitened residual is cut into segments; in each the power at a frequency that moves evenly through the segment is
an exponential variable of mean 1. Its sum over the segments along a straight track is a gamma variable, so that the
probability of the highest sum of all tracks is known (a stack-slide search; Brady, Creighton 2000, Physical Review D
61, 082001).
"""

import numpy as np
from numba import njit
from scipy.fft import fft
from scipy.special import gammaincc

from imugap.discovery.axis import AxisFit
from imugap.discovery.unsteady import Band
from imugap.effects.effect import TINY

SEGMENTS = 8
"""Least number of segments."""
REACH = 0.45
"""Largest sweep over the log, in sampling rates."""
FINER = 2
"""Frequencies per width of a line."""
STRIDE = 2
"""Sweep within a segment, in widths of a line, from one transform to the next."""
WORK = 1.35e9
"""Powers that are added up at most; a longer log is cut into more segments."""
SLOWEST = 3
"""Least sweep over the log, in widths of a line in a segment: what moves less is as good as steady."""
STEADY = 1.8
"""Median power over the segments above which a frequency has a steady line."""
WINDOW = 64
"""Frequencies over which the level is taken."""


def swept(found: AxisFit, log_alpha: float) -> tuple[Band, ...]:
    """Return the band of the line that sweeps through the residual of a fit, if chance does not explain it."""
    whitened, interval = found.whitened, found.sequence.conditions.interval
    segments = _segments(len(whitened))
    length = len(whitened) // segments
    if length < 2 * WINDOW:
        return ()
    widest = int(REACH * length)
    sums = _highest(whitened[: segments * length].reshape(segments, length), widest)
    drift, first, highest = max(sums, key=lambda one: one[2])
    trials = 2.0 * widest * FINER * length * FINER / 2
    log_p = float(np.log(max(gammaincc(segments, highest), TINY)) + np.log(trials))
    if log_p > log_alpha:
        return ()
    ends = np.sort([first / FINER, first / FINER + drift / FINER]) / (length * interval)
    return (Band(float(max(ends[0], 0.0)), float(ends[1]), log_p),)


def _segments(count: int) -> int:
    """Return the number of segments of a log: tracks, segments and frequencies together make the work."""
    work = 2 * REACH * FINER**2 / 2 * count**2
    return max(SEGMENTS, int(np.ceil(work / WORK)))


def _highest(parts: np.ndarray, widest: int) -> list[tuple[int, int, float]]:
    """Return drift over the log and first frequency, in steps, and sum of the highest track for each sweep.

    Parameters
    ----------
    parts
        Whitened samples, shape (segments, length).
    widest
        Largest drift over the log, in widths of a line.
    """
    segments = len(parts)
    drifts = np.arange(-widest * FINER, widest * FINER + 1)
    drifts = drifts[np.abs(drifts) >= SLOWEST * FINER]
    inside = np.rint(drifts / FINER / segments / STRIDE).astype(int)
    found = []
    for sweep in np.unique(inside):
        powers = _powers(parts, STRIDE * int(sweep))
        found.append(_best(powers / _level(powers), drifts[inside == sweep]))
    return found


def _powers(parts: np.ndarray, sweep: int) -> np.ndarray:
    """Return the power of a line that sweeps so many widths in each segment, at its middle, shape (segments, steps)."""
    length = parts.shape[1]
    time = (np.arange(length) - (length - 1) / 2) / length
    turned = parts * np.exp(-1j * np.pi * sweep * time**2)
    return np.abs(fft(turned, FINER * length, axis=1)[:, : FINER * length // 2]) ** 2 / length


def _level(powers: np.ndarray) -> np.ndarray:
    """Return the level of the power, at least 1, shape of the powers.

    That of each segment, that around each frequency, and that at frequencies where most segments have a line.
    """
    over_time = np.maximum(powers.mean(axis=1, keepdims=True), 1.0)
    count = powers.shape[1] // WINDOW
    blocks = powers[:, : count * WINDOW].reshape(len(powers), count, WINDOW)
    around = np.repeat(np.median(blocks, axis=(0, 2)), WINDOW)
    around = np.pad(around, (0, powers.shape[1] - len(around)), mode="edge")
    steady = np.median(powers, axis=0)
    medians = np.maximum(around, np.where(steady > STEADY, steady, 0.0))
    return over_time * np.maximum(medians / np.log(2), 1.0)


@njit(cache=True)
def _best(powers, drifts):
    """Return drift, first frequency and sum of the highest of straight tracks; both in steps."""
    segments, steps = powers.shape
    best = (0, 0, 0.0)
    shifts = np.empty(segments, np.int64)
    sums = np.empty(steps)
    for drift in drifts:
        for m in range(segments):
            shifts[m] = int(np.rint(drift * (m + 0.5) / segments))
        first, last = max(0, -shifts.min()), steps - max(0, shifts.max())
        if last <= first:
            continue
        sums[first:last] = 0.0
        for m in range(segments):
            for i in range(first, last):
                sums[i] += powers[m, i + shifts[m]]
        i = first + int(np.argmax(sums[first:last]))
        if sums[i] > best[2]:
            best = (int(drift), i, sums[i])
    return best
