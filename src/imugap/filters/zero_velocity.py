"""Zero-velocity detection of a foot from its angular rate and specific force.

The four detectors of Skog et al. (2010) test whether the sensor is at rest over a window. With y the specific force, w
the angular rate, g gravity, means over the window, and standard deviations s_a and s_w,

* :attr:`Statistic.GLRT` (SHOE): mean of ``|y - g u|^2/s_a^2 + |w|^2/s_w^2``, u the direction of the mean of y,
* :attr:`Statistic.RATE_ENERGY`: mean of ``|w|^2/s_w^2``,
* :attr:`Statistic.MOVING_VARIANCE`: mean of ``|y - mean(y)|^2/s_a^2``,
* :attr:`Statistic.MAGNITUDE`: mean of ``(|y| - g)^2/s_a^2``.

All are computed by running sums.

The threshold is adaptive. The stand at the start gives gravity, the gyroscope biases and the noise of both triads. The
motion of a foot at stance, the same for all walks, is added to the noise, so that a statistic of about 1 is expected at
stance. Since this varies with the gait, the threshold is a multiple of the lowest statistic within a stride, within
fixed bounds.

The velocity of a foot at stance is the less certain the more it moves. A window in a slow swing can be as quiet as the
stance of a runner, so the motion at a sample (:meth:`Detector.motion`) is the statistic relative to the threshold of
the seconds around it, which hold a stance of the slowest gait.

Source: I. Skog, P. Handel, J.-O. Nilsson, J. Rantakokko, Zero-velocity detection - an algorithm evaluation, IEEE Trans.
Biomed. Eng. 57 (2010) 2657-2666.
"""

from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numba import njit
from scipy.ndimage import minimum_filter1d

MOVING, STANCE, STILL = 0, 1, 2
"""Phase of the foot at a sample: moving; at stance while the body walks; still, since the body stands."""


class Statistic(IntEnum):
    """Detection statistic that is compared with the threshold."""

    GLRT = 0
    RATE_ENERGY = 1
    MOVING_VARIANCE = 2
    MAGNITUDE = 3


@dataclass(frozen=True)
class Stand:
    """Sensor statistics of the stand at the start of a walk, or of a stance that takes its place.

    Attributes
    ----------
    count
        Number of samples of the stand.
    gravity
        Norm of the mean specific force [m/s^2].
    bias
        Mean angular rate [rad/s], shape (3,).
    accel_std, gyro_std
        Standard deviation of the samples of an axis, root mean square over the axes [m/s^2], [rad/s].
    first
        Number of its first sample.
    still
        Whether the body stands. If not, the foot alone is at rest, and the biases are unknown: zero.
    """

    count: int
    gravity: float
    bias: tuple[float, float, float]
    accel_std: float
    gyro_std: float
    first: int = 0
    still: bool = True

    @classmethod
    def of(cls, gyro: np.ndarray, accel: np.ndarray) -> "Stand":
        """Return the statistics of the samples of a stand at the start, shape (n, 3) each."""
        return cls(
            count=len(gyro),
            gravity=float(np.linalg.norm(accel.mean(axis=0))),
            bias=tuple(gyro.mean(axis=0).tolist()),
            accel_std=float(np.sqrt(accel.var(axis=0).mean())),
            gyro_std=float(np.sqrt(gyro.var(axis=0).mean())),
        )

    @property
    def rows(self) -> slice:
        """Samples of the stand."""
        return slice(self.first, self.first + self.count)


