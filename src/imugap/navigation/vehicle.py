"""GNSS/INS: a strapdown navigator on the WGS-84 ellipsoid that an error-state filter corrects at every fix.

Loosely coupled: a fix measures position and, where the receiver tells it, velocity of its antenna. The states are
position, velocity, attitude, those of the sensors (for a Gauss-Markov bias and a scale factor of each axis, 21 in all)
and, where asked for, the lever arm and the time offset of the fixes. What the filter does with a fix that does not fit
is in :mod:`imugap.filters.innovation_gate`.

An epoch ends at every so many samples and at every fix (:mod:`imugap.filters.epochs`); what is known of wheels, where a
vehicle has some, is taken in at the end of each (:mod:`imugap.filters.nonholonomic`). The navigation equations are
integrated sample by sample in full; the covariance goes from epoch to epoch with the means of attitude, specific force
and rate. In its transition the rates of Earth and transport are neglected (:mod:`imugap.filters.error_state`): over a
minute they turn an error by 5 mrad.

The smoother feeds back at every fix, whatever the gates say: it knows all fixes at once, and has nothing to hold back.

Sources: P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013,
sections 14.1 and 14.3 (lever arm: eqs. 14.111 to 14.113); G. J. Bierman, Fixed interval smoothing with discrete
measurements, Int. J. Control 18 (1973) 65-75.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from imugap.filters.epochs import NEAR, Epochs
from imugap.filters.error_state import ATTITUDE, NAVIGATION, backward, predict, project
from imugap.filters.innovation_gate import ASIDE, FRESH, HELD, SANE, TAKEN, Control, Quality, Record, chi_square, weigh
from imugap.filters.nonholonomic import MEASURED, Wheels, quiet, roll
from imugap.filters.sensor_states import SensorStates
from imugap.filters.smoother import BLOCK, Path, Sensors, Tape, Track, age, compensate, take_in, write
from imugap.filters.smoother import smooth as go_back
from imugap.filters.solution_separation import (
    FREE,
    LOOKED_BACK,
    OFFSETS,
    OPEN,
    OPENED,
    RESERVES,
    SHIFT,
    STRIKES,
    WALK,
    State,
    doubt,
    excess,
    fill,
    forget,
    lane,
    learn,
    look_back,
    navigation,
    relieve,
)  # fmt: skip
from imugap.io import gnss
from imugap.io.gnss import COMPONENTS
from imugap.kinematics.strapdown import GEODETIC, Ellipsoid, ellipsoid_step, increments
from imugap.log import AXES, TIME, LogError, axes
from imugap.model import ErrorModel
from imugap.numerics.rotation import add_scaled, cross, dot, kernel, mat_from_quat, rotate

LEVER = ("lever_x", "lever_y", "lever_z")
"""What the lever arm, from the device to the antenna in ``b``, is more than was taken for granted [m]."""
OFFSET = "offset"
"""How much later than was taken for granted a fix belongs [s]."""
FIX = len(COMPONENTS)
"""Measurements of a fix."""


@dataclass(frozen=True)
class Assumptions:
    """What the filter takes for granted besides the error model.

    Attributes
    ----------
    lever_m
        Lever arm from the device to the antenna, in ``b`` [m].
    lever_std
        Its standard deviation, each axis [m]; above 0 it is a state.
    offset_s
        What is added to the stamp of a fix to have the time of the log at which it belongs [s].
    offset_std
        Its standard deviation [s]; above 0 it is a state.
    scale_std
        Standard deviations of the scale factors of gyroscopes and of accelerometers; above 0 they are states.
    scale_s
        Correlation time of the scale factors [s].
    position_std, velocity_std
        Standard deviations of a fix, north, east, down [m] and [m/s], where its log has none.
    epoch_s
        Longest epoch of the covariance [s].
    wheels_std
        Standard deviation of the velocity of the rear axle across and up [m/s] (:mod:`imugap.filters.nonholonomic`); 0
        takes nothing for granted of wheels.
    wheels_s
        Its correlation time [s].
    axle_m
        From the device to the middle of the rear axle, in ``b`` [m].
    """

    lever_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lever_std: float = 0.0
    offset_s: float = 0.0
    offset_std: float = 0.0
    scale_std: tuple[float, float] = (2e-3, 2e-3)
    scale_s: float = np.inf
    position_std: tuple[float, float, float] = (1.5, 1.5, 3.0)
    velocity_std: tuple[float, float, float] = (0.1, 0.1, 0.2)
    epoch_s: float = 0.05
    wheels_std: float = 0.0
    wheels_s: float = 2.0
    axle_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def states(self, model: ErrorModel) -> SensorStates:
        """Return the states of the sensors under ``model``."""
        return SensorStates.of(model, self.scale_std, self.scale_s)

    def constants(self) -> list[tuple[str, float]]:
        """Return names and standard deviations of the states behind those of the sensors."""
        lever = [(name, self.lever_std) for name in LEVER if self.lever_std > 0]
        return lever + ([(OFFSET, self.offset_std)] if self.offset_std > 0 else [])


@dataclass(frozen=True, eq=False)
class Start:
    """Where a filter starts.

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
class Solution(Track):
    """What the filter, or the smoother, says of a drive; rows are the epochs.

    Attributes
    ----------
    ellipsoid
        Where positions are counted from.
    fix_time
        Stamps of the fixes that were offered, as in their log [s], shape (fixes,).
    fix_row
        The epoch of each, shape (fixes,).
    record
        What the quality control of the filter saw and did.
    covariances
        Of the filter, once each fix was taken in, shape (fixes, states, states).
    quality
        The quality control.
    """

    ellipsoid: Ellipsoid
    fix_time: np.ndarray
    fix_row: np.ndarray
    record: Record
    covariances: np.ndarray
    quality: Quality

    @cached_property
    def geodetic(self) -> pd.DataFrame:
        """Latitude, longitude [rad] and height [m]."""
        place = self.ellipsoid.geodetic(self.path.navigation[:, :3])
        return pd.DataFrame(place, index=self.time, columns=list(GEODETIC))

    @cached_property
    def events(self) -> pd.DataFrame:
        """What the quality control did (:meth:`imugap.filters.innovation_gate.Record.events`)."""
        return self.record.events(self.fix_time, COMPONENTS, self.quality)


