"""What a filter leaves, epoch by epoch, for a reader and for the smoother; the parts that filters of any motion share.

A filter carries the error state of :mod:`imugap.filters.error_state`. At each epoch it writes a row of a :class:`Path`;
for the smoother it fills a :class:`Tape`, a block of epochs at a time, from which :func:`smooth` goes back over the
path (Bryson and Frazier; Bierman 1973).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit
from scipy.spatial.transform import Rotation

from imugap.filters.error_state import ATTITUDE, NAVIGATION, corrected, measure, retreat, unlearn
from imugap.filters.sensor_states import SensorStates
from imugap.kinematics.strapdown import COLUMNS
from imugap.numerics.rotation import kernel, to_euler

CROSS = ((0, 1), (6, 7), (6, 8), (7, 8))
"""Covariances that are kept besides the variances: of the horizontal position, of the attitude."""
BLOCK = 256
"""Samples that the smoother takes at a time."""


class Path(NamedTuple):
    """What the filter leaves: navigation, errors, variances of all states, covariances :data:`CROSS`, NIS."""

    navigation: np.ndarray
    errors: np.ndarray
    variances: np.ndarray
    cross: np.ndarray
    nis: np.ndarray

    @classmethod
    def empty(cls, count: int, size: int) -> "Path":
        """Return room for so many epochs of so many states."""
        shapes = (count, 10), (count, size - NAVIGATION), (count, size), (count, len(CROSS)), (count,)
        return cls(*(np.empty(shape) for shape in shapes))

    def begin(self, navigation: np.ndarray, errors: np.ndarray, covariance: np.ndarray) -> None:
        """Write the first epoch, which has no measurement."""
        self.navigation[0], self.errors[0] = navigation, errors
        self.variances[0] = np.diag(covariance)
        self.cross[0] = [covariance[place] for place in CROSS]
        self.nis[0] = np.nan


class Tape(NamedTuple):
    """What the filter did in a block: transitions, transposed, scalar measurements and covariance of each epoch.

    Of a filter that only shows its innovations nothing but ``residuals`` and ``variances`` has a length.
    """

    backward: np.ndarray
    covariance: np.ndarray
    rows: np.ndarray
    weights: np.ndarray
    residuals: np.ndarray
    variances: np.ndarray

    @classmethod
    def empty(cls, count: int, size: int, most: int = 6) -> "Tape":
        """Return room for epochs of so many states and at most so many measurements each; of none, nothing is taped."""
        square, rows, each = (count, size, size), (count, most, size), (count, most)
        return cls(*(np.zeros(shape) for shape in (square, square, rows, rows, each, each)))

    @classmethod
    def of_innovations(cls, count: int, most: int) -> "Tape":
        """Return room for the innovations of so many epochs, and for nothing else."""
        return cls.empty(0, 0)._replace(residuals=np.zeros((count, most)), variances=np.zeros((count, most)))


class Sensors(NamedTuple):
    """The states of the sensors as the kernel takes them (:class:`imugap.filters.sensor_states.SensorStates`)."""

    axis: np.ndarray
    scale: np.ndarray
    decay: np.ndarray
    driving: np.ndarray
    white: np.ndarray
    fixed: np.ndarray

    @classmethod
    def of(cls, states: SensorStates) -> "Sensors":
        """Take over the states."""
        return cls(states.axis, states.scale, states.decay, states.driving_psd, states.white, states.fixed)


@dataclass(frozen=True, eq=False)
class Track:
    """A path as tables; rows are the epochs.

    Attributes
    ----------
    time
        Stamps [s].
    names
        Names of the states behind the navigation.
    path
        What the kernel left.
    """

    time: pd.Index
    names: list[str]
    path: Path

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        """The Trajectory."""
        table = np.hstack([self.path.navigation[:, :6], self._euler])
        return pd.DataFrame(table, index=self.time, columns=list(COLUMNS))

    @cached_property
    def trajectory_std(self) -> pd.DataFrame:
        """Standard deviations in the columns of the Trajectory."""
        linear = np.sqrt(np.maximum(self.path.variances[:, :ATTITUDE], 0))
        table = np.hstack([linear, _euler_std(self._euler, self.path)])
        return pd.DataFrame(table, index=self.time, columns=list(COLUMNS))

    @cached_property
    def sensors(self) -> pd.DataFrame:
        """Estimates of the states behind the navigation: errors of the sensors, and constants."""
        return pd.DataFrame(self.path.errors, index=self.time, columns=self.names)

    @cached_property
    def sensors_std(self) -> pd.DataFrame:
        """Standard deviations in the columns of the sensors."""
        table = np.sqrt(np.maximum(self.path.variances[:, NAVIGATION:], 0))
        return pd.DataFrame(table, index=self.time, columns=self.names)

    @cached_property
    def horizontal(self) -> np.ndarray:
        """Covariance of the position, north and east [m^2], shape (n, 2, 2)."""
        north, east, across = self.path.variances[:, 0], self.path.variances[:, 1], self.path.cross[:, 0]
        return np.stack([np.stack([north, across], axis=1), np.stack([across, east], axis=1)], axis=2)

    @cached_property
    def _euler(self) -> np.ndarray:
        return to_euler(Rotation.from_quat(self.path.navigation[:, ATTITUDE:]))


@kernel
def compensate(samples, k, axis, scale, fixed, errors, gain, now, before):
    """Fill ``now`` and ``before`` with the samples k and k - 1 less what is known of their errors, and the gains."""
    for a in range(6):
        now[a], before[a] = samples[k, a] - fixed[a], samples[k - 1, a] - fixed[a]
    for s in range(len(axis)):
        a = axis[s]
        if scale[s]:
            gain[s] = samples[k, a]
            before[a] -= samples[k - 1, a] * errors[s]
        else:
            before[a] -= errors[s]
        now[a] -= gain[s] * errors[s]


@kernel
def age(decay, driving, interval, hold, drive):
    """Fill in what is left of the states of the sensors after an interval, and the variance that drives them."""
    for s in range(len(decay)):
        hold[s] = np.exp(-decay[s] * interval)
        drive[s] = driving[s] * (interval if decay[s] == 0.0 else (1 - hold[s] * hold[s]) / (2 * decay[s]))


@kernel
def take_in(covariance, errors, row, residual, noise, spread, weight, nav, tape, place, number, fed):
    """Take in a scalar measurement and tape it; return the corrected navigation and the NIS, leave ``row`` empty."""
    nav, variance = measure(covariance, errors, row, residual, noise, spread, weight, nav, fed)
    if len(tape.residuals):
        tape.residuals[place, number], tape.variances[place, number] = residual, variance
    if len(tape.rows):
        for j in range(len(row)):
            tape.rows[place, number, j], tape.weights[place, number, j] = row[j], weight[j]
    for j in range(len(row)):
        row[j] = 0.0
    return nav, residual * residual / variance


@kernel
def write(path, k, nav, errors, covariance):
    """Write sample ``k``."""
    for i in range(3):
        path.navigation[k, i], path.navigation[k, 3 + i] = nav[0][i], nav[1][i]
    for i in range(4):
        path.navigation[k, 6 + i] = nav[2][i]
        path.cross[k, i] = covariance[CROSS[i][0], CROSS[i][1]]
    for s in range(len(errors)):
        path.errors[k, s] = errors[s]
    for i in range(len(covariance)):
        path.variances[k, i] = covariance[i, i]


@njit(cache=True, error_model="numpy")
def smooth(path, first, last, tape, adjoint, information):
    """Correct the path over a block by what the measurements behind it tell, and take the adjoint back over it."""
    size = len(adjoint)
    error, work = np.empty(size), np.empty((size, size))
    for k in range(last - 1, first - 1, -1):
        place = k - first
        covariance = tape.covariance[place]
        for i in range(size):
            error[i] = 0.0
            for j in range(size):
                error[i] -= covariance[i, j] * adjoint[j]
        nav = path.navigation[k]
        position, velocity, quat = corrected(
            (nav[0], nav[1], nav[2]), (nav[3], nav[4], nav[5]), (nav[6], nav[7], nav[8], nav[9]), error
        )
        for i in range(3):
            nav[i], nav[3 + i] = position[i], velocity[i]
        for i in range(4):
            nav[6 + i] = quat[i]
        for s in range(size - NAVIGATION):
            path.errors[k, s] -= error[NAVIGATION + s]
        for i in range(size):
            for j in range(size):
                work[i, j] = 0.0
            for m in range(size):
                factor = covariance[i, m]
                for j in range(size):
                    work[i, j] += factor * information[m, j]
        for i in range(size):
            path.variances[k, i] = covariance[i, i]
            for m in range(size):
                path.variances[k, i] -= work[i, m] * covariance[m, i]
        for c in range(4):
            i, j = CROSS[c]
            path.cross[k, c] = covariance[i, j]
            for m in range(size):
                path.cross[k, c] -= work[i, m] * covariance[m, j]
        for number in range(tape.variances.shape[1] - 1, -1, -1):
            if tape.variances[place, number] > 0.0:
                unlearn(
                    adjoint, information, tape.rows[place, number], tape.weights[place, number],
                    tape.residuals[place, number], tape.variances[place, number], work[0],
                )  # fmt: skip
        retreat(adjoint, information, tape.backward[place], work)


def _euler_std(euler: np.ndarray, path: Path) -> np.ndarray:
    """Return the standard deviations of roll, pitch and heading [rad], shape (n, 3), from the covariance in ``n``."""
    covariance = np.empty((len(euler), 3, 3))
    covariance[:, [0, 1, 2], [0, 1, 2]] = path.variances[:, ATTITUDE:NAVIGATION]
    for (i, j), values in zip(CROSS[1:], path.cross[:, 1:].T, strict=True):
        covariance[:, i - ATTITUDE, j - ATTITUDE] = covariance[:, j - ATTITUDE, i - ATTITUDE] = values
    _, pitch, heading = euler.T
    zero, one = np.zeros(len(euler)), np.ones(len(euler))
    roll_row = np.stack([np.cos(heading) / np.cos(pitch), np.sin(heading) / np.cos(pitch), zero], axis=1)
    pitch_row = np.stack([-np.sin(heading), np.cos(heading), zero], axis=1)
    heading_row = roll_row * np.sin(pitch)[:, None] + np.stack([zero, zero, one], axis=1)
    rows = np.stack([roll_row, pitch_row, heading_row], axis=1)
    return np.sqrt(np.maximum(np.einsum("nij,njk,nik->ni", rows, covariance, rows), 0))