@dataclass(frozen=True)
class Detector:
    """Settings of the zero-velocity detector.

    Attributes
    ----------
    statistic
        Detection statistic.
    window_s, stride_s
        Length of the window, and of the time that holds at least one stance of a usual gait [s].
    slowest_s
        Time that holds at least one stance of the slowest gait [s].
    accel_std, gyro_std
        Standard deviation of the motion of a foot at stance [m/s^2], [rad/s].
    multiple, lowest, highest
        The threshold is this multiple of the lowest statistic of a stride, within these bounds.
    still_s, still_accel_std, still_gyro_std
        The body stands where the GLRT with these standard deviations, over this window, is below 1 [s], [m/s^2],
        [rad/s].
    stand_s, shortest_s
        Window for the stand at the start [s]; and its shortest length, which is tried where there is none so long [s].
    stance_s
        Window for the stance that takes the place of a stand [s].
    """

    statistic: Statistic = Statistic.GLRT
    window_s: float = 0.04
    stride_s: float = 0.8
    slowest_s: float = 3.0
    accel_std: float = 0.5
    gyro_std: float = 0.35
    multiple: float = 4.0
    lowest: float = 1.0
    highest: float = 100.0
    still_s: float = 1.0
    still_accel_std: float = 0.3
    still_gyro_std: float = 0.04
    stand_s: float = 0.5
    shortest_s: float = 0.2
    stance_s: float = 0.1

    def stand(self, gyro: np.ndarray, accel: np.ndarray, interval: float) -> Stand:
        """Return the statistics of the stand at the start of samples, shape (n, 3) each; a ValueError without one."""
        count, least = self._stand_count(gyro, accel, interval)
        if count < least:
            raise ValueError(
                f"walk: expected a stand of {self.shortest_s:g} s or more at the start (or --heading-free); found "
                f"{count * interval:.2g} s"
            )
        return Stand.of(gyro[:count], accel[:count])

    def stand_or_stance(self, gyro: np.ndarray, accel: np.ndarray, interval: float, gravity: float) -> Stand:
        """Return the stand at the start, or where there is none the quietest stance within :attr:`slowest_s`.

        Parameters
        ----------
        gravity
            Local gravity [m/s^2].
        """
        count, least = self._stand_count(gyro, accel, interval)
        if count >= least:
            return Stand.of(gyro[:count], accel[:count])
        reach, window = (_samples(length, interval) for length in (self.slowest_s, self.stance_s))
        begin = gyro[:reach], accel[:reach]
        first = int(np.argmin(statistic(self.statistic, *begin, window, self.accel_std, self.gyro_std, gravity)))
        found = Stand.of(*(one[first : first + window] for one in begin))
        return replace(found, bias=(0.0, 0.0, 0.0), first=first, still=False)

    def _stand_count(self, gyro: np.ndarray, accel: np.ndarray, interval: float) -> tuple[int, int]:
        """Return the number of samples of the stand at the start, and the least that is needed."""
        count = least = 0
        for length in (self.stand_s, self.shortest_s):
            least = _samples(length, interval)
            count = count if count >= least else self._standing(gyro, accel, least)
        return count, least

    def _standing(self, gyro: np.ndarray, accel: np.ndarray, window: int) -> int:
        """Return the number of samples of a stand at the start, by a window of ``window`` samples."""
        bias, force = gyro[:window].mean(axis=0), accel[:window].mean(axis=0)
        reach, count = 0, 0
        while count == reach < len(gyro):
            reach = min(max(4 * reach, 40 * window), len(gyro))
            still = self._still(gyro[:reach] - bias, accel[:reach], window, float(np.linalg.norm(force)))
            count = int(np.argmin(still)) if not still.all() else reach
        return count

    def phases(self, gyro: np.ndarray, accel: np.ndarray, interval: float, stand: Stand) -> np.ndarray:
        """Return :data:`MOVING`, :data:`STANCE` or :data:`STILL` for each sample, shape (n,).

        The decision on a window applies at its middle; the first and last decisions extend to the ends.
        """
        values, window = self._values(gyro, accel, interval, stand)
        rest = _at_middle(values < self._limit(values, _samples(self.stride_s, interval)), window)
        unbiased = gyro - np.array(stand.bias)
        still = self._still(unbiased, accel, _samples(self.still_s, interval), stand.gravity)
        phase = np.full(len(rest), MOVING, np.int8)
        phase[rest] = STANCE
        phase[rest & still] = STILL
        if stand.still:
            phase[stand.rows] = STILL
        return phase

    def motion(self, gyro: np.ndarray, accel: np.ndarray, interval: float, stand: Stand) -> np.ndarray:
        """Return the statistic at each sample over the threshold within :attr:`slowest_s`, shape (n,)."""
        values, window = self._values(gyro, accel, interval, stand)
        return _at_middle(np.maximum(values, 0.0) / self._limit(values, _samples(self.slowest_s, interval)), window)

    def _values(self, gyro: np.ndarray, accel: np.ndarray, interval: float, stand: Stand) -> tuple[np.ndarray, int]:
        """Return the statistic of each window, and the number of samples in it."""
        window = _samples(self.window_s, interval)
        stds = np.hypot(self.accel_std, stand.accel_std), np.hypot(self.gyro_std, stand.gyro_std)
        unbiased = gyro - np.array(stand.bias)
        return statistic(self.statistic, unbiased, accel, window, *stds, stand.gravity), window

    def _limit(self, values: np.ndarray, stride: int) -> np.ndarray:
        """Return the threshold of each window, from the lowest statistic within ``stride`` windows."""
        lowest = minimum_filter1d(values, stride)
        return np.clip(self.multiple * lowest, self.lowest, self.highest)

    def _still(self, gyro: np.ndarray, accel: np.ndarray, window: int, gravity: float) -> np.ndarray:
        """Return whether the body stands at each sample, shape (n,)."""
        window = min(window, len(gyro))
        values = statistic(Statistic.GLRT, gyro, accel, window, self.still_accel_std, self.still_gyro_std, gravity)
        return _at_middle(values < 1, window)


