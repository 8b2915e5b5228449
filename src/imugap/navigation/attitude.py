"""Attitude from gyroscopes and accelerometers: an error-state Kalman filter on the error model of the device.

The gyroscopes are integrated; the accelerometers observe the vertical. The states are the attitude error, a rotation
vector in ``n`` (estimated - true, :mod:`imugap.io.references.reference`), and for each axis a constant bias and the
states of its error model (:meth:`imugap.model.AxisModel.state_space`). All estimates are fed back at every sample, so
the error state itself is zero; corrections multiply the attitude quaternion (Markley 2003).

Without a magnetometer the heading is not observed: its error drifts, as does the bias of a gyroscope whose axis is
vertical. Errors of level accelerometers cannot be separated from a tilt.

True acceleration is a measurement error. Its size is estimated from the horizontal part of the specific force in ``n``:
the mean square of its two components over a memory T is the variance ``a^2`` of a first-order process of correlation
time T, which counts as white noise of its spectral density at zero, ``2 a^2 T``, in addition to the accelerometer
noise. A tilt error counts as acceleration too, which makes the estimate conservative.

Earth rate is neglected, as in :class:`imugap.kinematics.strapdown.Local`; at rest it is part of the gyroscope biases.

Sources: F. L. Markley, Attitude error representations for Kalman filtering, J. Guidance Control Dyn. 26 (2003) 311-317;
P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013, section 14.2
and 3.4 (adaptive measurement noise).
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numba import njit

from imugap.effects.effect import AxisModel
from imugap.kinematics import strapdown
from imugap.kinematics.error_free import QUATERNION
from imugap.kinematics.site import Site
from imugap.log import ACCEL, AXES, GYRO, LogError, interval
from imugap.model import ErrorModel
from imugap.numerics.rotation import from_euler, mat_from_quat, multiply, quat_from_rotvec, renormalise
from imugap.numerics.state_space import StateSpace
from imugap.units import to_si

UNLEVELLED = 1.0
"""Standard deviation of the tilt before levelling [rad]: far above that after levelling."""

COVARIANCE = {"cov_nn": (0, 0), "cov_ne": (0, 1), "cov_ee": (1, 1), "cov_dd": (2, 2)}
"""Columns of the covariance of tilt and heading [rad^2]."""


@dataclass(frozen=True)
class AttitudeAssumptions:
    """Assumptions of the filter besides the error model.

    Attributes
    ----------
    gravity
        Local gravity [m/s^2].
    memory
        Correlation time T of true acceleration [s]; None for a body without acceleration.
    bias_std
        Standard deviation of the constant bias of each gyroscope [rad/s] and of each accelerometer [m/s^2].
    """

    gravity: float
    memory: float | None
    bias_std: tuple[float, float]

    @classmethod
    def from_mapping(cls, site: dict, memory_s: float, bias_std: dict) -> "AttitudeAssumptions":
        """Build from the configuration of a site, the memory [s], and ``gyro_deg_per_s`` and ``accel_mg``."""
        stds = to_si(bias_std["gyro_deg_per_s"], "deg/s"), to_si(bias_std["accel_mg"], "mg")
        return cls(Site.from_mapping(site).gravity, memory_s, stds)


@dataclass(frozen=True)
class InitialAttitude:
    """Initial attitude, and the rest before it.

    Attributes
    ----------
    attitude
        Roll, pitch, heading [rad].
    std
        Standard deviation of the error of the attitude about north, east, down [rad].
    rest
        Samples at rest just before the start, shape (n, 6), SI, or None. They estimate the gyroscope errors and level
        the attitude, which correlates the accelerometer errors with the tilt.
    """

    attitude: tuple[float, float, float]
    std: tuple[float, float, float]
    rest: np.ndarray | None = None

    @classmethod
    def at_rest(cls, rest: pd.DataFrame, heading: float) -> "InitialAttitude":
        """InitialAttitude after a log at rest, levelled by its mean; ``heading`` [rad] is given and counts as exact."""
        attitude = (*strapdown.level(rest[list(ACCEL)].mean()), heading)
        return cls(attitude, (UNLEVELLED, UNLEVELLED, 0.0), rest[list(AXES)].to_numpy())


@dataclass(frozen=True, eq=False)
class AttitudeSolution:
    """Attitude of a body over time and errors of its sensors.

    Attributes
    ----------
    attitude
        Index ``time`` [s], columns :data:`imugap.kinematics.error_free.QUATERNION`.
    covariance
        Covariance of the error of the attitude about north, east, down [rad^2], shape (n, 3, 3).
    sensors, sensors_std
        Estimated error of each axis and its standard deviation, SI; columns the axes.
    innovations
        Specific force minus its prediction, x, y, z in ``b``, updated one after the other, over the standard deviation,
        shape (n, 3): white and standard normal for a consistent filter.
    """

    attitude: pd.DataFrame
    covariance: np.ndarray
    sensors: pd.DataFrame
    sensors_std: pd.DataFrame
    innovations: np.ndarray

    @property
    def std(self) -> np.ndarray:
        """Standard deviation of the error of the attitude about north, east, down [rad], shape (n, 3)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    def table(self, step: float) -> pd.DataFrame:
        """Return the attitude about every ``step`` [s], with the columns :data:`COVARIANCE`."""
        every = max(round(step / interval(self.attitude)), 1)
        kept = self.covariance[::every]
        columns = {name: kept[:, i, j] for name, (i, j) in COVARIANCE.items()}
        return self.attitude.iloc[::every].assign(**columns)


