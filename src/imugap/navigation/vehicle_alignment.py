"""Initial alignment of a drive: position, velocity and course from the fixes, level from a rest or in motion.

A receiver does not observe the heading of a body at rest. The filter starts at the first fix whose velocity, or whose
displacement from earlier fixes, gives the course accurately enough; the vehicle points along it. If it rests until
then, the mean specific force gives the level and the gyroscopes their biases, and the gyroscopes carry the level to the
start. If not, it is levelled by the specific force around the start, less the acceleration from the fixes.

Source: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013,
sections 5.6.1 and 5.6.2.
"""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from imugap.filters.alignment import biases_from_rest, level_sensitivity
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY
from imugap.filters.sensor_states import SensorStates
from imugap.io import gnss
from imugap.kinematics import earth
from imugap.kinematics.strapdown import Ellipsoid, Local, NavigationState, level, navigate
from imugap.log import ACCEL, GYRO
from imugap.navigation.vehicle import AlignmentSettings, DriveInputs, InitialState
from imugap.numerics.rotation import from_euler

WAY_S = 3.0
"""Longest time between two fixes that give a course [s]."""
SPAN_S = 1.0
"""Time before and after the start over which a moving vehicle is levelled [s]."""


def align(inputs: DriveInputs) -> InitialState:
    """Return the initial state at the first fix with a known course; raise ValueError without one."""
    log, fixes, assumptions, ellipsoid = inputs.log, inputs.fixes, inputs.assumptions, inputs.ellipsoid
    states, settings = assumptions.states(inputs.model), inputs.alignment
    time = fixes.index.to_numpy(dtype=float) + assumptions.offset_s
    seen = gnss.local(fixes, ellipsoid)
    std = gnss.deviations(fixes, assumptions.position_std, assumptions.velocity_std)
    velocity, spread = _velocities(time, seen, std)
    stamp = log.index.to_numpy(dtype=float)
    number, heading, heading_std = _course(time, velocity, spread, stamp, settings)
    rest = _rest(time, velocity, spread, stamp, number, settings)
    size = NAVIGATION + len(states) + len(assumptions.constants())
    covariance = np.zeros((size, size))
    covariance[range(NAVIGATION, size), range(NAVIGATION, size)] = [
        *states.variance, *(one**2 for _, one in assumptions.constants())
    ]  # fmt: skip
    errors, sensors = np.zeros(size - NAVIGATION), slice(NAVIGATION, NAVIGATION + len(states))
    if rest is not None:
        mean = log[(stamp > rest[0]) & (stamp <= rest[1])].mean()
        rate = mean[list(GYRO)].to_numpy() - states.fixed[:3]
        errors[: len(states)], covariance[sensors, sensors] = biases_from_rest(
            rate, rest[1] - rest[0], states, covariance[sensors, sensors]
        )
        rotation, rows = _levelled(log, rest, time[number], heading, mean, errors[: len(states)], states, ellipsoid)
        tilt_std = settings.tilt_std
    else:
        rotation = _in_motion(log, time, velocity, number, heading, ellipsoid)
        rows, tilt_std = np.zeros((2, len(states))), settings.moving_tilt_std
    _fill(covariance, std[number], spread[number], rows, tilt_std, np.hypot(heading_std, settings.heading_std))
    at = np.searchsorted(stamp, time[number])
    turning = log[list(GYRO)].to_numpy()[min(at, len(log) - 1)] - errors_of(GYRO, errors[: len(states)], states)
    lever = np.array(assumptions.lever_m)
    place = seen[number, :3] - rotation.apply(lever)
    moving = velocity[number] - rotation.apply(np.cross(turning, lever))
    return InitialState(time[number], np.concatenate([place, moving, rotation.as_quat()]), errors, covariance)


def errors_of(triad: tuple[str, ...], errors: np.ndarray, states: SensorStates) -> np.ndarray:
    """Return the error of a triad by the states, without scale factors, and the fixed biases, shape (3,)."""
    first = 0 if triad == GYRO else len(GYRO)
    return np.array([
        states.fixed[axis] + errors[(states.axis == axis) & ~states.scale].sum() for axis in range(first, first + 3)
    ])  # fmt: skip