def _samples(length: float, interval: float) -> int:
    """Return the number of samples in a time of this length, both in [s]: two at least."""
    return max(2, round(length / interval))


def _at_middle(values: np.ndarray, window: int) -> np.ndarray:
    """Return the value of the window centred at each sample; the first and last extend to the ends."""
    return np.pad(values, (window // 2, window - 1 - window // 2), mode="edge")


def statistic(
    kind: Statistic, gyro: np.ndarray, accel: np.ndarray, window: int, accel_std: float, gyro_std: float, gravity: float
) -> np.ndarray:
    """Return the detection statistic of the window that starts at each sample, shape (n - window + 1,).

    Parameters
    ----------
    gyro, accel
        Rate [rad/s] and specific force [m/s^2], shape (n, 3).
    window
        Number of samples in the window, at most n.
    accel_std, gyro_std
        s_a [m/s^2] and s_w [rad/s].
    gravity
        g [m/s^2].
    """
    gyro, accel = np.ascontiguousarray(gyro, dtype=float), np.ascontiguousarray(accel, dtype=float)
    return _statistic(int(kind), gyro, accel, window, accel_std, gyro_std, gravity)


@njit(cache=True)
def _statistic(kind, gyro, accel, window, accel_std, gyro_std, gravity):
    values = np.empty(len(gyro) - window + 1)
    x = y = z = square = norm = turn = 0.0
    per_force, per_rate = 1.0 / (window * accel_std * accel_std), 1.0 / (window * gyro_std * gyro_std)
    for k in range(len(gyro)):
        for row, sign in ((k, 1.0), (k - window, -1.0)):
            if row >= 0:
                a0, a1, a2 = accel[row, 0], accel[row, 1], accel[row, 2]
                force = a0 * a0 + a1 * a1 + a2 * a2
                x, y, z = x + sign * a0, y + sign * a1, z + sign * a2
                square += sign * force
                norm += sign * np.sqrt(force)
                turn += sign * (gyro[row, 0] ** 2 + gyro[row, 1] ** 2 + gyro[row, 2] ** 2)
        if k >= window - 1:
            together = np.sqrt(x * x + y * y + z * z)
            if kind == Statistic.GLRT:
                value = (square - 2 * gravity * together + window * gravity * gravity) * per_force + turn * per_rate
            elif kind == Statistic.RATE_ENERGY:
                value = turn * per_rate
            elif kind == Statistic.MOVING_VARIANCE:
                value = (square - together * together / window) * per_force
            else:
                value = (square - 2 * gravity * norm + window * gravity * gravity) * per_force
            values[k - window + 1] = value
    return values
