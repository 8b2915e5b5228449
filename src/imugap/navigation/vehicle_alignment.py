"""Where a drive starts: at the first fixes that tell the course; level from the rest before, or from the motion there.

A receiver does not see the heading of a body at rest. The filter starts at the first fix whose velocity, or whose way
from the fixes before, tells the course well enough, and the vehicle is taken to point along it. If it rests until
then, the mean specific force levels it, the gyroscopes show their biases, and both are carried to the start by the
gyroscopes. If not, it is levelled by the specific force about the start less the acceleration that the fixes tell.

Source: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013,
sections 5.6.1 and 5.6.2.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from imugap.filters.alignment import calibrated, tilt
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY
from imugap.filters.sensor_states import SensorStates
from imugap.io import gnss
from imugap.kinematics import earth
from imugap.kinematics.strapdown import Ellipsoid, Local, NavigationState, level, navigate
from imugap.log import ACCEL, GYRO
from imugap.navigation.vehicle import Assumptions, Start
from imugap.numerics.rotation import from_euler

WAY_S = 3.0
"""Longest time over which two fixes tell a course [s]."""
SPAN_S = 1.0
"""Time before and after the start over which a moving vehicle is levelled [s]."""


@dataclass(frozen=True)
class Departure:
    """How a drive is made to start.

    Attributes
    ----------
    speed
        A vehicle at rest is slower than this, by its fixes [m/s].
    rest_s
        Shortest rest that levels [s].
    margin_s
        What is left out at the end of a rest [s].
    course_std
        What the course may be uncertain by, by the noise of the fixes [rad].
    heading_std
        By what the vehicle may point beside its course, added to that [rad].
    tilt_std, moving_tilt_std
        What a level may be off besides the errors of the accelerometers, at rest and in motion [rad].
    """

    speed: float = 0.5
    rest_s: float = 3.0
    margin_s: float = 1.0
    course_std: float = 0.1
    heading_std: float = 0.02
    tilt_std: float = 0.005
    moving_tilt_std: float = 0.05


def depart(
    log: pd.DataFrame, fixes: pd.DataFrame, states: SensorStates, assumptions: Assumptions, ellipsoid: Ellipsoid,
    departure: Departure | None = None,
) -> Start:  # fmt: skip
    """Return where the filter starts; a ValueError where no fix tells a course."""
    departure = departure or Departure()
    time = fixes.index.to_numpy(dtype=float) + assumptions.offset_s
    seen = gnss.local(fixes, ellipsoid)
    std = gnss.deviations(fixes, assumptions.position_std, assumptions.velocity_std)
    velocity, spread = _velocities(time, seen, std)
    stamp = log.index.to_numpy(dtype=float)
    number, heading, heading_std = _course(time, velocity, spread, stamp, departure)
    rest = _rest(time, velocity, spread, stamp, number, departure)
    size = NAVIGATION + len(states) + len(assumptions.constants())
    covariance = np.zeros((size, size))
    covariance[range(NAVIGATION, size), range(NAVIGATION, size)] = [
        *states.variance, *(one**2 for _, one in assumptions.constants())
    ]  # fmt: skip
    errors, sensors = np.zeros(size - NAVIGATION), slice(NAVIGATION, NAVIGATION + len(states))
    if rest is not None:
        mean = log[(stamp > rest[0]) & (stamp <= rest[1])].mean()
        rate = mean[list(GYRO)].to_numpy() - states.fixed[:3]
        errors[: len(states)], covariance[sensors, sensors] = calibrated(
            rate, rest[1] - rest[0], states, covariance[sensors, sensors]
        )
        rotation, rows = _levelled(log, rest, time[number], heading, mean, errors[: len(states)], states, ellipsoid)
        tilt_std = departure.tilt_std
    else:
        rotation = _in_motion(log, time, velocity, number, heading, ellipsoid)
        rows, tilt_std = np.zeros((2, len(states))), departure.moving_tilt_std
    _fill(covariance, std[number], spread[number], rows, tilt_std, np.hypot(heading_std, departure.heading_std))
    at = np.searchsorted(stamp, time[number])
    turning = log[list(GYRO)].to_numpy()[min(at, len(log) - 1)] - errors_of(GYRO, errors[: len(states)], states)
    lever = np.array(assumptions.lever_m)
    place = seen[number, :3] - rotation.apply(lever)
    moving = velocity[number] - rotation.apply(np.cross(turning, lever))
    return Start(time[number], np.concatenate([place, moving, rotation.as_quat()]), errors, covariance)


def errors_of(triad: tuple[str, ...], errors: np.ndarray, states: SensorStates) -> np.ndarray:
    """Return what the states, other than scale factors, and the fixed biases add to the axes of a triad, shape (3,)."""
    first = 0 if triad == GYRO else len(GYRO)
    return np.array([
        states.fixed[axis] + errors[(states.axis == axis) & ~states.scale].sum() for axis in range(first, first + 3)
    ])  # fmt: skip


def _velocities(time: np.ndarray, seen: np.ndarray, std: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocity at each fix [m/s], by the receiver or from the way since an earlier one, and deviations."""
    velocity, spread = seen[:, 3:].copy(), std[:, 3:].copy()
    for k in np.flatnonzero(np.isnan(velocity).any(axis=1)):
        before = max(int(np.searchsorted(time, time[k] - WAY_S)), 0)
        spread[k] = np.inf
        if before < k:
            velocity[k] = (seen[k, :3] - seen[before, :3]) / (time[k] - time[before])
            spread[k] = np.hypot(std[k, :3], std[before, :3]) / (time[k] - time[before])
    return velocity, spread