def estimate_attitude(
    log: pd.DataFrame, model: ErrorModel, start: InitialAttitude, assumptions: AttitudeAssumptions
) -> AttitudeSolution:
    """Estimate the attitude at every sample of a log with six axes.

    Parameters
    ----------
    log
        Evenly spaced samples, each the mean over the interval that ends at its stamp.
    model
        Error model; only its stochastic effects are used. An axis without a model has a bias only.
    start
        Initial attitude, at the beginning of the interval of the first sample.
    assumptions
        Gravity, acceleration and biases.
    """
    step, gravity = interval(log), assumptions.gravity
    gyro, accel = _samples(log, step)
    sensors = _Sensors.of(model, assumptions.bias_std, step)
    quat_nb = from_euler(start.attitude).as_quat()
    mean, covariance = _initial(start, sensors, quat_nb, gravity)
    memory = assumptions.memory or 0.0
    filtered = _filter(gyro, accel, step, quat_nb, mean, covariance, *sensors.arrays(), gravity, memory)
    quats, covariances, errors, stds, innovations = filtered
    return AttitudeSolution(
        pd.DataFrame(quats, index=log.index, columns=list(QUATERNION)),
        covariances,
        pd.DataFrame(errors, index=log.index, columns=list(AXES)),
        pd.DataFrame(stds, index=log.index, columns=list(AXES)),
        innovations,
    )


