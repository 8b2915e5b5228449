"""Filter output by epoch, and the fixed-interval smoother, for filters of any motion.

A filter of the error state of :mod:`imugap.filters.error_state` writes a row of a :class:`History` at each epoch. For
the smoother it also fills a :class:`SmootherBlock`, one block of epochs at a time; :func:`smooth_block` then corrects
the history backward (Bryson and Frazier; Bierman 1973), so that the memory is that of one block.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit
from scipy.spatial.transform import Rotation

from imugap.filters.chords import LENGTH, Chords, carry_measurement, carry_transition, pass_end
from imugap.filters.error_state import (
    ATTITUDE,
    NAVIGATION,
    adjoint_measurement,
    adjoint_transition,
    correct_navigation,
    multiply_matrices,
    scalar_update,
)
from imugap.filters.sensor_states import SensorStates
from imugap.kinematics.strapdown import COLUMNS
from imugap.numerics.rotation import kernel, to_euler

CROSS = ((0, 1), (6, 7), (6, 8), (7, 8))
"""Covariances stored besides the variances: of the horizontal position, and of the attitude."""
BLOCK = 256
"""Epochs in a block of the smoother."""
ROUNDING = 1e-15
"""Rounding of the information of later measurements, over the largest that it has been [1]: some units of a float."""
NOWHERE = np.empty(0, np.int64)
"""No ends of chords."""


class History(NamedTuple):
    """Filter output by epoch: navigation, errors, variances of all states, covariances :data:`CROSS`, NIS."""

    navigation: np.ndarray
    errors: np.ndarray
    variances: np.ndarray
    cross: np.ndarray
    nis: np.ndarray

    @classmethod
    def empty(cls, count: int, size: int) -> "History":
        """Allocate ``count`` epochs of ``size`` states."""
        shapes = (count, 10), (count, size - NAVIGATION), (count, size), (count, len(CROSS)), (count,)
        return cls(*(np.empty(shape) for shape in shapes))

    def begin(self, navigation: np.ndarray, errors: np.ndarray, covariance: np.ndarray) -> None:
        """Write the first epoch, which has no measurement."""
        self.navigation[0], self.errors[0] = navigation, errors
        self.variances[0] = np.diag(covariance)
        self.cross[0] = [covariance[slot] for slot in CROSS]
        self.nis[0] = np.nan


class SmootherBlock(NamedTuple):
    """Transposed transitions, covariances and scalar measurements of the epochs of a block.

    Arrays of length zero are not filled: all of them for a filter without smoother; all but ``residuals`` and
    ``variances`` where only the innovations are wanted.
    """

    transposed: np.ndarray
    covariance: np.ndarray
    rows: np.ndarray
    gains: np.ndarray
    residuals: np.ndarray
    variances: np.ndarray

    @classmethod
    def empty(cls, count: int, size: int, most: int = 6) -> "SmootherBlock":
        """Allocate ``count`` epochs of ``size`` states and at most ``most`` measurements each."""
        square, rows, each = (count, size, size), (count, most, size), (count, most)
        return cls(*(np.zeros(shape) for shape in (square, square, rows, rows, each, each)))

    @classmethod
    def of_innovations(cls, count: int, most: int) -> "SmootherBlock":
        """Allocate the innovations of ``count`` epochs of at most ``most`` measurements."""
        return cls.empty(0, 0)._replace(residuals=np.zeros((count, most)), variances=np.zeros((count, most)))


class SensorArrays(NamedTuple):
    """Sensor states as arrays for compiled code (:class:`imugap.filters.sensor_states.SensorStates`)."""

    axis: np.ndarray
    scale: np.ndarray
    decay: np.ndarray
    driving: np.ndarray
    white: np.ndarray
    fixed: np.ndarray

    @classmethod
    def of(cls, states: SensorStates) -> "SensorArrays":
        """Take the arrays of the states."""
        return cls(states.axis, states.scale, states.decay, states.driving_psd, states.white, states.fixed)


@dataclass(frozen=True, eq=False)
class NavigationSolution:
    """A history as tables; rows are the epochs.

    Attributes
    ----------
    time
        Stamps [s].
    names
        Names of the states behind the navigation.
    history
        Filter output.
    """

    time: pd.Index
    names: list[str]
    history: History

    @cached_property
    def trajectory(self) -> pd.DataFrame:
        """The Trajectory."""
        table = np.hstack([self.history.navigation[:, :6], self._euler])
        return pd.DataFrame(table, index=self.time, columns=list(COLUMNS))

    @cached_property
    def trajectory_std(self) -> pd.DataFrame:
        """Standard deviations in the columns of the Trajectory."""
        linear = np.sqrt(np.maximum(self.history.variances[:, :ATTITUDE], 0))
        table = np.hstack([linear, _euler_std(self._euler, self.history)])
        return pd.DataFrame(table, index=self.time, columns=list(COLUMNS))

    @cached_property
    def sensors(self) -> pd.DataFrame:
        """Estimates of the states behind the navigation: sensor errors and constants."""
        return pd.DataFrame(self.history.errors, index=self.time, columns=self.names)

    @cached_property
    def sensors_std(self) -> pd.DataFrame:
        """Standard deviations in the columns of ``sensors``."""
        table = np.sqrt(np.maximum(self.history.variances[:, NAVIGATION:], 0))
        return pd.DataFrame(table, index=self.time, columns=self.names)

    @cached_property
    def horizontal(self) -> np.ndarray:
        """Covariance of the position, north and east [m^2], shape (n, 2, 2)."""
        north, east, across = self.history.variances[:, 0], self.history.variances[:, 1], self.history.cross[:, 0]
        return np.stack([np.stack([north, across], axis=1), np.stack([across, east], axis=1)], axis=2)

    @cached_property
    def _euler(self) -> np.ndarray:
        return to_euler(Rotation.from_quat(self.history.navigation[:, ATTITUDE:]))


@kernel
def compensate(samples, k, axis, scale, fixed, errors, sensitivity, now, before):
    """Store the samples k and k - 1, less their estimated errors, in ``now`` and ``before``, and the sensitivities."""
    for a in range(6):
        now[a], before[a] = samples[k, a] - fixed[a], samples[k - 1, a] - fixed[a]
    for s in range(len(axis)):
        a = axis[s]
        if scale[s]:
            sensitivity[s] = samples[k, a]
            before[a] -= samples[k - 1, a] * errors[s]
        else:
            before[a] -= errors[s]
        now[a] -= sensitivity[s] * errors[s]


@kernel
def discretise_states(decay, driving, interval, decay_factor, driving_variance):
    """Store the decay factor and the driving variance of each sensor state over an interval."""
    for s in range(len(decay)):
        decay_factor[s] = np.exp(-decay[s] * interval)
        driving_variance[s] = driving[s] * (
            interval if decay[s] == 0.0 else (1 - decay_factor[s] * decay_factor[s]) / (2 * decay[s])
        )


@kernel
def apply_measurement(covariance, errors, row, residual, noise, cross_covariance, gain, nav, block, slot, number, fed):
    """Apply a scalar measurement and store it; return the corrected navigation and the NIS, and clear ``row``."""
    nav, variance = scalar_update(covariance, errors, row, residual, noise, cross_covariance, gain, nav, fed)
    if len(block.residuals):
        block.residuals[slot, number], block.variances[slot, number] = residual, variance
    if len(block.rows):
        for j in range(len(row)):
            block.rows[slot, number, j], block.gains[slot, number, j] = row[j], gain[j]
    for j in range(len(row)):
        row[j] = 0.0
    return nav, residual * residual / variance


@kernel
def write_epoch(history, k, nav, errors, covariance):
    """Write epoch ``k``."""
    for i in range(3):
        history.navigation[k, i], history.navigation[k, 3 + i] = nav[0][i], nav[1][i]
    for i in range(4):
        history.navigation[k, 6 + i] = nav[2][i]
        history.cross[k, i] = covariance[CROSS[i][0], CROSS[i][1]]
    for s in range(len(errors)):
        history.errors[k, s] = errors[s]
    for i in range(len(covariance)):
        history.variances[k, i] = covariance[i, i]


@njit(cache=True, error_model="numpy")
def smooth_block(history, first, last, block, adjoint, information, largest, chords, carried):
    """Correct the history of a block by all later measurements, and propagate the adjoint back over it.

    Behind an outage the first fixes take off nearly all of a large covariance, and of the information little is left
    over its rounding: no variance is stated below what that makes of it. ``largest`` is the largest information on each
    state so far, shape (states,). ``carried`` are the functionals of the chords (:mod:`imugap.filters.chords`), which
    go back with the adjoint.
    """
    size = len(adjoint)
    error, work = np.empty(size), np.empty((size, size))
    end = np.searchsorted(chords.epochs, last) - 1
    for k in range(last - 1, first - 1, -1):
        slot = k - first
        covariance = block.covariance[slot]
        for i in range(size):
            error[i] = 0.0
            for j in range(size):
                error[i] -= covariance[i, j] * adjoint[j]
        nav = history.navigation[k]
        position, velocity, quat = correct_navigation(
            (nav[0], nav[1], nav[2]), (nav[3], nav[4], nav[5]), (nav[6], nav[7], nav[8], nav[9]), error
        )
        for i in range(3):
            nav[i], nav[3 + i] = position[i], velocity[i]
        for i in range(4):
            nav[6 + i] = quat[i]
        for s in range(size - NAVIGATION):
            history.errors[k, s] -= error[NAVIGATION + s]
        multiply_matrices(covariance, information, work)
        for i in range(size):
            variance, rounding = covariance[i, i], 0.0
            for m in range(size):
                variance -= work[i, m] * covariance[m, i]
                rounding += ROUNDING * largest[m] * covariance[m, i] * covariance[m, i]
            history.variances[k, i] = max(variance, rounding)
        for c in range(4):
            i, j = CROSS[c]
            history.cross[k, c] = covariance[i, j]
            for m in range(size):
                history.cross[k, c] -= work[i, m] * covariance[m, j]
        if end >= 0 and chords.epochs[end] == k:
            pass_end(chords, end, covariance, work, carried)
            end -= 1
        for number in range(block.variances.shape[1] - 1, -1, -1):
            if block.variances[slot, number] > 0.0:
                carry_measurement(carried, block.rows[slot, number], block.gains[slot, number])
                adjoint_measurement(
                    adjoint, information, block.rows[slot, number], block.gains[slot, number],
                    block.residuals[slot, number], block.variances[slot, number], work[0],
                )  # fmt: skip
        carry_transition(carried, block.transposed[slot], work[0])
        adjoint_transition(adjoint, information, block.transposed[slot], work)
        for i in range(size):
            largest[i] = max(largest[i], information[i, i])


def run_filter(step: Callable, state, history: History) -> None:
    """Filter all epochs of a history.

    Parameters
    ----------
    step
        ``step(first, last, state, block)`` filters a range of epochs from ``state``, and updates ``state``.
    state
        State at the first epoch; has ``copy``.
    """
    step(1, len(history.nis), state, SmootherBlock.empty(0, history.variances.shape[1]))


def run_smoother(
    step: Callable, state, history: History, most: int, ends: np.ndarray = NOWHERE, shortest: float = 0.0
) -> Chords:
    """Smooth all epochs of a history: filter by blocks, then filter each block again, last first, and correct it.

    Parameters
    ----------
    step, state
        Those of :func:`run_filter`.
    most
        Largest number of scalar measurements of an epoch.
    ends, shortest
        Epochs between which the chords are wanted, shape (ends,), and the length from which on one counts for the path
        [m] (:meth:`imugap.filters.chords.Chords.between`).

    Returns
    -------
    Chords
        Chords between the ends.
    """
    count, size = history.variances.shape
    blocks, starts = list(pairwise([*range(1, count, BLOCK), count])), []
    for first, last in blocks:
        starts.append(state.copy())
        step(first, last, state, SmootherBlock.empty(0, size))
    adjoint, information, carried = np.zeros(size), np.zeros((size, size)), np.zeros((LENGTH + 1, size))
    largest = np.zeros(size)
    chords = Chords.between(ends, history.navigation[ends, :3], shortest)
    for (first, last), start in zip(reversed(blocks), reversed(starts), strict=True):
        block = SmootherBlock.empty(last - first, size, most)
        step(first, last, start, block)
        smooth_block(history, first, last, block, adjoint, information, largest, chords, carried)
    return chords


def _euler_std(euler: np.ndarray, history: History) -> np.ndarray:
    """Return the standard deviations of roll, pitch and heading [rad], shape (n, 3), from the covariance in ``n``."""
    covariance = np.empty((len(euler), 3, 3))
    covariance[:, [0, 1, 2], [0, 1, 2]] = history.variances[:, ATTITUDE:NAVIGATION]
    for (i, j), values in zip(CROSS[1:], history.cross[:, 1:].T, strict=True):
        covariance[:, i - ATTITUDE, j - ATTITUDE] = covariance[:, j - ATTITUDE, i - ATTITUDE] = values
    _, pitch, heading = euler.T
    zero, one = np.zeros(len(euler)), np.ones(len(euler))
    roll_row = np.stack([np.cos(heading) / np.cos(pitch), np.sin(heading) / np.cos(pitch), zero], axis=1)
    pitch_row = np.stack([-np.sin(heading), np.cos(heading), zero], axis=1)
    heading_row = roll_row * np.sin(pitch)[:, None] + np.stack([zero, zero, one], axis=1)
    rows = np.stack([roll_row, pitch_row, heading_row], axis=1)
    return np.sqrt(np.maximum(np.einsum("nij,njk,nik->ni", rows, covariance, rows), 0))
