"""Initial alignment of a drive: position, velocity and course from the fixes, level from a rest or in motion.

A receiver does not observe the heading of a body at rest. The filter starts at the first fix whose velocity, or whose
displacement from earlier fixes, gives the course accurately enough; the vehicle points along it, unless velocity
matching (:mod:`imugap.navigation.drive.velocity_matching`) says that it does not. If it rests until then, the mean
specific force gives the level and the gyroscopes their biases, and the gyroscopes carry the level to the start. If
not, it is levelled by the specific force around the start, less the acceleration from the fixes. Fixes with noise show
the end of a rest late; it ends where the samples do, too.

Position and velocity at the start are those of the antenna, less the lever arm, at the time of a fix: their errors are
correlated with those of attitude, lever arm and time offset.

Source: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013,
sections 5.6.1 and 5.6.2.
"""

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from imugap.filters.alignment import biases_from_rest, level_sensitivity
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY
from imugap.filters.sensor_states import SensorStates
from imugap.integrity.rest import departure
from imugap.kinematics import earth
from imugap.kinematics.strapdown import Ellipsoid, Local, NavigationState, level, navigate
from imugap.log import ACCEL, AXES, GYRO
from imugap.navigation.drive.vehicle import (
    LEVER_ARM,
    TIME_OFFSET,
    AlignmentSettings,
    DriveAssumptions,
    DriveInputs,
    InitialState,
)
from imugap.navigation.drive.velocity_matching import MatchedAttitude, VelocityPair
from imugap.numerics.rotation import from_euler

BASELINES_S = 3.0, 6.0, 12.0
"""Longest times between the fixes before and after one whose displacement gives its velocity [s]; a longer one is taken
where a shorter one does not give the course of any fix."""
UNEVEN_M_PER_S = 0.2
"""Standard deviation of such a velocity besides the noise of the fixes, since the motion is not even [m/s]; in
proportion to the time, here for the first one."""
SPAN_S = 1.0
"""Time before and after the start over which a moving vehicle is levelled [s]."""
RETRY_S = 1.0
"""Time between two fixes that are tried as the start [s]."""
LARGEST_MISFIT = 10.0
"""Misfit of the velocity matching above which it neither confirms nor replaces the course."""
LARGEST_COURSE_STD = np.radians(45.0)
"""Standard deviation of a course from which on it is none [rad]."""
COURSE_SIGMA = 5.0
"""Heading less course, in standard deviations, above which the vehicle does not point along its course."""
FAST_QUANTILE, SLOW_SHARE = 0.9, 0.15
"""Quantile of the speeds, and the share of it below which a fix is slow."""
MATCHED_FACTOR = 4.0
"""Factor on the covariance of the velocity matching, whose residuals are not white."""
HEADING_ROUNDS = 3
"""Iterations of the course of the device."""
SMALLEST_BIAS = 1e-4
"""Smallest standard deviation of a gyroscope bias in the velocity matching [rad/s]."""


