"""GNSS/INS: strapdown navigation on the WGS-84 ellipsoid with an error-state filter, loosely coupled.

A fix measures position and, if the receiver provides it, velocity of its antenna. The states are position, velocity,
attitude, those of the sensors (21 in all for a Gauss-Markov bias and a scale factor of each axis) and, optionally, slow
errors of the position of the receiver, the lever arm and the time offset of the fixes.
:mod:`imugap.filters.innovation_gate` tests the fixes.

An epoch ends after a fixed number of samples and at every fix (:mod:`imugap.filters.epochs`); nonholonomic constraints
are applied at its end (:mod:`imugap.filters.nonholonomic`). The navigation equations are integrated sample by sample in
full; the covariance is predicted by epochs with the means of attitude, specific force and rate. Its transition neglects
Earth rate and transport rate (:mod:`imugap.filters.error_state`), which turn an error by 5 mrad per minute.

The smoother feeds back at every fix, whatever the gates: it uses all fixes at once.

Sources: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013,
sections 14.1 and 14.3 (lever arm: eqs. 14.111 to 14.113); G. J. Bierman, Fixed interval smoothing with discrete
measurements, Int. J. Control 18 (1973) 65-75; G. P. Huang, A. I. Mourikis, S. I. Roumeliotis, Observability-based rules
for designing consistent EKF SLAM estimators, Int. J. Robot. Res. 29 (2010) 502-528.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from imugap.filters.epochs import STAMP_TOLERANCE_S, Epochs
from imugap.filters.error_state import ATTITUDE, NAVIGATION, innovation_variance, predict, transposed_transition
from imugap.filters.innovation_gate import (
    ACCEPTED,
    EXCLUDED,
    HELD,
    RESET_SIGMA,
    RESTARTED,
    InnovationRecord,
    KernelControl,
    QualityControl,
    chi_square,
    noise_after_test,
)
from imugap.filters.nonholonomic import CONSTRAINTS, WheelConstraint, apply_wheel_constraint, quiet_epochs
from imugap.filters.sensor_states import RECEIVER, SensorStates
from imugap.filters.smoother import (
    History,
    NavigationSolution,
    SensorArrays,
    SmootherBlock,
    apply_measurement,
    compensate,
    discretise_states,
    run_filter,
    run_smoother,
    write_epoch,
)
from imugap.filters.solution_separation import (
    EVENT_OPENED,
    EVENT_SEPARATED,
    OFFSET_STATES,
    OPEN,
    POSITION_OFFSETS,
    REJECTIONS,
    SUB_FILTERS,
    UNKNOWN_VARIANCE,
    WALK_RATE,
    FilterState,
    classify_position,
    copy_matrix,
    member,
    restart_offset,
    separate_solutions,
    start_sub_filter,
    unpack_navigation,
    update_velocity_statistics,
    velocity_inflation,
)  # fmt: skip
from imugap.io import gnss
from imugap.io.gnss import COMPONENTS
from imugap.kinematics.strapdown import GEODETIC, Ellipsoid, ellipsoid_step, increments
from imugap.log import AXES, TIME, LogError, axes
from imugap.model import ErrorModel
from imugap.navigation.drive.due_fixes import DueFixes
from imugap.numerics.rotation import add_scaled, cross, dot, kernel, mat_from_quat, rotate

FACTOR_OF = [0, 0, 1, 2, 2, 3]
"""Number of the factor on the standard deviation of each component of a fix."""
LEVER_ARM = ("lever_x", "lever_y", "lever_z")
"""Error of the assumed lever arm, from the device to the antenna in ``b`` [m]."""
TIME_OFFSET = "offset"
"""Delay of the fixes beyond the assumed time offset [s]."""
FIX = len(COMPONENTS)
"""Number of measurements of a fix."""
FIRST_RECEIVER = len(AXES)
"""Number of the first axis of the receiver."""
SOURCES = len(AXES) + len(RECEIVER)
"""Number of the axes of the device and of the receiver that may have states."""
FARTHEST_M = 1e9
"""Largest distance of a path from its origin [m], and magnitude of a velocity [m/s]."""
NOISE_SIGMA = 4.0
"""Rates up to this number of standard deviations of the noise of a sample do not observe the lever arm."""


@dataclass(frozen=True)
class DriveAssumptions:
    """Assumptions of the filter besides the error model.

    Attributes
    ----------
    lever_m
        Lever arm from the device to the antenna, in ``b`` [m].
    lever_std
        Its standard deviation, each axis [m]; 0: not a state.
    time_offset_s
        Time of the log minus stamp of the fix [s].
    time_offset_std
        Its standard deviation [s]; 0: not a state.
    velocity_delay_s
        Time of a position less that at which the velocity of the same fix is true [s].
    clock_rate
        By which share the intervals of the samples were made longer, for a clock slower than that of the fixes.
    scale_std
        Standard deviations of the scale factors of gyroscopes and accelerometers; 0: not a state.
    scale_s
        Correlation time of the scale factors [s].
    position_std, velocity_std
        Standard deviations of a fix, north, east, down [m] and [m/s], where the log gives none.
    std_factors
        Factors on the standard deviations of a fix, whoever gives them: of position across and down, of velocity across
        and down.
    slow_position_std
        Standard deviations of slow errors of its position besides, north, east, down [m]; 0: not a state.
    slow_position_s
        Their correlation time [s].
    epoch_s
        Longest epoch of the covariance [s].
    nonholonomic_std
        Standard deviation of the velocity of the rear axle across and up [m/s] (:mod:`imugap.filters.nonholonomic`); 0
        for no constraint.
    nonholonomic_s
        Its correlation time [s].
    axle_m
        From the device to the middle of the rear axle, in ``b`` [m].
    """

    lever_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lever_std: float = 0.0
    time_offset_s: float = 0.0
    time_offset_std: float = 0.0
    velocity_delay_s: float = 0.0
    clock_rate: float = 0.0
    scale_std: tuple[float, float] = (2e-3, 2e-3)
    scale_s: float = np.inf
    position_std: tuple[float, float, float] = (1.5, 1.5, 3.0)
    slow_position_std: tuple[float, float, float] = (0.0, 0.0, 0.0)
    slow_position_s: float = 60.0
    velocity_std: tuple[float, float, float] = (0.1, 0.1, 0.2)
    std_factors: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    epoch_s: float = 0.05
    nonholonomic_std: float = 0.0
    nonholonomic_s: float = 2.0
    axle_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def states(self, model: ErrorModel) -> SensorStates:
        """Return the states of the sensors under ``model``, and those of the receiver."""
        return SensorStates.of(model, self.scale_std, self.scale_s).with_receiver(
            self.slow_position_std, self.slow_position_s
        )

    def constants(self) -> list[tuple[str, float]]:
        """Return names and standard deviations of the states behind those of the sensors."""
        lever = [(name, self.lever_std) for name in LEVER_ARM if self.lever_std > 0]
        return lever + ([(TIME_OFFSET, self.time_offset_std)] if self.time_offset_std > 0 else [])

    def rows(self, sensors: int) -> dict[str, int]:
        """Return the row of each of :meth:`constants`, by name, behind ``sensors`` states of the sensors."""
        return {name: NAVIGATION + sensors + number for number, (name, _) in enumerate(self.constants())}


@dataclass(frozen=True)
class AlignmentSettings:
    """Settings of the initial alignment (:mod:`imugap.navigation.drive.vehicle_alignment`).

    Attributes
    ----------
    speed
        Largest speed of a vehicle at rest, by its fixes [m/s].
    rest_s
        Shortest rest that levels [s].
    margin_s
        Time that is left out at the end of a rest [s].
    course_std
        Largest standard deviation of the course from the fixes [rad].
    heading_std
        Standard deviation of the heading minus the course, in addition [rad].
    tilt_std, moving_tilt_std
        Standard deviation of the level without the accelerometer errors, at rest and in motion [rad].
    """

    speed: float = 0.5
    rest_s: float = 3.0
    margin_s: float = 1.0
    course_std: float = 0.1
    heading_std: float = 0.02
    tilt_std: float = 0.005
    moving_tilt_std: float = 0.05


@dataclass(frozen=True, eq=False)
class DriveInputs:
    """Inputs of the filter for a drive.

    Attributes
    ----------
    log
        Log of six axes; a sample is the mean over the interval that it ends.
    fixes
        Log of a receiver (:mod:`imugap.io.gnss`); fixes outside the navigated time are left out.
    model
        Error model of the sensors, from which the filter takes states and noise densities.
    assumptions, quality, alignment
        Assumptions besides the error model; settings of the quality control and of the initial alignment.
    ellipsoid
        Ellipsoid with the origin of the positions.
    """

    log: pd.DataFrame
    fixes: pd.DataFrame
    model: ErrorModel
    ellipsoid: Ellipsoid
    assumptions: DriveAssumptions = field(default_factory=DriveAssumptions)
    quality: QualityControl = field(default_factory=QualityControl)
    alignment: AlignmentSettings = field(default_factory=AlignmentSettings)

    @cached_property
    def measured(self) -> DueFixes:
        """Fixes on the clock of the log."""
        known = self.assumptions
        std = gnss.deviations(self.fixes, known.position_std, known.velocity_std)
        std *= np.array(known.std_factors)[FACTOR_OF]
        seen, time = gnss.local(self.fixes, self.ellipsoid), self.fixes.index.to_numpy(dtype=float)
        return DueFixes(time + known.time_offset_s, seen, std).with_timely_positions(known.velocity_delay_s)


@dataclass(frozen=True, eq=False)
class InitialState:
    """Initial state of a drive.

    Attributes
    ----------
    time
        Stamp [s], in the time of the log.
    navigation
        Position from the origin [m], velocity [m/s] and quaternion ``quat_nb``, shape (10,).
    errors
        Estimates of the states behind the navigation, shape (states - 9,).
    covariance
        Shape (states, states).
    """

    time: float
    navigation: np.ndarray
    errors: np.ndarray
    covariance: np.ndarray


@dataclass(frozen=True, eq=False)
class DriveSolution(NavigationSolution):
    """Solution of the filter or the smoother for a drive; rows are the epochs.

    Attributes
    ----------
    ellipsoid
        Ellipsoid with the origin of the positions.
    fix_time
        Stamps of the fixes in use, as in their log [s], shape (fixes,).
    fix_row
        Epoch of each, shape (fixes,).
    record
        Innovations and decisions of the quality control.
    covariances
        Filter covariance after each fix, shape (fixes, states, states).
    quality
        Settings of the quality control.
    """

    ellipsoid: Ellipsoid
    fix_time: np.ndarray
    fix_row: np.ndarray
    record: InnovationRecord
    covariances: np.ndarray
    quality: QualityControl

    @cached_property
    def geodetic(self) -> pd.DataFrame:
        """Latitude, longitude [rad] and height [m]."""
        place = self.ellipsoid.geodetic(self.history.navigation[:, :3])
        return pd.DataFrame(place, index=self.time, columns=list(GEODETIC))

    @cached_property
    def events(self) -> pd.DataFrame:
        """Events of the quality control (:meth:`imugap.filters.innovation_gate.InnovationRecord.events`)."""
        return self.record.events(self.fix_time, COMPONENTS, self.quality)


class _Measurements(NamedTuple):
    """Samples, shape (n, 6), their stamps [s], fixes and their standard deviations, shape (fixes, 6)."""

    samples: np.ndarray
    stamp: np.ndarray
    seen: np.ndarray
    std: np.ndarray


class _Frame(NamedTuple):
    """Constants: origin of the ellipsoid, lever arm, rows of the optional states, initial variances, constraint.

    ``lever_arm_row``, ``time_offset_row``: row of its first state, 0 where it is not a state. ``known``: the use of
    each position is known from an earlier pass. ``rate_noise``: limit of the noise of a sample of each gyroscope
    [rad/s].
    """

    origin: tuple[float, float, float, float]
    lever: tuple[float, float, float]
    lever_arm_row: int
    time_offset_row: int
    position_offset_state: bool
    known: bool
    variance: np.ndarray
    wheels: WheelConstraint
    rate_noise: tuple[float, float, float]


class _Room(NamedTuple):
    """Workspaces of the filter."""

    work: np.ndarray
    shift: np.ndarray
    sensitivity: np.ndarray
    mean: np.ndarray
    decay_factor: np.ndarray
    driving_variance: np.ndarray
    now: np.ndarray
    before: np.ndarray
    rows: np.ndarray
    cross_covariance: np.ndarray
    gain: np.ndarray
    row: np.ndarray
    present: np.ndarray
    innovation: np.ndarray
    noise: np.ndarray
    variance: np.ndarray
    factor: np.ndarray
    whitened: np.ndarray
    nothing: np.ndarray

    @classmethod
    def of(cls, size: int, states: int) -> "_Room":
        """Allocate workspaces for ``size`` states, of which ``states`` are of the sensors."""
        vectors = (np.ones(states) for _ in range(4))
        axes, components = (np.empty(SOURCES) for _ in range(2)), (np.empty(6) for _ in range(2))
        return cls(
            np.empty((size, size)), np.empty((SOURCES, size)), *vectors, *axes, np.empty((6, size)), np.empty(size),
            np.empty(size), np.zeros(size), np.empty(6, np.int64), *components, np.empty((6, 6)), np.empty((6, 6)),
            np.empty(6), np.empty((0, 0)),
        )  # fmt: skip


@kernel
def _beyond_noise(rate, limit):
    """Return the rate with zero for components within the noise, which would seem to observe the lever arm."""
    return (
        rate[0] if abs(rate[0]) > limit[0] else 0.0,
        rate[1] if abs(rate[1]) > limit[1] else 0.0,
        rate[2] if abs(rate[2]) > limit[2] else 0.0,
    )


@kernel
def _predicted(i, nav, rate, acceleration, errors, sensors, sensitivity, frame, row):
    """Return the predicted component ``i`` of a fix, and store its derivative by the states in ``row``."""
    mat = mat_from_quat(nav[2])
    axes, lever, delay = mat[i % 3], frame.lever, 0.0
    if frame.lever_arm_row:
        first = frame.lever_arm_row - NAVIGATION
        lever = add_scaled(lever, 1.0, (errors[first], errors[first + 1], errors[first + 2]))
    if frame.time_offset_row:
        delay = errors[frame.time_offset_row - NAVIGATION]
    for j in range(len(row)):
        row[j] = 0.0
    row[i] = 1.0
    arm, moving = (lever, nav[1]) if i < 3 else (cross(rate, lever), acceleration)
    u = dot(mat[0], arm), dot(mat[1], arm), dot(mat[2], arm)
    a, b, c = i % 3, (i + 1) % 3, (i + 2) % 3
    row[ATTITUDE + b], row[ATTITUDE + c] = u[c], -u[b]
    if i >= 3:
        shift = cross(axes, lever)
        for s in range(len(sensors.axis)):
            if sensors.axis[s] < 3:
                row[NAVIGATION + s] = sensitivity[s] * shift[sensors.axis[s]]
    if frame.lever_arm_row:
        reach = axes if i < 3 else cross(axes, _beyond_noise(rate, frame.rate_noise))
        for m in range(3):
            row[frame.lever_arm_row + m] = reach[m]
    if frame.time_offset_row:
        row[frame.time_offset_row] = moving[a]
    own = nav[0][a] if i < 3 else nav[1][a]
    if i < 3:
        for s in range(len(sensors.axis)):
            if sensors.axis[s] == FIRST_RECEIVER + i:
                row[NAVIGATION + s] = 1.0
                own += errors[s]
    if frame.position_offset_state and i < 3:
        row[len(row) - OFFSET_STATES + i] = 1.0
        own += errors[len(errors) - OFFSET_STATES + i]
    return own + u[a] + delay * moving[a]


@kernel
def _hold_antenna(covariance, turn, first, transposed):
    """Move the error of the lever arm to the antenna of a corrected attitude, and so in the ``transposed`` transition.

    The antenna is where it was before the correction, for any arm. Without this every correction of the level
    would seem to observe an arm that the motion does not (Huang, Mourikis and Roumeliotis 2010). ``turn`` is the change
    of the attitude matrix, ``first`` the first row of the arm; ``transposed`` may be empty.
    """
    for i in range(3):
        for m in range(3):
            for j in range(len(covariance)):
                covariance[i, j] -= turn[i, m] * covariance[first + m, j]
    for i in range(3):
        for m in range(3):
            for j in range(len(covariance)):
                covariance[j, i] -= turn[i, m] * covariance[j, first + m]
    for m in range(3):
        for i in range(3):
            for j in range(len(transposed)):
                transposed[first + m, j] -= turn[i, m] * transposed[i, j]


@kernel
def _soft_reset(covariance, errors, control, seen, variance, transposed):
    """Inflate the covariance, and restart sensor-error estimates that are out of proportion.

    ``seen`` are the innovations, NaN for a missing one; ``transposed`` is the transition of the epoch, unless empty.
    """
    for i in range(NAVIGATION):
        std = control.reset_std[i // 3]
        if i < len(seen) and not np.isnan(seen[i]):
            std = max(std, abs(seen[i]))
        covariance[i, i] += std * std
    for s in range(len(errors)):
        i = NAVIGATION + s
        if errors[s] * errors[s] > RESET_SIGMA * RESET_SIGMA * variance[s] > 0.0:
            errors[s] = 0.0
            for j in range(len(covariance)):
                covariance[i, j] = covariance[j, i] = 0.0
            for j in range(len(transposed)):
                transposed[j, i] = 0.0
        covariance[i, i] += variance[s]


@kernel
def _innovations(inputs, fix, nav, rate, acceleration, covariance, errors, sensors, sensitivity, frame, room, multiple):
    """Store the innovations of the components of a fix, and their covariance; return the number of components.

    The variances of the velocities are multiplied by ``multiple``.
    """
    count = 0
    for i in range(6):
        if not np.isnan(inputs.seen[fix, i]):
            expected = _predicted(i, nav, rate, acceleration, errors, sensors, sensitivity, frame, room.rows[count])
            room.present[count], room.innovation[count] = i, expected - inputs.seen[fix, i]
            room.noise[count] = inputs.std[fix, i] * inputs.std[fix, i] * (1.0 if i < 3 else multiple)
            count += 1
    for i in range(count):
        innovation_variance(covariance, room.rows[i], 0.0, room.cross_covariance)
        for j in range(count):
            room.variance[i, j] = room.noise[i] if i == j else 0.0
            for m in range(len(covariance)):
                room.variance[i, j] += room.rows[j, m] * room.cross_covariance[m]
    return count


@kernel
def _global_test(fix, count, limit, room, record):
    """Apply the global test to a fix, and record it."""
    statistic, log_det = chi_square(room.innovation, room.variance, count, room.factor, room.whitened)
    for i in range(count):
        number = room.present[i]
        record.innovation[fix, number], record.variance[fix, number] = room.innovation[i], room.variance[i, i]
        record.whitened[fix, i] = room.whitened[i]
    record.statistic[fix], record.log_det[fix], record.freedom[fix] = statistic, log_det, count
    record.passed[fix] = statistic <= limit
    return statistic <= limit


@kernel
def _update_by_fix(fix, count, use, fed, nav, covariance, errors, control, room, record, block, slot):
    """Apply the component test to a fix and update by the remaining components; return the corrected navigation.

    An excluded fix is left out, and so is the velocity of a fix that restarts the offset.
    """
    for i in range(count):
        trusted = np.inf
        if use != EXCLUDED and (use != RESTARTED or room.present[i] < OFFSET_STATES):
            trusted = noise_after_test(room.innovation[i], room.variance[i, i], room.noise[i], control.component,
                                       control.robust, control.steepness)  # fmt: skip
        record.share[fix, room.present[i]] = room.noise[i] / trusted
        room.noise[i] = trusted
    for i in range(count):
        if room.noise[i] < np.inf:
            residual = room.innovation[i]
            nav, _ = apply_measurement(covariance, errors, room.rows[i], residual, room.noise[i], room.cross_covariance,
                                       room.gain, nav, block, slot, i, fed)  # fmt: skip
            for j in range(i + 1, count):
                for m in range(len(room.gain)):
                    room.innovation[j] -= room.rows[j, m] * room.gain[m] * residual
    return nav


@kernel
def _propagate(inputs, k, time, target, nav, errors, sensors, frame, room):
    """Integrate to ``target``; return the navigation, mean attitude and specific force, next sample, and rate.

    Stores the mean error of the axis per unit of each sensor state in ``room.mean``.
    """
    stamp, states = inputs.stamp, len(sensors.axis)
    c0, c1, c2, force = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    gyro, part = (0.0, 0.0, 0.0), 1 / (target - time)
    for s in range(states):
        room.mean[s] = 0.0
    while time < target:
        compensate(inputs.samples, k, sensors.axis, sensors.scale, sensors.fixed, errors, room.sensitivity, room.now,
                   room.before)  # fmt: skip
        end, now, before = min(stamp[k], target), room.now, room.before
        gyro, accel, dt = (now[0], now[1], now[2]), (now[3], now[4], now[5]), end - time
        if time == stamp[k - 1] and k > 1:
            gyro_before, accel_before = (before[0], before[1], before[2]), (before[3], before[4], before[5])
            rotvec, delta_v = increments(gyro, accel, gyro_before, accel_before, dt, stamp[k - 1] - stamp[k - 2])
        else:
            rotvec, delta_v = increments(gyro, accel, gyro, accel, dt, dt)
        mat, share = mat_from_quat(nav[2]), part * dt
        c0, c1, c2 = add_scaled(c0, share, mat[0]), add_scaled(c1, share, mat[1]), add_scaled(c2, share, mat[2])
        force = add_scaled(force, part, rotate(nav[2], delta_v))
        for s in range(states):
            room.mean[s] += share * room.sensitivity[s]
        nav = ellipsoid_step(nav[0], nav[1], nav[2], rotvec, delta_v, dt, frame.origin)
        time = end
        if end == stamp[k]:
            k += 1
    return nav, (c0, c1, c2), force, k, gyro


@njit(cache=True, error_model="numpy", forceinline=True)
def _process_fix(
    inputs, fix, slot, time, nav, rate, acceleration, sensors, frame, control, sub_filter, state, record, room, block
):
    """Test a fix and update by it; return the corrected navigation."""
    errors, covariance, counters, multiple = state.errors, state.covariance, state.counters, velocity_inflation(state)
    count = _innovations(
        inputs, fix, nav, rate, acceleration, covariance, errors, sensors, room.sensitivity, frame, room, multiple
    )
    passed = _global_test(fix, count, control.limits[count], room, record)
    use, over = ACCEPTED, False
    if frame.known:
        use, reset = record.position_use[fix], record.reset[fix]
        over = counters[OPEN] and use == ACCEPTED
        counters[OPEN] = use >= RESTARTED or (use == EXCLUDED and counters[OPEN])
    else:
        if frame.position_offset_state:
            use = classify_position(fix, count, control.limits, room, record, counters)
        state.clock[1] = np.inf if passed and not counters[OPEN] else min(state.clock[1], time)
        reset = not sub_filter and time - state.clock[1] > control.reset_s
    dropped = block.transposed[slot] if len(block.rows) > 0 else room.nothing
    if reset:
        record.offset_event[fix] = 0
        for i in range(OFFSET_STATES if frame.position_offset_state else 0):
            record.innovation[fix, i] -= errors[len(errors) - OFFSET_STATES + i]
        _soft_reset(covariance, errors, control, record.innovation[fix], frame.variance, dropped)
        record.reset[fix], state.clock[1], counters[OPEN] = True, np.inf, 0
        passed, over, use = True, True, ACCEPTED
    if over or use == RESTARTED:
        if frame.position_offset_state:
            restart_offset(covariance, errors, 0.0 if over else UNKNOWN_VARIANCE, dropped)
            state.offset[WALK_RATE] = 0.0
        multiple = 1.0
        count = _innovations(
            inputs, fix, nav, rate, acceleration, covariance, errors, sensors, room.sensitivity, frame, room, multiple
        )
    record.position_use[fix] = RESTARTED if use == HELD and state.offset[WALK_RATE] > 0.0 else use
    update_velocity_statistics(count, use == RESTARTED, multiple, room, state)
    fed = passed or not control.gated
    use = HELD if frame.known and use == RESTARTED else use
    return _update_by_fix(fix, count, use, fed, nav, covariance, errors, control, room, record, block, slot)


@njit(cache=True, error_model="numpy")
def _filter_member(
    inputs, epochs, first, last, sensors, frame, control, sub_filter, state, history, record, kept, room, block
):
    """Run one filter over epochs; see :func:`_filter_members`. A ``sub_filter`` has no soft reset."""
    errors, covariance, stored = state.errors, state.covariance, len(block.rows) > 0
    nav, k, time, step = unpack_navigation(state.navigation), state.sample[0], state.clock[0], 0.0
    for e in range(first, last):
        slot, fix, velocity, interval = e - first, epochs.fix[e], nav[1], epochs.end[e] - time
        nav, mat, force, k, rate = _propagate(inputs, k, time, epochs.end[e], nav, errors, sensors, frame, room)
        time = epochs.end[e]
        if interval != step:
            discretise_states(sensors.decay, sensors.driving, interval, room.decay_factor, room.driving_variance)
            step = interval
        if stored:
            transposed_transition(block.transposed[slot], room.work, mat, force, interval, sensors.axis, room.mean,
                                  room.decay_factor, room.shift)  # fmt: skip
        if frame.lever_arm_row:
            dropped = block.transposed[slot] if stored else room.nothing
            _hold_antenna(covariance, state.turn, frame.lever_arm_row, dropped)
        predict(covariance, room.work, mat, force, interval, sensors.axis, room.mean, room.decay_factor,
                room.driving_variance, sensors.white, room.shift)  # fmt: skip
        before = mat_from_quat(nav[2])
        for s in range(len(sensors.axis)):
            errors[s] *= room.decay_factor[s]
        if state.offset[WALK_RATE] > 0.0:
            for i in range(len(covariance) - OFFSET_STATES, len(covariance)):
                covariance[i, i] += state.offset[WALK_RATE] * interval
        history.nis[e] = np.nan
        if fix >= 0:
            change = add_scaled(nav[1], -1.0, velocity)
            acceleration = change[0] / interval, change[1] / interval, change[2] / interval
            nav = _process_fix(inputs, fix, slot, time, nav, rate, acceleration, sensors, frame, control, sub_filter,
                               state, record, room, block)  # fmt: skip
            history.nis[e] = record.statistic[fix]
        if frame.wheels.std > 0.0:
            nav = apply_wheel_constraint(
                frame.wheels, epochs.quiet[e], interval, nav, rate, covariance, errors, sensors, room.sensitivity,
                room.row, room.cross_covariance, room.gain, block, slot, FIX,
            )  # fmt: skip
        after = mat_from_quat(nav[2])
        for i in range(3):
            for m in range(3):
                state.turn[i, m] = after[i][m] - before[i][m]
        if fix >= 0:
            copy_matrix(kept[fix], covariance)
        write_epoch(history, e, nav, errors, covariance)
        if stored:
            copy_matrix(block.covariance[slot], covariance)
    for i in range(10):
        state.navigation[i] = history.navigation[last - 1, i]
    state.sample[0], state.clock[0] = k, time


@njit(cache=True, error_model="numpy")
def _filter_members(inputs, epochs, first, last, sensors, frame, control, states, history, record, kept, room, block):
    """Filter the epochs ``first`` to ``last`` (excluded) from the states at the end of the one before.

    The first member is the main filter, others are sub-filters; all of them stop at each fix. Fills ``history``,
    ``record``, ``kept`` (the covariances at the fixes), and ``block``, unless it is empty.
    """
    members, started, main = len(states.counters), -np.inf, member(states, 0)
    every = control.separation_s / max(members - 1, 1)
    while first < last:
        end = first if members > 1 else last - 1
        while end < last - 1 and epochs.fix[end] < 0:
            end += 1
        for number in range(members - 1, -1, -1):
            if number == 0 or states.counters[number, OPEN]:
                one = member(states, number)
                _filter_member(inputs, epochs, first, end + 1, sensors, frame, control, number > 0, one, history,
                               record, kept, room, block)  # fmt: skip
        fix, time, first = epochs.fix[end], main.clock[0], end + 1
        if members > 1 and fix >= 0:
            if not record.reset[fix] and separate_solutions(fix, control.separation_limit, every, states, record, room):
                write_epoch(history, end, unpack_navigation(main.navigation), main.errors, main.covariance)
                copy_matrix(kept[fix], main.covariance)
            if record.offset_event[fix] in (EVENT_OPENED, EVENT_SEPARATED) or record.reset[fix]:
                started = time
                for number in range(1, members):
                    states.counters[number, OPEN] = 0
            elif time - started >= every and not main.counters[REJECTIONS]:
                start_sub_filter(fix, states, room)
                started = time


def navigate(inputs: DriveInputs, start: InitialState, smooth: bool = False) -> DriveSolution:
    """Navigate a drive from an initial state to the end of its log, by the filter or the smoother."""
    log, fixes, assumptions, ellipsoid = inputs.log, inputs.fixes, inputs.assumptions, inputs.ellipsoid
    stamp = _checked_stamps(log, start)
    states = assumptions.states(inputs.model)
    control = replace(inputs.quality, gated=False) if smooth else inputs.quality
    due, seen, std = inputs.measured
    offered = np.flatnonzero((due > start.time + STAMP_TOLERANCE_S) & (due <= stamp[-1] + STAMP_TOLERANCE_S))
    measured = _Measurements(
        np.ascontiguousarray(log[list(AXES)].to_numpy(dtype=float)),
        stamp,
        seen[offered],
        std[offered],
    )
    epochs = Epochs.of(stamp, due[offered], start.time, assumptions.epoch_s)
    if assumptions.nonholonomic_std > 0:
        epochs = epochs._replace(quiet=quiet_epochs(measured.samples, stamp, epochs.end))
    separating = control.separation_s is not None
    step_s = float(np.median(np.diff(stamp)))
    frame, state = _frame(assumptions, states, ellipsoid, separating, step_s), _initial(start, stamp, separating)
    size, components = state.covariance.shape[1], len(COMPONENTS)
    history, kept = History.empty(len(epochs.end), size), np.empty((len(offered), size, size))
    history.begin(state.navigation[0], state.errors[0], state.covariance[0])
    sensors, record = SensorArrays.of(states), InnovationRecord.empty(len(offered), components)
    settings, room = KernelControl.of(control, components), _Room.of(size, len(states))

    def step(known: bool, first: int, last: int, state: FilterState, block: SmootherBlock) -> None:
        own = frame._replace(known=known)
        _filter_members(
            measured, epochs, first, last, sensors, own, settings, state, history, record, kept, room, block
        )

    if separating or not smooth:
        run_filter(partial(step, False), state.copy(1 + SUB_FILTERS * separating), history)
    if smooth:
        run_smoother(partial(step, separating), state, history, FIX + CONSTRAINTS)
    _require_path(history, epochs.end)
    time, rows = pd.Index(epochs.end, name=TIME), np.flatnonzero(epochs.fix >= 0)
    names = [*states.names, *(name for name, _ in assumptions.constants()), *(POSITION_OFFSETS if separating else ())]
    fix_time = fixes.index.to_numpy()[offered]
    return DriveSolution(time, names, history, ellipsoid, fix_time, rows, record, kept, control)


def _require_path(history: History, time: np.ndarray) -> None:
    """Raise a ValueError where a path at times [s], shape (epochs,), is beyond reach, or its variance is none."""
    variances = history.variances[:, :NAVIGATION]
    within = (np.abs(history.navigation) < FARTHEST_M).all(axis=1)
    within &= ((variances >= 0) & (variances < FARTHEST_M**2)).all(axis=1)
    if not within.all():
        raise ValueError(
            f"drive: expected a path known to within {FARTHEST_M:g} m; found one that is not at "
            f"{time[np.argmin(within)]:.10g} s, as by noise far too large or too small for a filter"
        )


def _checked_stamps(log: pd.DataFrame, start: InitialState) -> np.ndarray:
    """Return the stamps of a log of six axes that holds the start [s]."""
    if axes(log) != AXES:
        raise LogError("drive", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    stamp = log.index.to_numpy(dtype=float)
    if not stamp[0] <= start.time < stamp[-1]:
        raise ValueError(
            f"start: expected a time from {stamp[0]:.10g} s to {stamp[-1]:.10g} s; found {start.time:.10g} s"
        )
    return stamp


def _frame(
    assumptions: DriveAssumptions, states: SensorStates, ellipsoid: Ellipsoid, separating: bool, step_s: float
) -> _Frame:  # fmt: skip
    """Return the constants of the compiled filter; ``separating``: with states of the position offset."""
    variance, rows = [*states.variance, *(std**2 for _, std in assumptions.constants())], assumptions.rows(len(states))
    lever, axle = (tuple(map(float, arm)) for arm in (assumptions.lever_m, assumptions.axle_m))
    return _Frame(
        ellipsoid.origin, lever, rows.get(LEVER_ARM[0], 0), rows.get(TIME_OFFSET, 0), separating, False,
        np.append(variance, np.zeros(OFFSET_STATES * separating)),
        # an int would be another compilation
        WheelConstraint(float(assumptions.nonholonomic_std), float(assumptions.nonholonomic_s), axle),
        tuple(NOISE_SIGMA * float(std) for std in np.sqrt(states.white[:3] / step_s)),
    )  # fmt: skip


def _initial(start: InitialState, stamp: np.ndarray, separating: bool) -> FilterState:
    """Return the state of the main filter at the start, ``separating`` with the position offset."""
    added = OFFSET_STATES * separating
    errors, covariance = np.append(start.errors, np.zeros(added)), np.pad(start.covariance, (0, added))
    return FilterState(
        *(one.astype(float)[None] for one in (start.navigation, errors, covariance)),
        np.array([[max(int(np.searchsorted(stamp, start.time, "right")), 1)]]), np.array([[start.time, np.inf]]),
        np.zeros((1, 4), np.int64), np.zeros((1, 4)), np.zeros((1, 3, 3)),
    )  # fmt: skip
