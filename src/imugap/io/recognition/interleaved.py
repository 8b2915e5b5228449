"""Rows of several devices that alternate in one table, which no column says: found in the samples.

Where every n-th row is of one device, the means of the rows of each device differ by more than chance, or the samples
of a device in motion are nearer to its own before than to those of the other between them. Where the order of the rows
is any other, the samples of two devices at rest lie in two groups, the same rows on several axes.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, stdtr

MOST = 8
"""Most devices."""
BLOCK, SHORT_BLOCK, FEWEST_BLOCKS = 64, 16, 8
"""Rows of a device in a block of long logs, and of those that show the order of rows, and fewest blocks."""
IMPROBABLE = 1e-9
"""Probability of the difference of the means by chance below which they are of several devices."""
EXPLAINED = 0.9
"""Share of the largest difference between rows from which fewer devices explain it."""
ONE_LINE = 0.99
"""Share of the power of a pattern in one harmonic above which it is a vibration."""
NEARER = 4.0
"""Ratio of the changes from row to row to those from a device's row to its next, from which there are several."""
FAR = 8
"""Rows over which a device moves little, and a vibration near a fraction of the rate loses its phase."""
ORDINALS = {2: "second", 3: "third", 4: "fourth", 5: "fifth", 6: "sixth", 7: "seventh", 8: "eighth"}
WINDOW = 64
"""Rows over which these changes are compared."""
MOVING, USUAL = 0.25, 0.8
"""Share of the windows, those of a motion, in which these changes have to differ, and of the axes on which; and share
of the windows in which there are two groups."""
APART = 6.0
"""Distance of two groups of samples over the scatter within them from which they are two; that of a uniform
distribution, halved, is 3.5."""
TAIL = 0.1
"""Smallest share of a group."""
RESTLESS = 0.2
"""Share of the rows of a window that are of another device than the row before."""
SETTLED = 0.5
"""Relative scatter of the difference of devices over the blocks, above which it shows no order of the rows."""
SMOOTHED = 5
"""Blocks over which the order of the rows is taken."""


@dataclass(frozen=True)
class Interleaved:
    """Devices whose rows alternate: their number, None where it is not every n-th row; and what shows it."""

    devices: int | None
    evidence: str


def interleaved(values: np.ndarray, stamps: np.ndarray | None = None) -> Interleaved | None:
    """Return the devices whose rows alternate, None where there is one.

    Parameters
    ----------
    values
        Samples, shape (n, axes), in any unit.
    stamps
        Stamps of the rows, shape (n,), in any unit; None where there are none.
    """
    values = values[:, np.isfinite(values).all(axis=0)]
    if not values.size or len(values) < 2 * FEWEST_BLOCKS * 2:
        return None
    devices = max(2, 1 if stamps is None else _in_packets(stamps))
    return _by_level(values) or _by_motion(values, devices) or _by_groups(values)