def align(inputs: DriveInputs) -> InitialState:
    """Return the initial state at the first fix with a known course; raise ValueError without one."""
    log, assumptions, ellipsoid = inputs.log, inputs.assumptions, inputs.ellipsoid
    states, settings = assumptions.states(inputs.model), inputs.alignment
    time, seen, std = inputs.measured
    stamp = log.index.to_numpy(dtype=float)
    near = np.minimum(np.searchsorted(stamp, time), len(log) - 1)
    gyro, lever = log[list(GYRO)].to_numpy()[near], np.array(assumptions.lever_m)
    swing = assumptions.lever_std * np.linalg.norm(gyro, axis=1)[:, None]
    for baseline_s in BASELINES_S:
        velocity, spread = velocities(time, seen, std, baseline_s)
        able = _with_course(time, velocity, np.hypot(spread, swing), stamp, settings)
        if len(able):
            break
    else:
        raise ValueError(_without_course(time, velocity, np.hypot(spread, swing), stamp, settings))
    number, matched = _start(velocity_pair(inputs, baseline_s), time, able, settings)
    heading = _heading(gyro[number], lever, velocity[number])
    heading_std = float(spread[number, :2].max() / np.hypot(*velocity[number, :2]))
    rest = _rest(time, velocity, spread, log, number, settings)
    size = NAVIGATION + len(states) + len(assumptions.constants())
    covariance = np.zeros((size, size))
    covariance[range(NAVIGATION, size), range(NAVIGATION, size)] = [
        *states.variance, *(one**2 for _, one in assumptions.constants())
    ]  # fmt: skip
    errors, sensors = np.zeros(size - NAVIGATION), slice(NAVIGATION, NAVIGATION + len(states))
    rows, tilt_std = np.zeros((2, len(states))), settings.moving_tilt_std
    if rest is not None:
        mean = log[(stamp > rest[0]) & (stamp <= rest[1])].mean()
        rate = mean[list(GYRO)].to_numpy() - states.fixed[:3]
        errors[: len(states)], covariance[sensors, sensors] = biases_from_rest(
            rate, rest[1] - rest[0], states, covariance[sensors, sensors]
        )
    if matched is not None:
        rotation = matched.rotation
    elif rest is not None:
        rotation, rows = _levelled(log, rest, time[number], heading, mean, errors[: len(states)], states, ellipsoid)
        tilt_std = settings.tilt_std
    else:
        rotation = _in_motion(log, time, velocity, number, heading, ellipsoid)
    _fill(covariance, std[number], spread[number], rows, tilt_std, np.hypot(heading_std, settings.heading_std))
    if matched is not None:
        covariance[ATTITUDE:NAVIGATION, ATTITUDE:NAVIGATION] = MATCHED_FACTOR * matched.covariance
    turning = gyro[number] - errors_of(GYRO, errors[: len(states)], states)
    place = seen[number, :3] - rotation.apply(lever)
    moving = velocity[number] - rotation.apply(np.cross(turning, lever))
    pull, by_course = _pull(time, velocity, number), matched is None
    inherited = _slow_errors(states, size)
    _correlate(covariance, rotation.as_matrix(), turning, moving, pull, assumptions, by_course, inherited)
    return InitialState(time[number], np.concatenate([place, moving, rotation.as_quat()]), errors, covariance)


def _heading(rate: np.ndarray, lever: np.ndarray, velocity: np.ndarray) -> float:
    """Return the course of the device [rad], without the motion of the antenna around it on a level road."""
    heading, swing = float(np.arctan2(velocity[1], velocity[0])), np.cross(rate, lever)
    for _ in range(HEADING_ROUNDS):
        north, east = velocity[:2] - Rotation.from_euler("z", heading).apply(swing)[:2]
        heading = float(np.arctan2(east, north))
    return heading


def velocity_pair(inputs: DriveInputs, baseline_s: float = BASELINES_S[0]) -> VelocityPair:
    """Return the samples, and the velocities of the fixes on the clock of the device (:func:`velocities`)."""
    log, states = inputs.log, inputs.assumptions.states(inputs.model)
    time, seen, std = inputs.measured
    velocity, spread = velocities(time, seen, std, baseline_s)
    biases = states.variance[(states.axis < len(GYRO)) & ~states.scale]
    return VelocityPair(
        log.index.to_numpy(dtype=float), log[list(AXES)].to_numpy(dtype=float) - states.fixed, time, velocity, spread,
        earth.normal_gravity(inputs.ellipsoid.latitude, inputs.ellipsoid.height),
        max(float(np.sqrt(biases.max(initial=0.0))), SMALLEST_BIAS),
    )  # fmt: skip


def errors_of(triad: tuple[str, ...], errors: np.ndarray, states: SensorStates) -> np.ndarray:
    """Return the error of a triad by the states, without scale factors, and the fixed biases, shape (3,)."""
    first = 0 if triad == GYRO else len(GYRO)
    return np.array([
        states.fixed[axis] + errors[(states.axis == axis) & ~states.scale].sum() for axis in range(first, first + 3)
    ])  # fmt: skip


