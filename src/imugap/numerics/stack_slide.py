"""The highest straight track through the spectrogram of noise: a line whose frequency sweeps evenly.

White noise is cut into segments; in each the power at a frequency that moves evenly through the segment is an
exponential variable of mean 1. Its sum over the segments along a straight track is a gamma variable, so that the
probability of the highest sum of all tracks is known (a stack-slide search; Brady, Creighton 2000, Physical Review D
61, 082001).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.fft import fft
from scipy.special import gammaincc

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
    """Return the track of most power in ``whitened``, shape (n,), of unit variance; None of too few samples."""
    segments = _segments(len(whitened))
    length = len(whitened) // segments
    if length < 2 * WINDOW:
        return None
    widest = int(REACH * length)
    parts = whitened[: segments * length].reshape(segments, length).astype(np.float32)
    drift, first, power = max(_highest(parts, widest), key=lambda one: one[2])
    trials = 2.0 * widest * FINER * length * FINER / 2
    log_p = float(np.log(max(gammaincc(segments, power), TINY)) + np.log(trials))
    return Track(first / FINER / length, drift / FINER / length, log_p, segments)


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
    for sweep in range(inside.max() + 1):
        up, down = _powers(parts, STRIDE * sweep)
        found.append(_best(up / _level(up), drifts[inside == sweep]))
        if sweep:
            found.append(_best(down / _level(down), drifts[inside == -sweep]))
    return found


def _powers(parts: np.ndarray, sweep: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the power of a line that sweeps so many widths in each segment, at its middle, upwards and downwards.

    Each has shape (segments, steps). A sweep downwards is one upwards at the negative frequency.
    """
    length = parts.shape[1]
    time = (np.arange(length) - (length - 1) / 2) / length
    turned = parts * np.exp(-1j * np.pi * sweep * time**2).astype(np.complex64)
    lines = fft(turned, FINER * length, axis=1)
    powers = (lines.real**2 + lines.imag**2) / np.float32(length)
    steps = FINER * length // 2
    return powers[:, :steps], np.roll(powers[:, ::-1], 1, axis=1)[:, :steps]


def _level(powers: np.ndarray) -> np.ndarray:
    """Return the level of the power, at least 1, shape of the powers.

    That of each segment, that around each frequency, and that at frequencies where most segments have a line.
    """
    over_time = np.maximum(powers.mean(axis=1, keepdims=True), 1.0)
    along = np.ascontiguousarray(powers.T)
    count = len(along) // WINDOW
    around = np.repeat(_medians(along[: count * WINDOW].reshape(count, -1)), WINDOW)
    around = np.pad(around, (0, len(along) - len(around)), mode="edge")
    steady = _medians(along)
    medians = np.maximum(around, np.where(steady > STEADY, steady, 0.0))
    return over_time * np.maximum(medians / np.float32(np.log(2)), 1.0)


def _medians(rows: np.ndarray) -> np.ndarray:
    """Return the median of each row; sorted whole, rows so short are several times faster than by their partition."""
    ordered, half = np.sort(rows, axis=1), rows.shape[1] // 2
    return (ordered[:, half] + ordered[:, -half - 1]) / 2


@njit(cache=True)
def _best(powers, drifts):
    """Return drift, first frequency and sum of the highest of straight tracks; both in steps."""
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
        i = int(np.argmax(sums))
        if sums[i] > best[2]:
            best = (int(drift), first + i, sums[i])
    return best