def _course(
    time: np.ndarray, velocity: np.ndarray, spread: np.ndarray, stamp: np.ndarray, departure: Departure
) -> tuple[int, float, float]:
    """Return the first fix within the log that tells the course well enough, the course [rad] and its deviation."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        course_std = spread[:, :2].max(axis=1) / speed
        able = (course_std < departure.course_std) & (speed > departure.speed)
    able &= (time >= stamp[0]) & (time < stamp[-1])
    if not able.any():
        inside = int(np.count_nonzero((time >= stamp[0]) & (time < stamp[-1])))
        fastest = np.nanmax(speed, initial=0.0)
        raise ValueError(
            f"start: expected a fix that tells the course within {departure.course_std:g} rad; found none among the "
            f"{inside} fixes within the log, the fastest with {fastest:.2g} m/s"
        )
    number = int(np.argmax(able))
    return number, float(np.arctan2(velocity[number, 1], velocity[number, 0])), float(course_std[number])


def _rest(
    time: np.ndarray, velocity: np.ndarray, spread: np.ndarray, stamp: np.ndarray, number: int, departure: Departure
) -> tuple[float, float] | None:
    """Return begin and end of the rest ahead of the start [s], or None where it is too short."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    limit = np.maximum(departure.speed, 3 * np.where(np.isfinite(spread), spread, 0).max(axis=1))
    known = time >= stamp[0]
    quick = np.flatnonzero(known & (speed > limit))
    end = (time[quick[0]] if len(quick) else time[number]) - departure.margin_s
    first = time[known][0] if known.any() else np.inf
    return (stamp[0], end) if end - max(stamp[0], first) >= departure.rest_s else None


def _levelled(
    log: pd.DataFrame, rest: tuple[float, float], until: float, heading: float, mean: pd.Series, errors: np.ndarray,
    states: SensorStates, ellipsoid: Ellipsoid,
) -> tuple[Rotation, np.ndarray]:  # fmt: skip
    """Return the attitude at the start, levelled at rest and carried on, and how the sensor states tilt it."""
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
    rows = tilt(force, from_euler(np.array(first)).as_matrix(), states, gravity)
    return from_euler(np.array([*last[:2], heading])), turn.as_matrix()[:2, :2] @ rows


def _in_motion(
    log: pd.DataFrame, time: np.ndarray, velocity: np.ndarray, number: int, heading: float, ellipsoid: Ellipsoid
) -> Rotation:
    """Return the attitude at the start, from the specific force about it less what the fixes tell of acceleration."""
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
    for first, last in pairwise((ATTITUDE, ATTITUDE + 2)):
        covariance[first:last, sensors], covariance[sensors, first:last] = across, across.T
        covariance[first:last, first:last] = across @ rows.T + tilt_std**2 * np.eye(2)
    covariance[ATTITUDE + 2, ATTITUDE + 2] = heading_std**2