def _samples(log: pd.DataFrame, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples of gyroscopes and accelerometers, shape (n, 3), of a log without a gap."""
    missing = [axis for axis in AXES if axis not in log.columns]
    if missing:
        raise LogError("log", "columns", f"all of {', '.join(AXES)}", f"no {', '.join(missing)}")
    largest = np.diff(log.index.to_numpy()).max(initial=0.0)
    if largest > 1.5 * interval:
        raise LogError("log", "time", f"steps of {interval:g} s", f"one of {largest:g} s")
    gyro, accel = (np.ascontiguousarray(log[list(names)].to_numpy(float)) for names in (GYRO, ACCEL))
    return gyro, accel


@dataclass(frozen=True, eq=False)
class _Sensors:
    """Errors of the six axes as one discrete state-space model."""

    space: StateSpace
    transition: np.ndarray
    noise: np.ndarray
    output: np.ndarray
    white: np.ndarray

    @classmethod
    def of(cls, model: ErrorModel, bias_std: tuple[float, float], interval: float) -> "_Sensors":
        """Stack the state spaces of the axes, each after its constant bias."""
        stds = dict.fromkeys(GYRO, bias_std[0]) | dict.fromkeys(ACCEL, bias_std[1])
        biases = [StateSpace.first_order(0.0, 0.0, stds[axis] ** 2) for axis in AXES]
        modelled = [model.axes.get(axis, AxisModel()).state_space() for axis in AXES]
        spaces = [bias + space for bias, space in zip(biases, modelled, strict=True)]
        whole = sum(spaces[1:], spaces[0])
        output = np.zeros((len(AXES), len(whole.output)))
        first = 0
        for row, space in zip(output, spaces, strict=True):
            row[first : first + len(space.output)] = space.output
            first += len(space.output)
        white = np.array([space.output_psd for space in spaces]) / interval
        return cls(whole, *whole.discretise(interval), output, white)

    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return transition, noise, output and white noise for compiled code."""
        return self.transition, self.noise, self.output, self.white


def _initial(
    start: InitialAttitude, sensors: _Sensors, quat_nb: np.ndarray, gravity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the estimate of the sensor states and the covariance of attitude and sensors at the start."""
    states = len(sensors.space.output)
    mean, covariance = np.zeros(states), np.zeros((3 + states, 3 + states))
    covariance[:3, :3] = np.diag(np.square(start.std))
    covariance[3:, 3:] = sensors.space.initial_covariance
    if start.rest is None:
        return mean, covariance
    rest = np.ascontiguousarray(start.rest, dtype=float)
    settled = np.ascontiguousarray(covariance[3:, 3:])
    _update_at_rest(rest[:, :3], mean, settled, *sensors.arrays())
    covariance[3:, 3:] = settled
    force = rest[:, 3:].mean(axis=0)
    tilt = np.zeros(3)
    _level(force, quat_nb, tilt, mean, covariance, sensors.output, sensors.white[3:] / len(rest), gravity)
    return mean, covariance


@njit(cache=True)
def _update_at_rest(gyro, mean, covariance, transition, noise, output, white):
    """Update the sensor states, in place, by gyroscopes at rest, whose output is their error."""
    for k in range(len(gyro)):
        mean[:] = transition @ mean
        covariance[:] = transition @ covariance @ transition.T + noise
        for axis in range(3):
            _scalar_update(gyro[k, axis] - output[axis] @ mean, output[axis], white[axis], mean, covariance)


@njit(cache=True)
def _scalar_update(residual, row, variance, mean, covariance):
    """Update ``mean`` and ``covariance``, in place, by one measurement; return the normalised innovation."""
    spread = covariance @ row
    total = row @ spread + variance
    gain = spread / total
    mean += gain * residual
    covariance -= np.outer(gain, spread)
    return residual / np.sqrt(total)


@njit(cache=True)
def _level(force, quat_nb, tilt, mean, covariance, output, variance, gravity):
    """Update tilt and sensor states, in place, by a specific force that is gravity; return the innovations.

    With ``C_estimated = exp(tilt) C`` the residual is ``C_estimated' (g x tilt)`` plus the errors of the sensors.
    """
    mat = mat_from_quat(quat_nb)
    states = len(mean)
    both = np.concatenate((tilt, mean))
    innovations = np.empty(3)
    for axis in range(3):
        row = np.zeros(3 + states)
        row[0], row[1] = gravity * mat[1][axis], -gravity * mat[0][axis]
        row[3:] = output[3 + axis]
        residual = force[axis] + gravity * mat[2][axis] - row @ both
        innovations[axis] = _scalar_update(residual, row, variance[axis], both, covariance)
    tilt[:], mean[:] = both[:3], both[3:]
    return innovations


@njit(cache=True)
def _predict(covariance, turned, transition, noise, output, white):
    """Predict the covariance, in place; ``turned`` (dt C) maps gyroscope errors to the attitude.

    The sensor states are predicted first, so that they hold for the stamp of the sample.
    """
    reached = turned @ output[:3]
    tracked = turned * np.sqrt(white[:3])
    size = len(covariance)
    step, driving = np.eye(size), np.zeros((size, size))
    step[3:, 3:], driving[3:, 3:] = transition, noise
    step[:3, 3:] = reached @ transition
    shared = reached @ noise
    driving[:3, 3:], driving[3:, :3] = shared, shared.T
    driving[:3, :3] = shared @ reached.T + tracked @ tracked.T
    covariance[:] = step @ covariance @ step.T + driving


@njit(cache=True)
def _filter(gyro, accel, dt, quat, mean, covariance, transition, noise, output, white, gravity, memory):
    """Run the filter; see :func:`estimate_attitude`."""
    count = len(gyro)
    quat_nb = (quat[0], quat[1], quat[2], quat[3])
    quats, covariances, innovations = np.empty((count, 4)), np.empty((count, 3, 3)), np.empty((count, 3))
    errors, stds = np.empty((count, 6)), np.empty((count, 6))
    tilt, square = np.zeros(3), 0.0
    forgetting = dt / memory if memory > 0 else 0.0
    for k in range(count):
        mean[:] = transition @ mean
        error = output @ mean
        rate, force = gyro[k] - error[:3], accel[k] - error[3:]
        if k == 0:
            rate_before, force_before = rate, force
        rotvec, delta_v = strapdown.increments(rate, force, rate_before, force_before, dt, dt)
        rate_before, force_before = rate, force

        mat = np.array(mat_from_quat(quat_nb))
        _predict(covariance, mat * dt, transition, noise, output, white)
        mean_force = np.array([delta_v[0], delta_v[1], delta_v[2]]) / dt
        horizontal = mat[:2] @ mean_force
        square += forgetting * (0.5 * (horizontal @ horizontal) - square)
        variance = white[3:] + 2 * memory / dt * square
        tilt[:] = 0.0
        mean_force += output[3:] @ mean
        innovations[k] = _level(mean_force, quat_nb, tilt, mean, covariance, output, variance, gravity)
        correction = quat_from_rotvec((-tilt[0], -tilt[1], -tilt[2]))
        quat_nb = renormalise(multiply(correction, multiply(quat_nb, quat_from_rotvec(rotvec))))

        quats[k, 0], quats[k, 1], quats[k, 2], quats[k, 3] = quat_nb
        covariances[k] = covariance[:3, :3]
        errors[k] = output @ mean
        shared = output @ np.ascontiguousarray(covariance[3:, 3:])
        stds[k] = np.sqrt((shared * output).sum(axis=1))
    return quats, covariances, errors, stds, innovations
