"""What an ideal inertial sensor would measure along a trajectory: the derivatives of poses."""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation, Slerp

from imugap.log import ACCEL, GYRO, TIME
from imugap.numerics.spectra.band_limited import interpolate

QUATERNION = ("quat_x", "quat_y", "quat_z", "quat_w")
"""Columns of the attitude of a pose: unit quaternion from the body to the world, scalar last."""
POSITION, VELOCITY = ("x", "y", "z"), ("vel_x", "vel_y", "vel_z")
"""Columns of position [m] and velocity [m/s] of a pose in a world that does not turn."""
GAP_STEPS = 5.0
"""Step between poses, over the median step, above which nothing in between is known."""


def angular_rate(time: np.ndarray, quaternion: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the angular rate of a body in its own axes [rad/s], shape (m, 3): 2 q* dq/dt of unit quaternions.

    Parameters
    ----------
    time
        Times of the poses [s], shape (n,).
    quaternion
        Body to world, scalar last, shape (n, 4); the sign of each is free.
    at
        Times of the result [s], shape (m,).
    """
    turns = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0
    sign = np.cumprod(np.concatenate([[1.0], np.where(turns, -1.0, 1.0)]))
    between = interpolate(time, quaternion * sign[:, None])
    q, change = between(at), between(at, 1)
    vector = q[:, 3:] * change[:, :3] - change[:, 3:] * q[:, :3] - np.cross(q[:, :3], change[:, :3])
    return 2 * vector / np.sum(q**2, axis=1)[:, None]


def specific_force(
    time: np.ndarray, quaternion: np.ndarray, velocity: np.ndarray, gravity: float, at: np.ndarray
) -> np.ndarray:
    """Return the specific force in the axes of the body [m/s^2], shape (m, 3).

    Parameters
    ----------
    time, quaternion, at
        As for :func:`angular_rate`.
    velocity
        In the world, which does not turn [m/s], shape (n, 3).
    gravity
        Component of gravity along the third axis of the world [m/s^2], negative where that axis points up.
    """
    force = interpolate(time, velocity)(at, 1) - np.array([0.0, 0.0, gravity])
    return Slerp(time, Rotation.from_quat(quaternion))(at).inv().apply(force)


def error_free_log(poses: pd.DataFrame, at: np.ndarray, gravity: float) -> pd.DataFrame:
    """Return the error-free log along poses at those of the times ``at`` [s] that are not in a gap between poses.

    The accelerometers are missing where the poses have neither position nor velocity.

    Parameters
    ----------
    poses
        As :func:`imugap.io.references.poses.read_poses` gives them.
    at
        Increasing times, shape (m,).
    gravity
        As for :func:`specific_force`.
    """
    time = poses.index.to_numpy(float)
    steps, after = np.diff(time), np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    known = (at >= time[0]) & (at <= time[-1]) & (steps[after - 1] <= GAP_STEPS * np.median(steps))
    at, quaternion = at[known], poses[list(QUATERNION)].to_numpy(float)
    columns = dict(zip(GYRO, angular_rate(time, quaternion, at).T, strict=True))
    velocity = _velocity(poses, time)
    if velocity is not None:
        columns |= zip(ACCEL, specific_force(time, quaternion, velocity, gravity, at).T, strict=True)
    return pd.DataFrame(columns, index=pd.Index(at, name=TIME))


def error_free_log_of(measured: pd.DataFrame, poses: pd.DataFrame, gravity: float, lag: float = 0.0) -> pd.DataFrame:
    """Return the error-free log of a measured one, at those of its stamps at which the poses are known.

    The third axis of the world points up or down, as the specific force of the log says.

    Parameters
    ----------
    measured
        Log in the axes of the poses.
    poses
        As for :func:`error_free_log`.
    gravity
        Gravity of the site, positive [m/s^2].
    lag
        Time by which the stamps of the log are late [s].
    """
    at = measured.index.to_numpy(float) - lag
    both = [error_free_log(poses, at, sign * gravity) for sign in (-1, 1)]
    up, down = (one.set_axis(pd.Index(one.index + lag, name=TIME)) for one in both)
    force = [axis for axis in ACCEL if axis in measured and axis in up]
    rows = rows_like(measured, up)[force]
    return min((up, down), key=lambda one: float(np.sum((rows - one[force]).to_numpy() ** 2)))


def rows_like(measured: pd.DataFrame, ideal: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a log nearest to the stamps of its error-free log, at these stamps."""
    nearest = measured.index.get_indexer(ideal.index, method="nearest")
    return measured.iloc[nearest].set_axis(ideal.index)


def _velocity(poses: pd.DataFrame, time: np.ndarray) -> np.ndarray | None:
    """Return the velocity of poses [m/s], shape (n, 3), from their positions if need be; None where they have none."""
    if set(VELOCITY) <= set(poses):
        return poses[list(VELOCITY)].to_numpy(float)
    if set(POSITION) <= set(poses):
        return interpolate(time, poses[list(POSITION)].to_numpy(float))(time, 1)
    return None