def velocities(
    time: np.ndarray, seen: np.ndarray, std: np.ndarray, baseline_s: float = BASELINES_S[0]
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Return velocities at the fixes [m/s] and standard deviations, a component from the receiver or from differences.

    A difference is over at most the time ``baseline_s`` [s].
    """
    velocity, spread = seen[:, 3:].copy(), std[:, 3:].copy()
    first, last = (
        np.searchsorted(time, time - baseline_s / 2),
        np.searchsorted(time, time + baseline_s / 2, "right") - 1,
    )
    unknown = np.isnan(velocity)
    spread[unknown] = np.inf
    for k in np.flatnonzero(unknown.any(axis=1)):
        lacks, before, after = unknown[k], first[k], last[k]
        if before < k < after:
            span = time[after] - time[before]
            velocity[k, lacks] = ((seen[after, :3] - seen[before, :3]) / span)[lacks]
            noise = np.hypot(std[after, :3], std[before, :3]) / span
            spread[k, lacks] = np.hypot(noise, UNEVEN_M_PER_S * baseline_s / BASELINES_S[0])[lacks]
    return velocity, spread


def _with_course(
    time: np.ndarray, velocity: np.ndarray, spread: np.ndarray, stamp: np.ndarray, settings: AlignmentSettings
) -> np.ndarray:
    """Return the numbers of the fixes within the log with a known course."""
    speed, course_std = _courses(velocity, spread)
    able = (course_std < settings.course_std) & (speed > settings.speed) & np.isfinite(velocity).all(axis=1)
    return np.flatnonzero(able & _inside(time, stamp))


def _courses(velocity: np.ndarray, spread: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the horizontal speeds of the fixes [m/s], and the standard deviations of their courses [rad]."""
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    with np.errstate(invalid="ignore", divide="ignore"):
        return speed, spread[:, :2].max(axis=1) / speed


def _inside(time: np.ndarray, stamp: np.ndarray) -> np.ndarray:
    """Return which fixes are within the log."""
    return (time >= stamp[0]) & (time < stamp[-1])


def _without_course(
    time: np.ndarray, velocity: np.ndarray, spread: np.ndarray, stamp: np.ndarray, settings: AlignmentSettings
) -> str:  # fmt: skip
    """Return the message on a drive of which no fix has a known course, with the setting that takes the best one."""
    inside = _inside(time, stamp)
    speed, course_std = (np.where(inside, one, np.nan) for one in _courses(velocity, spread))
    fastest, best = np.nanmax(speed, initial=0.0), np.nanmin(course_std, initial=np.inf)
    found = (
        f"start: expected a fix that tells the course within {np.degrees(settings.course_std):.2g} deg; found none "
        f"among the {np.count_nonzero(inside)} fixes within the log, the fastest with {fastest:.2g} m/s"
    )
    if fastest <= settings.speed:
        return f"{found}: a vehicle at rest shows none, unless it is slow (start: {{speed_m_per_s: {fastest / 2:.1g}}})"
    if best > LARGEST_COURSE_STD:
        return f"{found}: the noise of the fixes hides every course (receiver: {{horizontal_m, horizontal_m_per_s}})"
    degrees = np.ceil(np.degrees(best) + 0.5)
    return f"{found}; start: {{course_std_deg: {degrees:.0f}}} takes the best one"


def _start(
    pair: VelocityPair, time: np.ndarray, able: np.ndarray, settings: AlignmentSettings
) -> tuple[int, MatchedAttitude | None]:  # fmt: skip
    """Return the fix of the start, and its attitude by velocity matching where the course is not the heading.

    The changes of velocity around a fix confirm that the vehicle points along its course, or give the attitude. A fix
    where they do neither is taken if it is not slow against the rest of the drive; a receiver that converges at rest
    reports a slow motion. Where no fix is taken, it is the first.
    """
    speed = np.hypot(pair.velocity[:, 0], pair.velocity[:, 1])
    usual, last = SLOW_SHARE * np.quantile(speed[able], FAST_QUANTILE), -np.inf
    for number in able:
        if pair.time[number] < last + RETRY_S:
            continue
        last, matched = pair.time[number], pair.match(pair.time[number])
        if matched is None or not matched.heading_std < settings.course_std or matched.misfit > LARGEST_MISFIT:
            if speed[number] >= usual:
                return int(number), None
            continue
        course = np.arctan2(pair.velocity[number, 1], pair.velocity[number, 0])
        apart = abs(np.remainder(matched.heading - course + np.pi, 2 * np.pi) - np.pi)
        course_std = pair.std[number, :2].max() / speed[number]
        limit = COURSE_SIGMA * np.hypot(matched.heading_std, np.hypot(course_std, settings.heading_std))
        return int(number), pair.match(time[number]) if apart > limit else None
    return int(able[0]), None


def _rest(
    time: np.ndarray,
    velocity: np.ndarray,
    spread: np.ndarray,
    log: pd.DataFrame,
    number: int,
    settings: AlignmentSettings,
) -> tuple[float, float] | None:  # fmt: skip
    """Return begin and end of the rest before the start [s], or None if too short."""
    stamp, speed = log.index.to_numpy(dtype=float), np.hypot(velocity[:, 0], velocity[:, 1])
    limit = np.maximum(settings.speed, 3 * np.where(np.isfinite(spread), spread, 0).max(axis=1))
    known = time >= stamp[0]
    quick = np.flatnonzero(known & (speed > limit))
    end = time[quick[0]] if len(quick) else time[number]
    end = min(end, departure(log[stamp <= end])) - settings.margin_s
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
    pull = _pull(time, velocity, number)
    part = log[(log.index > time[number] - SPAN_S) & (log.index <= time[number] + SPAN_S)]
    force = (part if len(part) else log)[list(ACCEL)].mean().to_numpy()
    return from_euler(np.array([*level(force - Rotation.from_euler("z", heading).inv().apply(pull)), heading]))


def _pull(time: np.ndarray, velocity: np.ndarray, number: int) -> np.ndarray:
    """Return the acceleration around a fix from the velocities [m/s^2], zero where they are too few."""
    near = np.flatnonzero((np.abs(time - time[number]) <= 1.5 * SPAN_S) & np.isfinite(velocity).all(axis=1))
    return np.polyfit(time[near] - time[number], velocity[near], 1)[0] if len(near) > 1 else np.zeros(3)


def _correlate(
    covariance: np.ndarray, mat_nb: np.ndarray, rate: np.ndarray, velocity: np.ndarray, pull: np.ndarray,
    assumptions: DriveAssumptions, by_course: bool, inherited: np.ndarray,
) -> None:  # fmt: skip
    """Add to the covariance what position and velocity inherit from the attitude, the lever arm and the time offset.

    The start takes them from the antenna at the time of a fix, so that their errors are those of the fix, less the
    errors of the lever arm (turned by that of the attitude), and less the motion over that of the time offset. A
    heading ``by_course`` inherits the velocity of the antenna around the device. ``inherited`` holds what position
    inherits from the receiver, shape (states, states).
    """
    size, lever = len(covariance), np.array(assumptions.lever_m)
    rows = assumptions.rows(size - NAVIGATION - len(assumptions.constants()))
    arms = [rows[name] for name in LEVER_ARM if name in rows]
    for block, arm, reach in (
        (slice(0, VELOCITY), lever, np.eye(3)),
        (slice(VELOCITY, ATTITUDE), np.cross(rate, lever), cross_matrix(rate)),
    ):
        inherited[block, ATTITUDE:NAVIGATION] = cross_matrix(mat_nb @ arm)
        if arms:
            inherited[block, arms] = -mat_nb @ reach
    if TIME_OFFSET in rows:
        delay = rows[TIME_OFFSET]
        inherited[:VELOCITY, delay], inherited[VELOCITY:ATTITUDE, delay] = -velocity, -pull
    if arms and by_course:
        turned = np.eye(size)
        swing = np.array([-velocity[1], velocity[0], 0.0]) / np.hypot(velocity[0], velocity[1]) ** 2
        turned[NAVIGATION - 1, arms] = -swing @ mat_nb @ cross_matrix(rate)
        inherited = inherited @ turned
    covariance[:] = inherited @ covariance @ inherited.T


def _slow_errors(states: SensorStates, size: int) -> np.ndarray:
    """Return what the position inherits from the slow errors of the receiver, which its fix has; shape (size, size)."""
    inherited = np.eye(size)
    for number in np.flatnonzero(states.axis >= len(AXES)):
        inherited[states.axis[number] - len(AXES), NAVIGATION + number] = -1.0
    return inherited


def cross_matrix(vector: np.ndarray) -> np.ndarray:
    """Return the matrix of the cross product by a vector from the left, shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


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