class _Inputs(NamedTuple):
    """Samples, shape (n, 6), their stamps [s], fixes and their standard deviations, shape (fixes, 6)."""

    samples: np.ndarray
    stamp: np.ndarray
    seen: np.ndarray
    std: np.ndarray


class _Frame(NamedTuple):
    """What the kernel needs besides: origin of the ellipsoid, lever arm, whether it and the offsets are states.

    ``known``: what became of each position is known from an earlier pass.
    """

    origin: tuple[float, float, float, float]
    lever: tuple[float, float, float]
    lever_state: bool
    offset_state: bool
    shift_state: bool
    known: bool
    variance: np.ndarray
    wheels: Wheels


class _Room(NamedTuple):
    """Room for the filter to work in."""

    work: np.ndarray
    shift: np.ndarray
    gain: np.ndarray
    mean: np.ndarray
    hold: np.ndarray
    drive: np.ndarray
    now: np.ndarray
    before: np.ndarray
    rows: np.ndarray
    spread: np.ndarray
    weight: np.ndarray
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
        """Return room for so many states, so many of which are of the sensors."""
        vectors = (np.ones(states) for _ in range(4))
        axes, components = (np.empty(6) for _ in range(2)), (np.empty(6) for _ in range(2))
        return cls(
            np.empty((size, size)), np.empty((6, size)), *vectors, *axes, np.empty((6, size)), np.empty(size),
            np.empty(size), np.zeros(size), np.empty(6, np.int64), *components, np.empty((6, 6)), np.empty((6, 6)),
            np.empty(6), np.empty((0, 0)),
        )  # fmt: skip


