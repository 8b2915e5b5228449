"""Attitude of a moving vehicle by velocity matching: device and receiver see the same changes of velocity.

The gyroscopes carry the attitude from the time in question over a window around it; what is unknown is the constant
attitude ``C`` there. With specific force ``f``, the velocities ``v`` of the fixes at ``t_k`` and gravity ``g`` down,

    ``v(t_k+1) - v(t_k) - g (t_k+1 - t_k) = C int C_b0b f dt``

is one pair of vectors per interval (Wahba's problem), which least squares then refine together with the gyroscope
biases. The vehicle need neither point along its course nor rest before. The residuals say whether device and receiver
agree at all.

Source: Y. Wu, X. Pan, Velocity/position integration formula, part I: application to in-flight coarse alignment, IEEE
Trans. Aerosp. Electron. Syst. 49 (2013) 1006-1023.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

from imugap.numerics.rotation import add_scaled, kernel, multiply, quat_from_rotvec, renormalise, rotate

BEFORE_S, AFTER_S = 5.0, 20.0
"""Window before and after the time of the attitude [s]."""
SPAN_S = 1.0
"""Shortest interval of a change of velocity [s]."""
FEWEST = 5
"""Smallest number of intervals."""
STEPS = 2
"""Steps of the least squares."""
SMALL_RATE = 1e-4
"""Step of the derivative by a gyroscope bias [rad/s]."""


class MatchedAttitude(NamedTuple):
    """Attitude by velocity matching.

    Attributes
    ----------
    rotation
        ``nb``.
    covariance
        Of its rotation vector in ``n`` [rad^2], shape (3, 3); from the residuals, where these exceed the noise.
    misfit
        Root mean square of the residuals over the expected one.
    residual, change
        Sums of squares of the residuals, and of the changes of velocity [m^2/s^2].
    freedom
        Degrees of freedom of the residuals.
    """

    rotation: Rotation
    covariance: np.ndarray
    misfit: float
    residual: float
    change: float
    freedom: int

    @property
    def heading(self) -> float:
        """Heading [rad]."""
        ahead = self.rotation.apply([1.0, 0.0, 0.0])
        return float(np.arctan2(ahead[1], ahead[0]))

    @property
    def heading_std(self) -> float:
        """Standard deviation of the heading [rad]."""
        return float(np.sqrt(self.covariance[2, 2]))


@dataclass(frozen=True, eq=False)
class VelocityPair:
    """Samples of a device, and velocities of a receiver on the same clock.

    Attributes
    ----------
    stamp, samples
        Stamps [s], and rates and specific forces less their known errors, shape (n, 6).
    time, velocity, std
        Times of the fixes [s]; velocities, NaN where unknown, and their standard deviations [m/s], shape (m, 3).
    gravity
        [m/s^2].
    bias_std
        Standard deviation of the gyroscope biases that are left [rad/s].
    """

    stamp: np.ndarray
    samples: np.ndarray
    time: np.ndarray
    velocity: np.ndarray
    std: np.ndarray
    gravity: float
    bias_std: float

    def match(self, at: float, span: float = SPAN_S) -> MatchedAttitude | None:
        """Return the attitude at a time by the changes of velocity around it; None where these are too few."""
        low, high = np.searchsorted(self.stamp, [at - BEFORE_S, at + AFTER_S])
        stamp, samples, chosen = self.stamp[low:high], self.samples[low:high], self.chosen(at, span)
        if len(chosen) <= FEWEST:
            return None
        time, velocity, std = self.time[chosen], self.velocity[chosen], self.std[chosen]
        first, steps = int(np.clip(np.searchsorted(stamp, at), 0, len(stamp) - 1)), np.diff(time)[:, None]
        change = np.diff(velocity, axis=0)
        seen, noise = change - steps * [0.0, 0.0, self.gravity], np.sqrt(np.mean(std[1:] ** 2 + std[:-1] ** 2))
        pushed = _pushes(stamp, samples, time, first, np.zeros(3))
        by_bias = np.stack([
            (_pushes(stamp, samples, time, first, SMALL_RATE * axis) - pushed) / SMALL_RATE for axis in np.eye(3)
        ], axis=2)  # fmt: skip
        rotation, bias = Rotation.align_vectors(seen, pushed)[0], np.zeros(3)
        prior = np.diag([0.0] * 3 + [(noise / self.bias_std) ** 2] * 3)
        for _ in range(STEPS):
            turned, mat = rotation.apply(pushed + by_bias @ bias), rotation.as_matrix()
            rows = np.concatenate([-_cross_matrices(turned), mat @ by_bias], axis=2).reshape(-1, 6)
            normal = rows.T @ rows + prior
            step = np.linalg.solve(normal, rows.T @ (seen - turned).ravel() - prior @ [0.0, 0.0, 0.0, *bias])
            rotation, bias = Rotation.from_rotvec(step[:3]) * rotation, bias + step[3:]
        residual = float(np.sum((seen - rotation.apply(pushed + by_bias @ bias)) ** 2))
        freedom = 3 * len(seen) - 3
        misfit = float(np.sqrt(residual / freedom) / noise)
        covariance = np.linalg.inv(normal)[:3, :3] * (noise * max(misfit, 1.0)) ** 2
        return MatchedAttitude(rotation, covariance, misfit, residual, float(np.sum(change**2)), freedom)

    def chosen(self, at: float, span: float = SPAN_S) -> list[int]:
        """Return the numbers of the fixes around a time that have a velocity and are at least ``span`` apart."""
        low, high = max(self.stamp[0], at - BEFORE_S), min(self.stamp[-1], at + AFTER_S)
        chosen, last = [], -np.inf
        for k in range(*np.searchsorted(self.time, [low, high])):
            if self.time[k] - last >= span - 1e-6 and np.isfinite(self.velocity[k]).all():
                chosen.append(int(k))
                last = self.time[k]
        return chosen


def _pushes(stamp: np.ndarray, samples: np.ndarray, time: np.ndarray, first: int, bias: np.ndarray) -> np.ndarray:
    """Return the integrals of the specific force between the times, in the axes of sample ``first`` [m/s]."""
    gyro, accel = np.ascontiguousarray(samples[:, :3] - bias), np.ascontiguousarray(samples[:, 3:])
    whole = _integrated_force(stamp, gyro, accel, first)
    return np.diff(np.column_stack([np.interp(time, stamp, column) for column in whole.T]), axis=0)


def _cross_matrices(vectors: np.ndarray) -> np.ndarray:
    """Return the matrices of the cross product from the left, shape (n, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    return np.stack([np.stack(row, axis=1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], axis=1)


@kernel
def _row(table, k):
    return table[k, 0], table[k, 1], table[k, 2]


@njit(cache=True, error_model="numpy")
def _integrated_force(stamp, gyro, accel, first):
    """Return the integral of the specific force, in the axes of the device at sample ``first`` and zero there.

    A sample is the mean over the interval that it ends.
    """
    total = np.zeros((len(stamp), 3))
    for forward in (True, False):
        quat, gain = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
        count = len(stamp) - 1 - first if forward else first
        for step in range(count):
            k = first + 1 + step if forward else first - step
            interval = stamp[k] - stamp[k - 1] if forward else stamp[k - 1] - stamp[k]
            half = 0.5 * interval
            turn = quat_from_rotvec((half * gyro[k, 0], half * gyro[k, 1], half * gyro[k, 2]))
            quat = multiply(quat, turn)
            gain = add_scaled(gain, interval, rotate(quat, _row(accel, k)))
            quat = renormalise(multiply(quat, turn))
            at = k if forward else k - 1
            total[at, 0], total[at, 1], total[at, 2] = gain[0], gain[1], gain[2]
    return total
