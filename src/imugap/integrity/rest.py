"""Rest and motion of a device from its own samples: when it was moved, and where gravity points."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.ndimage import median_filter

from imugap.log import ACCEL, GYRO
from imugap.numerics.samples.runs import runs_of
from imugap.units import STANDARD_GRAVITY

WINDOW_S = 1.0
"""Length of a window [s]."""
AROUND = 121
"""Windows over which the level of a device at rest is taken; slower changes are drift."""
MOVED = {GYRO: 0.02, ACCEL: 0.15}
"""Change of the mean of a window from the level around it that no device at rest has [rad/s, m/s^2]."""
SCATTER = 5.0
"""Change of the mean of a window in standard deviations of such means, above which it counts."""
SHAKEN = 4.0
"""Standard deviation within a window, over the usual one, of a device that is shaken."""
BRIEF_S = 2.0
"""Length up to which a motion is a knock [s]."""
NEXT_S = 5.0
"""Time between motions that are one [s]."""
MOSTLY = 0.5
"""Share of the time in motion above which a log is one of a device in motion."""
GRAVITY_LEAST = 0.2
"""Norm of the specific force, in gravity, below which gravity is not in it."""
ALIGNED = 0.9
"""Cosine of the largest angle of an axis from the vertical at which it is named."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a device: ``moving`` and ``known`` of each window, shape (m,), and the ``begin`` of the windows [s].

    A window without a sample is not known, and neither rest nor motion.
    """

    moving: np.ndarray
    known: np.ndarray
    begin: np.ndarray

    @property
    def share(self) -> float:
        """Return the share of the known time in motion."""
        return float(np.mean(self.moving[self.known])) if self.known.any() else 0.0

    @property
    def at_rest(self) -> bool:
        """Return whether the device is never moved."""
        return not self.moving.any()

    @property
    def mostly(self) -> bool:
        """Return whether the log is one of a device in motion."""
        return self.share > MOSTLY

    @cached_property
    def stretches(self) -> list[tuple[float, float]]:
        """Return begin and end of each motion [s]."""
        return _stretches(self.moving, self.begin)

    @property
    def longest_rest(self) -> tuple[float, float]:
        """Return begin and end of the longest known time without motion [s]; equal if there is none."""
        rests = _stretches(~self.moving & self.known, self.begin)
        return max(rests, key=lambda one: one[1] - one[0], default=(0.0, 0.0))


def motion(log: pd.DataFrame, interval: float) -> Motion:
    """Return when the device of a log on an even clock, NaN where lost, was moved.

    The means over a second of a device at rest change slowly, and less than a fast walk or a turn of a degree does;
    the noise within a second has its usual size. A knock of up to :data:`BRIEF_S` is no motion.
    """
    width = max(round(WINDOW_S / interval), 1)
    count = len(log) // width
    moving, some = np.zeros(count, bool), np.zeros(count, bool)
    if count < 2:
        return Motion(moving, some, np.zeros(count))
    for triad, moved in MOVED.items():
        for name in (name for name in triad if name in log):
            values = log[name].to_numpy(float)[: count * width].reshape(count, width)
            present = np.isfinite(values)
            number = np.maximum(present.sum(axis=1), 1)
            means = np.where(present, values, 0.0).sum(axis=1) / number
            known = present.any(axis=1)
            some |= known
            if np.count_nonzero(known) < 2:
                continue
            means = np.interp(np.arange(count), np.flatnonzero(known), means[known])
            spread = np.sqrt(np.where(present, (values - means[:, None]) ** 2, 0.0).sum(axis=1) / number)
            usual = float(np.median(spread[known]))
            away = np.abs(means - median_filter(means, min(AROUND, count), mode="nearest"))
            limit = max(moved, SCATTER * usual / np.sqrt(width)) if usual < moved * np.sqrt(width) else moved
            moving |= known & ((away > limit) | ((spread > SHAKEN * usual) & (spread > moved)))
    moving = _without_brief(moving)
    return Motion(moving, some, float(log.index[0]) + width * interval * np.arange(count + 1)[:-1])


def departure(log: pd.DataFrame) -> float:
    """Return when a device that mostly rests is first moved [s]; infinity if it never is.

    The mean of a window then leaves the median of all of them, by a change that no device at rest has.
    """
    seconds = np.floor((log.index.to_numpy() - log.index[0]) / WINDOW_S)
    windows = log[[*GYRO, *ACCEL]].groupby(seconds)
    means, scatter = windows.mean(), windows.std().median() / np.sqrt(windows.size().median())
    away = (means - means.median()).abs()
    moved = pd.Series({name: limit for triad, limit in MOVED.items() for name in triad})
    moving = (away > np.maximum(moved, SCATTER * scatter)).any(axis=1)
    return float(log.index[0] + WINDOW_S * moving.idxmax()) if moving.any() else np.inf


def vertical(log: pd.DataFrame) -> tuple[str, float] | None:
    """Return the axis along which gravity points, with its sign, as ``-z``, and the angle from it [rad].

    The specific force at rest is opposite to gravity: a device with z down reads a negative z. None without three
    accelerometers, and without gravity in them.
    """
    if not set(ACCEL) <= set(log.columns):
        return None
    mean = np.nanmedian(log[list(ACCEL)].to_numpy(float), axis=0)
    norm = float(np.linalg.norm(mean))
    if not norm >= GRAVITY_LEAST * STANDARD_GRAVITY:
        return None
    at = int(np.argmax(np.abs(mean)))
    return f"{'-' if mean[at] > 0 else '+'}{'xyz'[at]}", float(np.arccos(min(abs(mean[at]) / norm, 1.0)))


def _without_brief(moving: np.ndarray) -> np.ndarray:
    """Return the mask with near motions joined and brief ones left out, shape (m,)."""
    result = moving.copy()
    rows = np.flatnonzero(moving)
    for first, last in pairwise(rows):
        if (last - first) * WINDOW_S <= NEXT_S:
            result[first:last] = True
    for first, stop in runs_of(result):
        if (stop - first) * WINDOW_S <= BRIEF_S:
            result[first:stop] = False
    return result


def _stretches(mask: np.ndarray, begin: np.ndarray) -> list[tuple[float, float]]:
    step = float(begin[1] - begin[0]) if len(begin) > 1 else WINDOW_S
    return [(float(begin[first]), float(begin[end - 1]) + step) for first, end in runs_of(mask)]