@kernel
def _expect(i, nav, rate, acceleration, errors, sensors, gain, frame, row):
    """Return what component ``i`` of a fix should be, and fill ``row`` with its slope in the states."""
    mat = mat_from_quat(nav[2])
    axes, first = mat[i % 3], NAVIGATION + len(sensors.axis)
    lever, delay = frame.lever, 0.0
    last = len(row) - 1 - SHIFT if frame.shift_state else len(row) - 1
    if frame.lever_state:
        e = errors[first - NAVIGATION], errors[first - NAVIGATION + 1], errors[first - NAVIGATION + 2]
        lever = add_scaled(lever, 1.0, e)
    if frame.offset_state:
        delay = errors[last - NAVIGATION]
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
                row[NAVIGATION + s] = gain[s] * shift[sensors.axis[s]]
    if frame.lever_state:
        reach = axes if i < 3 else cross(axes, rate)
        for m in range(3):
            row[first + m] = reach[m]
    if frame.offset_state:
        row[last] = moving[a]
    own = nav[0][a] if i < 3 else nav[1][a]
    if frame.shift_state and i < 3:
        row[last + 1 + i] = 1.0
        own += errors[last + 1 + i - NAVIGATION]
    return own + u[a] + delay * moving[a]


@kernel
def _reset(covariance, errors, control, seen, variance, transposed):
    """Inflate the covariance; give up estimates of sensors that are out of proportion (``transposed``: so tape it).

    ``seen`` are the innovations, NaN where there is none: position and velocity become as uncertain as they show.
    """
    for i in range(NAVIGATION):
        std = control.reset_std[i // 3]
        if i < len(seen) and not np.isnan(seen[i]):
            std = max(std, abs(seen[i]))
        covariance[i, i] += std * std
    for s in range(len(errors)):
        i = NAVIGATION + s
        if errors[s] * errors[s] > SANE * SANE * variance[s] > 0.0:
            errors[s] = 0.0
            for j in range(len(covariance)):
                covariance[i, j] = covariance[j, i] = 0.0
            for j in range(len(transposed)):
                transposed[j, i] = 0.0
        covariance[i, i] += variance[s]


@kernel
def _compare(inputs, fix, nav, rate, acceleration, covariance, errors, sensors, gain, frame, room, multiple):
    """Fill in the innovations of the components that a fix has, and their covariance; return how many there are.

    The variance of velocities is ``multiple`` times what it is told to be.
    """
    count = 0
    for i in range(6):
        if not np.isnan(inputs.seen[fix, i]):
            expected = _expect(i, nav, rate, acceleration, errors, sensors, gain, frame, room.rows[count])
            room.present[count], room.innovation[count] = i, expected - inputs.seen[fix, i]
            room.noise[count] = inputs.std[fix, i] * inputs.std[fix, i] * (1.0 if i < 3 else multiple)
            count += 1
    for i in range(count):
        project(covariance, room.rows[i], 0.0, room.spread)
        for j in range(count):
            room.variance[i, j] = room.noise[i] if i == j else 0.0
            for m in range(len(covariance)):
                room.variance[i, j] += room.rows[j, m] * room.spread[m]
    return count


@kernel
def _judge(fix, count, limit, room, record):
    """Put a fix to the global test; write what it saw."""
    statistic, log_det = chi_square(room.innovation, room.variance, count, room.factor, room.whitened)
    for i in range(count):
        number = room.present[i]
        record.innovation[fix, number], record.variance[fix, number] = room.innovation[i], room.variance[i, i]
        record.whitened[fix, i] = room.whitened[i]
    record.statistic[fix], record.log_det[fix], record.freedom[fix] = statistic, log_det, count
    record.passed[fix] = statistic <= limit
    return statistic <= limit


@kernel
def _absorb(fix, count, course, fed, nav, covariance, errors, control, room, record, tape, place):
    """Put the components of a fix to their test and take in what is left; return the corrected navigation.

    A fix that is set aside is left out, and of one that starts an offset anew the velocity: it is of the same receiver.
    """
    for i in range(count):
        trusted = np.inf
        if course != ASIDE and (course != FRESH or room.present[i] < SHIFT):
            trusted = weigh(room.innovation[i], room.variance[i, i], room.noise[i], control.component,
                            control.robust, control.steepness)  # fmt: skip
        record.share[fix, room.present[i]] = room.noise[i] / trusted
        room.noise[i] = trusted
    for i in range(count):
        if room.noise[i] < np.inf:
            residual = room.innovation[i]
            nav, _ = take_in(covariance, errors, room.rows[i], residual, room.noise[i], room.spread, room.weight, nav,
                             tape, place, i, fed)  # fmt: skip
            for j in range(i + 1, count):
                for m in range(len(room.weight)):
                    room.innovation[j] -= room.rows[j, m] * room.weight[m] * residual
    return nav


@kernel
def _advance(inputs, k, time, target, nav, errors, sensors, frame, room):
    """Navigate to ``target``; return the navigation, the means of attitude and specific force, sample and rate.

    The mean of what a unit of each sensor state adds to its axis goes into ``room.mean``.
    """
    stamp, states = inputs.stamp, len(sensors.axis)
    c0, c1, c2, force = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    gyro, part = (0.0, 0.0, 0.0), 1 / (target - time)
    for s in range(states):
        room.mean[s] = 0.0
    while time < target:
        compensate(inputs.samples, k, sensors.axis, sensors.scale, sensors.fixed, errors, room.gain, room.now,
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
            room.mean[s] += share * room.gain[s]
        nav = ellipsoid_step(nav[0], nav[1], nav[2], rotvec, delta_v, dt, frame.origin)
        time = end
        if end == stamp[k]:
            k += 1
    return nav, (c0, c1, c2), force, k, gyro


@njit(cache=True, error_model="numpy")
def _run(inputs, epochs, first, last, sensors, frame, control, reserve, state, path, record, kept, room, tape):
    """Take one lane over the epochs ``first`` to ``last``; see :func:`_filter`. A ``reserve`` has no soft reset."""
    errors, covariance, memory, taped = state.errors, state.covariance, state.memory, len(tape.rows) > 0
    nav, k, time, failing, step = navigation(state.navigation), state.sample[0], state.clock[0], state.clock[1], 0.0
    for e in range(first, last):
        place, fix, velocity, interval = e - first, epochs.fix[e], nav[1], epochs.end[e] - time
        nav, mat, force, k, rate = _advance(inputs, k, time, epochs.end[e], nav, errors, sensors, frame, room)
        time = epochs.end[e]
        if interval != step:
            age(sensors.decay, sensors.driving, interval, room.hold, room.drive)
            step = interval
        if taped:
            backward(tape.backward[place], room.work, mat, force, interval, sensors.axis, room.mean, room.hold,
                     room.shift)  # fmt: skip
        predict(covariance, room.work, mat, force, interval, sensors.axis, room.mean, room.hold, room.drive,
                sensors.white, room.shift)  # fmt: skip
        for s in range(len(sensors.axis)):
            errors[s] *= room.hold[s]
        if state.doubt[WALK] > 0.0:
            for i in range(len(covariance) - SHIFT, len(covariance)):
                covariance[i, i] += state.doubt[WALK] * interval
        path.nis[e] = np.nan
        if fix >= 0:
            gained, multiple = add_scaled(nav[1], -1.0, velocity), excess(state)
            pull = gained[0] / interval, gained[1] / interval, gained[2] / interval
            count = _compare(inputs, fix, nav, rate, pull, covariance, errors, sensors, room.gain, frame, room,
                             multiple)  # fmt: skip
            passed = _judge(fix, count, control.limits[count], room, record)
            path.nis[e] = record.statistic[fix]
            course, over = TAKEN, False
            if frame.known:
                course, reset = record.course[fix], record.reset[fix]
                over = memory[OPEN] and course == TAKEN
                memory[OPEN] = course >= FRESH or (course == ASIDE and memory[OPEN])
            else:
                if frame.shift_state:
                    course = doubt(fix, count, control.limits, room, record, memory)
                failing = np.inf if passed and not memory[OPEN] else min(failing, time)
                reset = not reserve and time - failing > control.reset_s
            dropped = tape.backward[place] if taped else room.nothing
            if reset:
                record.turn[fix] = 0
                for i in range(SHIFT if frame.shift_state else 0):
                    record.innovation[fix, i] -= errors[len(errors) - SHIFT + i]
                _reset(covariance, errors, control, record.innovation[fix], frame.variance, dropped)
                record.reset[fix], passed, failing, over, memory[OPEN], course = True, True, np.inf, True, 0, TAKEN
            if over or course == FRESH:
                if frame.shift_state:
                    forget(covariance, errors, 0.0 if over else FREE, dropped)
                    state.doubt[WALK] = 0.0
                count, multiple = _compare(inputs, fix, nav, rate, pull, covariance, errors, sensors, room.gain, frame,
                                           room, 1.0), 1.0  # fmt: skip
            record.course[fix] = FRESH if course == HELD and state.doubt[WALK] > 0.0 else course
            learn(count, course == FRESH, multiple, room, state)
            fed = passed or not control.gated
            course = HELD if frame.known and course == FRESH else course
            nav = _absorb(fix, count, course, fed, nav, covariance, errors, control, room, record, tape,
                          place)  # fmt: skip
        if frame.wheels.std > 0.0:
            nav = roll(frame.wheels, epochs.quiet[e], interval, nav, rate, covariance, errors, sensors, room.gain,
                       room.row, room.spread, room.weight, tape, place, FIX)  # fmt: skip
        if fix >= 0:
            fill(kept[fix], covariance)
        write(path, e, nav, errors, covariance)
        if taped:
            fill(tape.covariance[place], covariance)
    for i in range(10):
        state.navigation[i] = path.navigation[last - 1, i]
    state.sample[0], state.clock[0], state.clock[1] = k, time, failing


@njit(cache=True, error_model="numpy")
def _filter(inputs, epochs, first, last, sensors, frame, control, states, path, record, kept, room, tape):
    """Filter the epochs ``first`` to ``last``, the latter not included, from the states at the end of the one before.

    The first lane is the filter; others are its reserves, and all of them stop at each fix. ``path``, ``record`` and
    ``kept``, the covariances at the fixes, are filled; ``tape`` too, unless it has no length.
    """
    lanes, started, main = len(states.memory), -np.inf, lane(states, 0)
    every = control.hindsight_s / max(lanes - 1, 1)
    while first < last:
        end = first if lanes > 1 else last - 1
        while end < last - 1 and epochs.fix[end] < 0:
            end += 1
        for number in range(lanes - 1, -1, -1):
            if number == 0 or states.memory[number, OPEN]:
                _run(inputs, epochs, first, end + 1, sensors, frame, control, number > 0, lane(states, number), path,
                     record, kept, room, tape)  # fmt: skip
        fix, time, first = epochs.fix[end], main.clock[0], end + 1
        if lanes > 1 and fix >= 0:
            if not record.reset[fix] and look_back(fix, control.lasting, every, states, record, room):
                write(path, end, navigation(main.navigation), main.errors, main.covariance)
                fill(kept[fix], main.covariance)
            if record.turn[fix] in (OPENED, LOOKED_BACK) or record.reset[fix]:
                started = time
                for number in range(1, lanes):
                    states.memory[number, OPEN] = 0
            elif time - started >= every and not main.memory[STRIKES]:
                relieve(fix, states, room)
                started = time


def navigate(
    log: pd.DataFrame,
    fixes: pd.DataFrame,
    model: ErrorModel,
    assumptions: Assumptions,
    quality: Quality,
    start: Start,
    ellipsoid: Ellipsoid,
    smooth: bool = False,
) -> Solution:
    """Navigate a drive from ``start`` to the end of its log.

    Parameters
    ----------
    log
        Log of six axes; a sample is the mean over the interval that it ends.
    fixes
        Log of a receiver (:mod:`imugap.io.gnss`); what lies outside of the time to be navigated is left out.
    model
        Errors of the sensors: the filter takes its states and noise densities from it.
    assumptions, quality
        What is taken for granted besides; what is done about fixes that do not fit.
    start
        Where the filter starts, ahead of the last sample.
    ellipsoid
        Where its position is counted from.
    smooth
        Whether each epoch is told from the whole drive and not from what lies before it.
    """
    if axes(log) != AXES:
        raise LogError("drive", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    stamp, states = log.index.to_numpy(dtype=float), assumptions.states(model)
    if not stamp[0] <= start.time < stamp[-1]:
        raise ValueError(f"start: expected a time from {stamp[0]:g} s to {stamp[-1]:g} s; found {start.time:g} s")
    quality = replace(quality, gated=False) if smooth else quality
    due = fixes.index.to_numpy(dtype=float) + assumptions.offset_s
    offered = np.flatnonzero((due > start.time + NEAR) & (due <= stamp[-1] + NEAR))
    epochs = Epochs.of(stamp, due[offered], start.time, assumptions.epoch_s)
    inputs = _Inputs(
        np.ascontiguousarray(log[list(AXES)].to_numpy(dtype=float)),
        stamp,
        gnss.local(fixes, ellipsoid)[offered],
        gnss.deviations(fixes, assumptions.position_std, assumptions.velocity_std)[offered],
    )
    if assumptions.wheels_std > 0:
        epochs = epochs._replace(quiet=quiet(inputs.samples, stamp, epochs.end))
    variance = np.array([*states.variance, *(std**2 for _, std in assumptions.constants())])
    names = [*states.names, *(name for name, _ in assumptions.constants())]
    begin, looking = (start.errors, start.covariance), quality.hindsight_s is not None
    if looking:
        names, variance = [*names, *OFFSETS], np.append(variance, np.zeros(SHIFT))
        begin = np.append(start.errors, np.zeros(SHIFT)), np.pad(start.covariance, (0, SHIFT))
    lever, axle = (tuple(map(float, arm)) for arm in (assumptions.lever_m, assumptions.axle_m))
    wheels = Wheels(float(assumptions.wheels_std), float(assumptions.wheels_s), axle)  # int: kernels of their own
    frame = _Frame(
        ellipsoid.origin, lever, assumptions.lever_std > 0, assumptions.offset_std > 0, looking, False, variance, wheels
    )
    control, record = Control.of(quality, len(COMPONENTS)), Record.empty(len(offered), len(COMPONENTS))
    state = State(
        start.navigation.astype(float)[None], *(one.astype(float)[None] for one in begin),
        np.array([[max(int(np.searchsorted(stamp, start.time, "right")), 1)]]), np.array([[start.time, np.inf]]),
        np.zeros((1, 4), np.int64), np.zeros((1, 4)),
    )  # fmt: skip
    size = len(begin[1])
    path, kept = Path.empty(len(epochs.end), size), np.empty((len(offered), size, size))
    path.begin(state.navigation[0], state.errors[0], state.covariance[0])
    fixed = inputs, epochs, Sensors.of(states), frame, control
    results = path, record, kept, _Room.of(size, len(states))
    if looking or not smooth:
        _filtered(fixed, state.copy(1 + RESERVES * looking), results)
    if smooth:
        _smoothed((*fixed[:3], frame._replace(known=looking), control), state, results)
    rows = np.flatnonzero(epochs.fix >= 0)
    time = pd.Index(epochs.end, name=TIME)
    return Solution(time, names, path, ellipsoid, fixes.index.to_numpy()[offered], rows, record, kept, quality)


def _filtered(fixed: tuple, state: State, results: tuple) -> None:
    """Fill the path by the filter."""
    inputs, epochs, *rest = fixed
    no_tape = Tape.empty(0, state.covariance.shape[1])
    _filter(inputs, epochs, 1, len(epochs.end), *rest, state, *results, no_tape)


def _smoothed(fixed: tuple, state: State, results: tuple) -> None:
    """Fill the path by the smoother."""
    inputs, epochs, *rest = fixed
    size = state.covariance.shape[1]
    blocks, starts = list(pairwise([*range(1, len(epochs.end), BLOCK), len(epochs.end)])), []
    for first, last in blocks:
        starts.append(state.copy())
        _filter(inputs, epochs, first, last, *rest, state, *results, Tape.empty(0, size))
    adjoint, information = np.zeros(size), np.zeros((size, size))
    for (first, last), start in zip(reversed(blocks), reversed(starts), strict=True):
        tape = Tape.empty(last - first, size, FIX + MEASURED)
        _filter(inputs, epochs, first, last, *rest, start, *results, tape)
        go_back(results[0], first, last, tape, adjoint, information)
