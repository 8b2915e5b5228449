"""Stack-slide search for a chirp: the straight track of highest power through a spectrogram.

White noise is cut into segments; in each the power at a frequency that moves evenly through the segment is an
exponential variable of mean 1. Its sum over the segments along a straight track is a gamma variable, so that the
probability of the highest sum of all tracks is known (a stack-slide search; Brady, Creighton 2000, Physical Review D
61, 082001).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numba import njit
from scipy.fft import fft, prev_fast_len
from scipy.special import gammaincc

MIN_SEGMENTS = 8
"""Minimum number of segments."""
MAX_DRIFT = 0.45
"""Maximum drift over the log [sampling rates]."""
OVERSAMPLING = 2
"""Frequencies per resolution width of a segment."""
STRIDE = 2
"""Increment of the sweep within a segment between transforms [resolution widths]."""
MAX_WORK = 1.35e9
"""Maximum number of added powers; a longer log has more segments."""
MIN_DRIFT = 3
"""Minimum drift over the log [resolution widths of a segment]; a line of less is steady."""
MAX_STEADY_POWER = 1.8
"""Maximum median power over the segments of a frequency without a steady line."""
WINDOW = 64
"""Number of frequencies for the median noise level."""
CACHED_SWEEPS = 256
"""Number of sweeps that are kept, for residuals of two lengths."""
TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Track:
    """A straight track through the spectrogram of n samples.

    Attributes
    ----------
    begin, drift
        Frequency at the first sample, and its change to the last one [cycles per sample].
    log_p
        Log-probability that the highest of all tracks of white noise has as much power.
    segments
        Segments over which the power is added; each resolves segments/n cycles per sample.
    """

    begin: float
    drift: float
    log_p: float
    segments: int

    @property
    def ends(self) -> tuple[float, float]:
        """Return the lowest and the highest frequency of the track [cycles per sample]."""
        low, high = sorted((self.begin, self.begin + self.drift))
        return max(low, 0.0), high


def highest_track(whitened: np.ndarray) -> Track | None:
    """Return the track of most power in ``whitened``, shape (n,), of unit variance; None of too few samples.

    The last samples, at most one in twenty, are left out where that makes the transforms much faster.
    """
    segments = _segment_count(len(whitened))
    length = prev_fast_len(max(len(whitened) // segments, 1))
    if length < 2 * WINDOW:
        return None
    max_drift = int(MAX_DRIFT * length)
    parts = whitened[: segments * length].reshape(segments, length).astype(np.float32)
    drift, first, power = max(_best_tracks(parts, max_drift), key=lambda one: one[2])
    trials = 2.0 * max_drift * OVERSAMPLING * length * OVERSAMPLING / 2
    log_p = float(np.log(max(gammaincc(segments, power), TINY)) + np.log(trials))
    whole = drift * len(whitened) / (segments * length)
    return Track(first / OVERSAMPLING / length, whole / OVERSAMPLING / length, log_p, segments)


def _segment_count(count: int) -> int:
    """Return the number of segments of ``count`` samples that keeps the number of added powers below the maximum."""
    work = 2 * MAX_DRIFT * OVERSAMPLING**2 / 2 * count**2
    return max(MIN_SEGMENTS, int(np.ceil(work / MAX_WORK)))


def _best_tracks(parts: np.ndarray, max_drift: int) -> list[tuple[int, int, float]]:
    """Return drift over the log and first frequency [steps], and power of the best track, for each sweep.

    Parameters
    ----------
    parts
        Whitened samples, shape (segments, length).
    widest
        Maximum drift over the log [resolution widths].
    """
    segments = len(parts)
    drifts = np.arange(-max_drift * OVERSAMPLING, max_drift * OVERSAMPLING + 1)
    drifts = drifts[np.abs(drifts) >= MIN_DRIFT * OVERSAMPLING]
    inside = np.rint(drifts / OVERSAMPLING / segments / STRIDE).astype(int)
    found = []
    for sweep in range(inside.max() + 1):
        up, down = _segment_powers(parts, STRIDE * sweep)
        found.append(_best_track(up / _level(up), drifts[inside == sweep]))
        if sweep:
            found.append(_best_track(down / _level(down), drifts[inside == -sweep]))
    return found


def _segment_powers(parts: np.ndarray, sweep: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the power over the mid-frequency of a chirp of a given sweep per segment, upward and downward.

    Each has shape (segments, steps). A downward sweep is an upward one at the negative frequency.
    """
    length = parts.shape[1]
    lines = fft(parts * _sweep(length, sweep), OVERSAMPLING * length, axis=1)
    powers = (lines.real**2 + lines.imag**2) / np.float32(length)
    steps = OVERSAMPLING * length // 2
    return powers[:, :steps], np.hstack([powers[:, :1], powers[:, :-steps:-1]])


@lru_cache(maxsize=CACHED_SWEEPS)
def _sweep(length: int, sweep: int) -> np.ndarray:
    """Return what a chirp of a sweep is multiplied by to be a line, shape (length,), read-only."""
    time = (np.arange(length) - (length - 1) / 2) / length
    turns = np.exp(-1j * np.pi * sweep * time**2).astype(np.complex64)
    turns.flags.writeable = False
    return turns


def _level(powers: np.ndarray) -> np.ndarray:
    """Return the noise level of the powers, at least 1, same shape.

    It combines the mean of each segment, the median around each frequency, and the median over time at steady lines.
    """
    segments, steps = powers.shape
    over_time, count = np.maximum(powers.mean(axis=1, keepdims=True), 1.0), steps // WINDOW
    independent = powers[:, : count * WINDOW : OVERSAMPLING].reshape(segments, count, -1).swapaxes(0, 1)
    around = _medians(independent.reshape(count, -1))[np.minimum(np.arange(steps) // WINDOW, count - 1)]
    steady = np.flatnonzero(np.count_nonzero(powers > MAX_STEADY_POWER, axis=0) >= segments // 2)
    middle = _medians(powers[:, steady].T)
    around[steady] = np.where(middle > MAX_STEADY_POWER, np.maximum(around[steady], middle), around[steady])
    return over_time * np.maximum(around / np.float32(np.log(2)), 1.0)


def _medians(rows: np.ndarray) -> np.ndarray:
    """Return the median of each row; for short rows a full sort is faster than a partition."""
    ordered, half = np.sort(rows, axis=1), rows.shape[1] // 2
    return (ordered[:, half] + ordered[:, -half - 1]) / 2


@njit(cache=True, fastmath={"nnan", "nsz"})
def _best_track(powers, drifts):
    """Return drift and first frequency [steps], and power, of the straight track of highest power."""
    segments, steps = powers.shape
    best = (0, 0, 0.0)
    shifts = np.empty(segments, np.int64)
    total = np.empty(steps, powers.dtype)
    for drift in drifts:
        for m in range(segments):
            shifts[m] = int(np.rint(drift * (m + 0.5) / segments))
        first, last = max(0, -shifts.min()), steps - max(0, shifts.max())
        if last <= first:
            continue
        sums = total[: last - first]
        sums[:] = 0.0
        for m in range(segments):
            row = powers[m, first + shifts[m] : last + shifts[m]]
            for i in range(len(sums)):
                sums[i] += row[i]
        highest = np.float32(0.0)
        for i in range(len(sums)):
            highest = max(highest, sums[i])
        if highest > best[2]:
            best = (int(drift), first + int(np.argmax(sums)), highest)
    return best