def order_changes(values: np.ndarray, devices: int) -> int | None:
    """Return a row near which devices at rest begin to alternate in another order; None where they never do.

    ``values``: samples of all rows, shape (n, axes).
    """
    means = _block_means(values[:, np.isfinite(values).all(axis=0)], devices, SHORT_BLOCK)
    if len(means) < FEWEST_BLOCKS or not means.size:
        return None
    patterns = (means - means.mean(axis=1, keepdims=True)).reshape(len(means), -1)
    patterns /= np.maximum(np.abs(np.diff(patterns, axis=0)).mean(axis=0), np.finfo(float).tiny)
    main = np.linalg.svd(patterns, full_matrices=False)[2][0]
    along = patterns @ main
    size = np.abs(along)
    if size.std() > SETTLED * size.mean():
        return None
    smoothed = np.median(np.lib.stride_tricks.sliding_window_view(along, SMOOTHED), axis=1)
    changed = np.flatnonzero(np.sign(smoothed) != np.sign(smoothed[0]))
    return int(changed[0] + SMOOTHED // 2) * SHORT_BLOCK * devices if len(changed) else None


def _by_level(values: np.ndarray) -> Interleaved | None:
    """Return the fewest devices whose means differ by more than chance, and explain the difference."""
    sizes = {devices: size for devices in range(2, MOST + 1) if (size := _difference(values, devices)) > 0}
    if not sizes:
        return None
    largest = max(sizes.values())
    devices = min(devices for devices, size in sizes.items() if size >= EXPLAINED * largest)
    return Interleaved(devices, f"samples that alternate between {devices} levels")


def _difference(values: np.ndarray, devices: int) -> float:
    """Return the variance that the devices explain, in that of the steps; zero where chance may."""
    size = min(BLOCK, len(values) // (devices * FEWEST_BLOCKS))
    if size < 1:
        return 0.0
    values = values / np.maximum(np.abs(values).max(axis=0), np.finfo(float).tiny)  # squares of any size
    means = _block_means(values, devices, size)
    patterns = means - means.mean(axis=1, keepdims=True)
    mean, error = patterns.mean(axis=0), patterns.std(axis=0, ddof=1) / np.sqrt(len(patterns))
    known = error > 0
    chances = 2 * stdtr(len(patterns) - 1, -np.abs(mean[known]) / error[known])
    if not known.any() or chances.min() * chances.size * MOST > IMPROBABLE:
        return 0.0
    scale = np.mean(np.diff(values, axis=0) ** 2, axis=0)
    mean, error = (one[:, scale > 0] / np.sqrt(scale[scale > 0]) for one in (mean, error))
    return 0.0 if _is_vibration(mean, error) else float(np.sum(mean**2 - error**2) / devices)


def _is_vibration(pattern: np.ndarray, error: np.ndarray) -> bool:
    """Return whether a pattern that has several harmonics has the power of one, which no devices do.

    What is left of the power is small, or may be chance with the standard errors of the pattern; shape (rows, axes).
    """
    power = np.sum(np.abs(np.fft.rfft(pattern, axis=0)[1:]) ** 2, axis=1)
    if len(power) < 2:
        return False
    left, freedom = power.sum() - power.max(), pattern.shape[1] * (len(pattern) - 3)
    chance = chdtri(freedom, IMPROBABLE) * np.mean(error**2) * len(pattern)
    return bool(left < (1 - ONE_LINE) * power.sum() + chance)


def _block_means(values: np.ndarray, devices: int, size: int) -> np.ndarray:
    """Return the means of the rows of each device over blocks, shape (blocks, devices, axes)."""
    blocks = len(values) // (devices * size)
    return values[: blocks * devices * size].reshape(blocks, size, devices, -1).mean(axis=1)


def _by_motion(values: np.ndarray, devices: int) -> Interleaved | None:
    """Return devices where samples in motion are far nearer to those of their own device than to the rows between."""
    last = -(-FAR // devices) * devices
    windows = (len(values) - last) // WINDOW
    if windows < FEWEST_BLOCKS:
        return None
    others = np.min([_change(values, lag, windows) for lag in range(1, devices)], axis=0)
    own = np.max([_change(values, lag, windows) for lag in range(devices, last + 1, devices)], axis=0)
    if np.mean(np.mean(others > NEARER * own, axis=0) > MOVING) <= USUAL:
        return None
    return Interleaved(devices, f"samples that are nearer to every {ORDINALS[devices]} one than to those between")


def _change(values: np.ndarray, lag: int, windows: int) -> np.ndarray:
    """Return the mean square change over rows, shape (windows, axes)."""
    changes = (values[lag:] - values[:-lag])[: windows * WINDOW]
    return (changes**2).reshape(windows, WINDOW, -1).mean(axis=1)


def _in_packets(stamps: np.ndarray) -> int:
    """Return how many rows of stamps, shape (n,), follow each other at once, again and again; 1 where none do."""
    steps = np.diff(stamps.astype(float))
    for devices in range(2, MOST + 1):
        of_row = steps[: len(steps) // devices * devices].reshape(-1, devices)
        usual = np.sort(np.median(of_row, axis=0)) if len(of_row) else np.zeros(devices)
        if usual[-1] > NEARER * max(usual[-2], 0.0):
            return devices
    return 1


def _by_groups(values: np.ndarray) -> Interleaved | None:
    """Return devices in no order where the samples of most windows lie in two groups, of the same rows on two axes."""
    windows = len(values) // WINDOW
    if windows < FEWEST_BLOCKS:
        return None
    parts = values[: windows * WINDOW].reshape(windows, WINDOW, -1)
    ordered = np.sort(parts, axis=1)
    tail = int(TAIL * WINDOW)
    at = tail + np.argmax(np.diff(ordered[:, tail:-tail], axis=1), axis=1)[:, None]
    edge = (np.take_along_axis(ordered, at, axis=1) + np.take_along_axis(ordered, at + 1, axis=1)) / 2
    upper = parts > edge
    split = _separation(parts, upper) > APART
    group = upper == upper[:, :1]  # that of the first row, on each axis
    changes = np.mean(upper[:, 1:] != upper[:, :-1], axis=1) > RESTLESS
    shared = np.zeros(windows, bool)
    for one in range(parts.shape[2]):
        alike = (group == group[:, :, one : one + 1]).all(axis=1) & split & split[:, one : one + 1]
        shared |= (alike.sum(axis=1) > 1) & changes[:, one]
    return Interleaved(None, "samples in two groups, in no order of the rows") if shared.mean() > USUAL else None


def _separation(parts: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the distance of the means of two groups over the scatter within, shape (windows, axes)."""
    count = upper.sum(axis=1)
    high = (parts * upper).sum(axis=1) / np.maximum(count, 1)
    low = (parts * ~upper).sum(axis=1) / np.maximum(WINDOW - count, 1)
    within = parts - np.where(upper, high[:, None], low[:, None])
    scatter = np.sqrt(np.mean(within**2, axis=1))
    return (high - low) / np.where(scatter > 0, scatter, np.inf)
