"""Up to which frequency a reference follows the motion of a device.

Above it, the difference of log and reference is motion that the reference lacks (its filter, its rate, its noise), and
says nothing of the device. Log and reference are then compared as means over blocks of samples, in which most of it
averages out.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import ceil

import numpy as np
import pandas as pd
from scipy.fft import rfft
from scipy.stats import f as f_distribution
from scipy.stats import spearmanr

from imugap.log import ACCEL, GYRO, TIME, axes

BLOCK_S = 1.0
"""Length of the blocks, whose motion is compared [s]."""
MIN_SAMPLES, MIN_BLOCKS = 32, 20
"""Minimum number of samples of a block, and of blocks."""
MAX_P = 1e-6
"""Largest p-value of a dependence of the difference on the motion."""
MIN_CORRELATION = 0.5
"""Minimum rank correlation of motion and difference over the blocks."""
QUIET_SHARE, MIN_QUIET = 0.03, 2
"""Share of the blocks, and their minimum number, that are taken for the quietest."""
MIN_RISE = 3.0
"""Minimum median power of the difference, over its mean power in the quietest blocks."""
MIN_RATIO = 0.25
"""Minimum power of the difference, over that of the reference, for motion that the reference lacks."""
MAX_COHERENCE = 0.5
"""Maximum coherence of difference and reference; above it, the device answers the motion (scale, delay, filter)."""
MIN_NOISE = 0.5
"""Minimum power of the reference, over that of the difference, for noise of the reference where the log lacks it."""
MIN_AXES = 2
"""Minimum number of axes of a sensor that show it."""


@dataclass(frozen=True)
class ReferenceBand:
    """Band in which a reference follows the motion.

    Attributes
    ----------
    highest
        Its end [Hz].
    interval
        Sampling interval of the log [s].
    """

    highest: float
    interval: float

    @property
    def factor(self) -> int:
        """Return the number of samples of the means that are compared: the fewest without frequencies above it."""
        return max(ceil(1 / (2 * self.highest * self.interval)), 2)

    def sentence(self) -> str:
        """Return what this means for the comparison."""
        duration = self.factor * self.interval
        return (
            f"The reference does not follow the motion above {self.highest:.3g} Hz: what differs there is its own "
            f"noise or motion that it lacks. Log and reference are compared as means over {duration:.3g} s. These "
            "still hold a part of it, so that the noise is an upper bound of that of the device."
        )

    def means(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the means of an evenly sampled log over blocks of samples, at the mean of their times."""
        return self.moving_means(table).iloc[:: self.factor]

    def moving_means(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return the moving means of an evenly sampled log over the same number of samples, at the mean times."""
        time = pd.Series(table.index, index=table.index).rolling(self.factor).mean()
        moving = table.rolling(self.factor).mean().set_axis(pd.Index(time.to_numpy(), name=TIME))
        return moving.iloc[self.factor - 1 :]


def reference_band(measured: pd.DataFrame, ideal: pd.DataFrame, interval: float) -> ReferenceBand | None:
    """Return the band of a reference, or None where it follows the log at all frequencies.

    In each octave of frequency, the power of the difference in blocks of a second is compared with the motion in them:
    noise of the device does not depend on it, and what the device answers to it (a scale factor, a delay) is coherent
    with the reference. Noise of the reference is what the log does not show of it.

    Parameters
    ----------
    measured, ideal
        Log and reference at the same samples, which are even in time.
    interval
        Sampling interval [s].
    """
    length = max(round(BLOCK_S / interval), MIN_SAMPLES)
    if len(measured) < MIN_BLOCKS * length:
        return None
    lacking = [_lacking(measured[names], ideal[names], length) for names in _sensors(measured, ideal)]
    lowest = min((first for first in lacking if first is not None), default=None)
    if lowest is None:
        return None
    return ReferenceBand(lowest / (length * interval), interval)


def _sensors(measured: pd.DataFrame, ideal: pd.DataFrame) -> list[list[str]]:
    """Return the axes of each sensor that log and reference have."""
    known = [axis for axis in axes(measured) if axis in ideal]
    return [some for triad in (GYRO, ACCEL) if len(some := [axis for axis in known if axis in triad]) >= MIN_AXES]


def _lacking(measured: pd.DataFrame, ideal: pd.DataFrame, length: int) -> int | None:
    """Return the first frequency bin of the octaves, from the highest that shows it, in which motion is lacking."""
    difference, motion = (_spectra(table, length) for table in (measured - ideal.to_numpy(), ideal))
    louder = np.sum(np.abs(motion[:, 1:]) ** 2, axis=(1, 2))
    edges = _octaves(motion.shape[1])
    shown = [
        sum(_shows(difference[:, one, k], motion[:, one, k], louder) for k in range(motion.shape[2])) >= MIN_AXES
        for one in (slice(*pair) for pair in pairwise(edges))
    ]
    if not any(shown):
        return None
    last = len(shown) - 1 - shown[::-1].index(True)
    first = max((k + 1 for k in range(last) if not shown[k]), default=0)
    return edges[first]


def _spectra(table: pd.DataFrame, length: int) -> np.ndarray:
    """Return the spectra of blocks of samples, shape (blocks, frequencies, axes)."""
    values = table.to_numpy(float)
    blocks = values[: len(values) // length * length].reshape(-1, length, values.shape[1])
    window = np.hanning(length)[:, None]
    return rfft((blocks - blocks.mean(axis=1, keepdims=True)) * window, axis=1)


def _octaves(count: int) -> list[int]:
    """Return the edges of octaves among ``count`` frequency bins, from the second bin to the last."""
    edges = [count]
    while edges[0] > 4:
        edges.insert(0, (edges[0] + 1) // 2)
    return edges


def _shows(difference: np.ndarray, motion: np.ndarray, louder: np.ndarray) -> bool:
    """Return whether the difference in a band, spectra of shape (blocks, bins), is of the reference."""
    power, own = (np.sum(np.abs(one) ** 2, axis=1) for one in (difference, motion))
    if own.sum() > MIN_NOISE * power.sum() and _coherence(difference + motion, motion) < MAX_COHERENCE:
        return True
    if power.sum() < MIN_RATIO * own.sum() or _coherence(difference, motion) > MAX_COHERENCE:
        return False
    varied = np.ptp(power) > 0 and np.ptp(louder) > 0
    return bool(varied and (_grows(power, louder) or _rises(power, louder, difference.shape[1])))


def _coherence(one: np.ndarray, other: np.ndarray) -> float:
    """Return the coherence of two spectra over the blocks, each of shape (blocks, bins), 0 to 1."""
    both = np.abs(np.sum(one * other.conj(), axis=0)) ** 2
    alone = np.sum(np.abs(one) ** 2, axis=0) * np.sum(np.abs(other) ** 2, axis=0)
    return float(both.sum() / max(alone.sum(), np.finfo(float).tiny))


def _grows(power: np.ndarray, louder: np.ndarray) -> bool:
    """Return whether the power of the difference grows with the motion, both of shape (blocks,)."""
    correlation = spearmanr(louder, power)
    return correlation.statistic > MIN_CORRELATION and correlation.pvalue < MAX_P


def _rises(power: np.ndarray, louder: np.ndarray, bins: int) -> bool:
    """Return whether the power of the difference is larger than in the quietest blocks, where the device rests.

    A band of ``bins`` frequencies has about as many degrees of freedom in a block, as the window takes half of them.
    """
    quiet = np.argsort(louder)[: max(round(QUIET_SHARE * len(power)), MIN_QUIET)]
    rise = np.median(power) / power[quiet].mean()
    return rise > MIN_RISE and f_distribution.sf(rise, bins, bins * len(quiet)) < MAX_P