def _velocities(time: np.ndarray, seen: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities at the fixes [m/s], from the receiver or from differences, and standard deviations."""
    velocity, spread = seen[:, 3:].copy(), std[:, 3:].copy()
    for k in np.flatnonzero(np.isnan(velocity).any(axis=1)):
        before = max(int(np.searchsorted(time, time[k] - WAY_S)), 0)
        spread[k] = np.inf
        if before < k:
            velocity[k] = (seen[k, :3] - seen[before, :3]) / (time[k] - time[before])
            spread[k] = np.hypot(std[k, :3], std[before, :3]) / (time[k] - time[before])
    return velocity, spread


def _course(
    time: np.ndarray, velocity: np.ndarray, spread: np.ndarray, stamp: np.ndarray, settings: AlignmentSettings
) -> tuple[int, float, float]:
    """Return the first fix within the log with a known course, the course [rad] and its standard deviation."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        course_std = spread[:, :2].max(axis=1) / speed
        able = (course_std < settings.course_std) & (speed > settings.speed)
    able &= (time >= stamp[0]) & (time < stamp[-1])
    if not able.any():
        inside = int(np.count_nonzero((time >= stamp[0]) & (time < stamp[-1])))
        fastest = np.nanmax(speed, initial=0.0)
        raise ValueError(
            f"start: expected a fix that tells the course within {settings.course_std:g} rad; found none among the "
            f"{inside} fixes within the log, the fastest with {fastest:.2g} m/s"
        )
    number = int(np.argmax(able))
    return number, float(np.arctan2(velocity[number, 1], velocity[number, 0])), float(course_std[number])


def _rest(
    time: np.ndarray,
    velocity: np.ndarray,
    spread: np.ndarray,
    stamp: np.ndarray,
    number: int,
    settings: AlignmentSettings,
) -> tuple[float, float] | None:  # fmt: skip
    """Return begin and end of the rest before the start [s], or None if too short."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    limit = np.maximum(settings.speed, 3 * np.where(np.isfinite(spread), spread, 0).max(axis=1))
    known = time >= stamp[0]
    quick = np.flatnonzero(known & (speed > limit))
    end = (time[quick[0]] if len(quick) else time[number]) - settings.margin_s
    first = time[known][0] if known.any() else np.inf
    return (stamp[0], end) if end - max(stamp[0], first) >= settings.rest_s else None


def _levelled(
    log: pd.DataFrame, rest: tuple[float, float], until: float, heading: float, mean: pd.Series, errors: np.ndarray,
    states: SensorStates, ellipsoid: Ellipsoid,
) -> tuple[Rotation, np.ndarray]:  # fmt: skip
    """Return the attitude at the start, levelled at rest and propagated, and its sensitivity to the sensor states."""
    gravity = earth.normal_gravity(ellipsoid.latitude, ellipsoid.height)
    force = mean[list(ACCEL)].to_numpy() - states.fixed[3:]
    first = (*level(force), 0.0)
    part = log[(log.index > rest[1]) & (log.index <= until)]
    last = np.array(first)
    if len(part) > 2:
        gyro = part[list(GYRO)].to_numpy() - errors_of(GYRO, errors, states)
        steps = np.diff(part.index.to_numpy(), prepend=part.index[0] - np.median(np.diff(part.index)))
        still = np.zeros_like(gyro)
        last = navigate(gyro, still, steps, NavigationState(attitude=first), Local(0.0), len(gyro) - 1)[-1, 6:]
    turn = Rotation.from_euler("z", heading - last[2])
    rows = level_sensitivity(force, from_euler(np.array(first)).as_matrix(), states, gravity)
    return from_euler(np.array([*last[:2], heading])), turn.as_matrix()[:2, :2] @ rows


def _in_motion(
    log: pd.DataFrame, time: np.ndarray, velocity: np.ndarray, number: int, heading: float, ellipsoid: Ellipsoid
) -> Rotation:
    """Return the attitude at the start, from the specific force around it less the acceleration from the fixes."""
    near = np.flatnonzero((np.abs(time - time[number]) <= 1.5 * SPAN_S) & np.isfinite(velocity).all(axis=1))
    pull = np.zeros(3)
    if len(near) > 1:
        pull = np.polyfit(time[near] - time[number], velocity[near], 1)[0]
    part = log[(log.index > time[number] - SPAN_S) & (log.index <= time[number] + SPAN_S)]
    force = (part if len(part) else log)[list(ACCEL)].mean().to_numpy()
    return from_euler(np.array([*level(force - Rotation.from_euler("z", heading).inv().apply(pull)), heading]))


def _fill(
    covariance: np.ndarray, std: np.ndarray, spread: np.ndarray, rows: np.ndarray, tilt_std: float, heading_std: float
) -> None:
    """Fill in the covariance of position, velocity and attitude."""
    sensors = slice(NAVIGATION, NAVIGATION + rows.shape[1])
    across = rows @ covariance[sensors, sensors]
    covariance[range(VELOCITY), range(VELOCITY)] = std[:3] ** 2
    covariance[range(VELOCITY, ATTITUDE), range(VELOCITY, ATTITUDE)] = spread**2
    level_rows = slice(ATTITUDE, ATTITUDE + 2)
    covariance[level_rows, sensors], covariance[sensors, level_rows] = across, across.T
    covariance[level_rows, level_rows] = across @ rows.T + tilt_std**2 * np.eye(2)
    covariance[ATTITUDE + 2, ATTITUDE + 2] = heading_std**2
