"""Foot-mounted navigation: a strapdown navigator that an error-state filter corrects whenever the foot stands still.

At stance (:mod:`imugap.filters.zero_velocity`) a point of the foot is at rest, and where the body stands so is the
angular rate. Neither holds exactly, and the filter has to know how far: see :class:`Assumptions`. What disturbs a
measurement is a motion with a correlation time and no noise of the samples: n samples of an interval T tell as much as
n T/(2 tau) independent ones, and for so many they count. Halving the interval changes nothing.

The point at rest is not the sensor: a foot rolls over its sole. The arm from the sensor to that point, constant in
``b``, is a state.

A sensor is blind between its samples. Where its output changes by d from one sample to the next, the mean over the
interval is taken to be uncertain by a share of d: at a heel strike by much, in the swing by little. An accelerometer
clips ahead of its filter, so that a strike that shows nine tenths of the full scale (:data:`NEAR`) may have been beyond
it within the sample: such a sample is uncertain by a share of all that it shows, in every direction.

Where the body stands, the noise of the gyroscopes is in the attitude and in the measurement of the rate alike. The
filter takes the two for independent, and so believes a little too little of the attitude after a stand.

Zero velocity says nothing of the height, and what it cannot tell from none, a tilt that the bias of an accelerometer
balances at stance or a shoe that sinks, lifts every stride by the same. A floor tells. Where floors are taken to be
level (:attr:`Assumptions.floor_std`), a foot comes down as high as it stood, unless it rises or falls by more than
:data:`STEP_M`: that is a stair or a slope, of which only the sensors tell.

The smoother is that of Bryson and Frazier: a backward pass over the innovations of the filter that inverts no matrix
(Bierman 1973). It runs the filter again, a block at a time, so that its memory is that of a block.

Sources: E. Foxlin, Pedestrian tracking with shoe-mounted inertial sensors, IEEE Comput. Graph. Appl. 25 (2005) 38-46;
I. Skog, J.-O. Nilsson, P. Handel, Pedestrian tracking using an IMU array, Proc. IEEE CONECCT (2014); G. J. Bierman,
Fixed interval smoothing with discrete measurements, Int. J. Control 18 (1973) 65-75.
"""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit

from imugap.filters.alignment import tilt
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY, backward, predict
from imugap.filters.sensor_states import SensorStates
from imugap.filters.smoother import BLOCK, Path, Sensors, Tape, Track, age, compensate, take_in, write
from imugap.filters.smoother import smooth as go_back
from imugap.filters.zero_velocity import MOVING, STILL, Detector, Stand
from imugap.kinematics.strapdown import POSITION, increments, level, local_step
from imugap.log import AXES, LogError, axes, interval
from imugap.model import ErrorModel
from imugap.numerics.rotation import cross, from_euler, kernel, mat_from_quat, rotate
from imugap.units import STANDARD_GRAVITY

ARM = ("arm_x", "arm_y", "arm_z")
"""The point at rest as the sensor sees it, in ``b`` [m]."""
DOWN = POSITION.index("down")
"""Row of the position that counts down."""
FLOOR = "floor"
"""Where the device is at stance, counted down from the origin [m]."""
FLAT_S = 0.1
"""So long after its begin a foot at stance is flat on the floor [s]."""
NEAR = 0.9
"""Share of the full scale from which on an accelerometer is taken to have clipped within the sample."""
STEP_M = 0.03
"""From this difference on two stances are not on one level [m]: on 1.5 m of a stride a slope of 2 %."""
STEP_STD_M = 1.0
"""Standard deviation of a difference of which nothing is known [m]."""
MEASURED = 10
"""Measurements that a sample may have: velocity, angular rate, position, height over the floor."""
SHORTEST_SWING_S = 0.2
"""What lasts less is no swing of a foot but a stir at stance [s]."""
SHORTEST_STRIDE_M = 0.1
"""What goes less far is no stride but a foot put down anew [m]."""


@dataclass(frozen=True)
class Assumptions:
    """What the filter takes for granted besides the error model; the same for all walks.

    Attributes
    ----------
    detector
        How stance is told.
    velocity_std, correlation_s
        Velocity of the point at rest [m/s] and its correlation time [s].
    settling_std, settling_s
        What the velocity is off in addition at the begin of a stance [m/s]; time constant of its end [s].
    rate_std, rate_correlation_s
        Angular rate of a body that stands [rad/s] and its correlation time [s].
    arm_std
        Standard deviation of the arm from the sensor to the point at rest, each axis [m]; 0 makes it the sensor itself.
    blind_gyro, blind_accel
        Share of the change from sample to sample by which the mean over an interval is uncertain.
    full_scale
        Full scale of the accelerometers [m/s^2]; inf where it is not known.
    tilt_std
        Standard deviation of roll and pitch after levelling, besides what the accelerometers are off [rad].
    floor_std
        Standard deviation of the floor between two stances, and of a foot on it, if the floor is level [m]; 0 takes
        nothing for granted of any floor.
    scale_std
        Standard deviation of the scale factors of gyroscopes and of accelerometers; above 0 they are states.
    gravity
        Local gravity [m/s^2].
    """

    detector: Detector = field(default_factory=Detector)
    velocity_std: float = 0.015
    correlation_s: float = 0.05
    settling_std: float = 0.1
    settling_s: float = 0.05
    rate_std: float = 0.005
    rate_correlation_s: float = 0.1
    arm_std: float = 0.1
    blind_gyro: float = 0.05
    blind_accel: float = 0.3
    full_scale: float = np.inf
    tilt_std: float = 0.005
    floor_std: float = 0.0
    scale_std: tuple[float, float] = (0.0, 0.0)
    gravity: float = STANDARD_GRAVITY


@dataclass(frozen=True, eq=False)
class Solution(Track):
    """What the filter, or the smoother, says of a walk; rows are the samples of the log.

    Attributes
    ----------
    phase
        What the foot does (:mod:`imugap.filters.zero_velocity`), shape (n,).
    covariance
        Of the error state at the last sample, shape (states, states).
    stand
        What the stand at the start shows.
    """

    phase: np.ndarray
    covariance: np.ndarray
    stand: Stand

    @property
    def nis(self) -> np.ndarray:
        """Normalised innovation squared of the filter, shape (n,).

        Chi-square with 3 degrees of freedom at stance, with 6 where the body stands; NaN elsewhere.
        """
        return self.path.nis

    def stances(self) -> np.ndarray:
        """Return the sample in the middle of each stance, shape (stances,); a foot that swings does so for a while.

        What moves for less than :data:`SHORTEST_SWING_S` between two stances is no swing, and these are one.
        """
        edges = np.diff(np.r_[0, self.phase > MOVING, 0])
        first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
        time = self.trajectory.index.to_numpy()
        apart = time[first[1:]] - time[last[:-1]] > SHORTEST_SWING_S
        return (first[np.r_[True, apart]] + last[np.r_[apart, True]]) // 2

    def strides(self) -> pd.DataFrame:
        """Return the strides: ``start``, ``end`` [s] at the middle of stances, ``length`` and ``rise`` [m]."""
        at = self.trajectory.iloc[self.stances()]
        steps = np.diff(at[list(POSITION)].to_numpy(), axis=0)
        table = pd.DataFrame({"start": at.index[:-1], "end": at.index[1:]})
        table = table.assign(length=np.hypot(steps[:, 0], steps[:, 1]), rise=-steps[:, 2])
        return table[table["length"] > SHORTEST_STRIDE_M].reset_index(drop=True)


@dataclass(frozen=True, eq=False)
class Sight:
    """What is known of where the device was, besides that it began at the origin with heading zero.

    Attributes
    ----------
    position
        In the frame of the walk [m], shape (n, 3); NaN where nothing is known.
    std
        Standard deviation of each of its numbers [m].
    heading_std, origin_std
        How far that frame may be off the heading and the place in which the walk begins [rad], [m].
    """

    position: np.ndarray
    std: float
    heading_std: float = 0.0
    origin_std: float = 0.0


class _Trust(NamedTuple):
    """The assumptions as the kernel takes them: spectral densities [unit^2/Hz], shares, largest specific force
    that is believed and gravity [m/s^2].
    """

    velocity_psd: float
    settling_psd: float
    settling_s: float
    rate_psd: float
    blind: np.ndarray
    reach: float
    gravity: float
    floor_variance: float


class _State(NamedTuple):
    """Where a filter is: position, velocity, quaternion; errors of sensors and arm; covariance; time since stance."""

    navigation: np.ndarray
    errors: np.ndarray
    covariance: np.ndarray
    since: np.ndarray

    def copy(self) -> "_State":
        return _State(*(one.copy() for one in self))


@kernel
def _rest(covariance, errors, seen, gyro, noise, arms, row, spread, weight, nav, tape, place):
    """Take in that a point of the foot has the velocity ``seen``; return the corrected navigation and the NIS."""
    total = 0.0
    for i in range(3):
        axes = mat_from_quat(nav[2])[i]
        residual = nav[1][i] - seen[i]
        row[VELOCITY + i] = 1.0
        reach = cross(gyro, axes)
        for m in range(len(arms)):
            row[arms[m]] = -reach[m]
            residual -= reach[m] * errors[arms[m] - NAVIGATION]
        nav, nis = take_in(covariance, errors, row, residual, noise, spread, weight, nav, tape, place, i, True)
        total += nis
    return nav, total


@kernel
def _stand(covariance, errors, rate, noise, axis, gain, row, spread, weight, nav, tape, place):
    """Take in that the body does not turn; return the corrected navigation and the NIS."""
    total = 0.0
    for i in range(3):
        residual = rate[i]
        for s in range(len(axis)):
            if axis[s] == i:
                residual -= gain[s] * errors[s]
                row[NAVIGATION + s] = -gain[s]
        nav, nis = take_in(covariance, errors, row, residual, noise[i], spread, weight, nav, tape, place, 3 + i, True)
        total += nis
    return nav, total


@kernel
def _level(covariance, errors, variance, row, spread, weight, nav, tape, place):
    """Take in that the device is as high over the floor as at the last stance; return the corrected navigation."""
    floor = len(row) - 1
    residual = nav[0][DOWN] - errors[floor - NAVIGATION]
    covariance[floor, floor] += variance if abs(residual) < STEP_M else STEP_STD_M * STEP_STD_M
    row[DOWN], row[floor] = 1.0, -1.0
    nav, _ = take_in(covariance, errors, row, residual, variance, spread, weight, nav, tape, place, MEASURED - 1, True)
    return nav


@kernel
def _see(covariance, errors, position, noise, row, spread, weight, nav, tape, place):
    """Take in where the device is; return the corrected navigation."""
    for i in range(3):
        row[i] = 1.0
        residual = nav[0][i] - position[i]
        nav, _ = take_in(covariance, errors, row, residual, noise, spread, weight, nav, tape, place, 6 + i, True)
    return nav


@njit(cache=True, error_model="numpy")
def _filter(samples, dt, phase, seen, fixes, fix_noise, first, last, sensors, trust, state, path, tape):
    """Filter the samples ``first`` to ``last``, the latter not included, from the state at the sample before.

    ``path`` is filled at these samples; ``tape`` too, from its begin, unless it has no length.
    """
    axis, scale, decay, driving, white, fixed = sensors
    arms = np.arange(NAVIGATION + len(axis), len(state.covariance) - (trust.floor_variance > 0))
    start, errors, covariance = state.navigation, state.errors, state.covariance
    count, size, taped = len(axis), len(covariance), len(tape.rows) > 0
    work, shift = np.empty((size, size)), np.empty((6, size))
    gain, hold, drive = np.ones(count), np.ones(count), np.zeros(count)
    row, spread, weight = np.zeros(size), np.empty(size), np.empty(size)
    now, before, noise = np.empty(6), np.empty(6), np.empty(6)
    nav = (start[0], start[1], start[2]), (start[3], start[4], start[5]), (start[6], start[7], start[8], start[9])
    mat, since, step = mat_from_quat(nav[2]), state.since[0], 0.0
    for k in range(first, last):
        interval, place = dt[k], k - first
        compensate(samples, k, axis, scale, fixed, errors, gain, now, before)
        for a in range(6):
            change = trust.blind[a] * (samples[k, a] - samples[k - 1, a])
            noise[a] = white[a] + change * change * interval
        shown = max(abs(samples[k, 3]), abs(samples[k, 4]), abs(samples[k, 5]))
        if shown > trust.reach:
            for a in range(3, 6):
                doubt = trust.blind[a] * shown
                noise[a] += doubt * doubt * interval
        if interval != step:
            age(decay, driving, interval, hold, drive)
            step = interval
        gyro = now[0], now[1], now[2]
        accel = now[3], now[4], now[5]
        gyro_before, accel_before = (before[0], before[1], before[2]), (before[3], before[4], before[5])
        rotvec, delta_v = increments(gyro, accel, gyro_before, accel_before, interval, dt[k - 1])
        push = rotate(nav[2], delta_v)
        force = push[0] / interval, push[1] / interval, push[2] / interval
        nav = local_step(nav[0], nav[1], nav[2], rotvec, delta_v, interval, trust.gravity)
        if taped:
            backward(tape.backward[place], work, mat, force, interval, axis, gain, hold, shift)
        predict(covariance, work, mat, force, interval, axis, gain, hold, drive, noise, shift)
        for s in range(count):
            errors[s] *= hold[s]
        path.nis[k] = np.nan
        since = since + interval if phase[k] > MOVING else 0.0
        if phase[k] > MOVING:
            slip = (trust.velocity_psd + trust.settling_psd * np.exp(-2 * since / trust.settling_s)) / interval
            nav, path.nis[k] = _rest(
                covariance,
                errors,
                (seen[k, 0], seen[k, 1], seen[k, 2]),
                gyro,
                slip,
                arms,
                row,
                spread,
                weight,
                nav,
                tape,
                place,
            )
        if trust.floor_variance > 0 and since - interval < FLAT_S <= since:
            nav = _level(covariance, errors, trust.floor_variance, row, spread, weight, nav, tape, place)
        if phase[k] == STILL:
            rate = samples[k, 0] - fixed[0], samples[k, 1] - fixed[1], samples[k, 2] - fixed[2]
            sway = (
                (white[0] + trust.rate_psd) / interval,
                (white[1] + trust.rate_psd) / interval,
                (white[2] + trust.rate_psd) / interval,
            )
            nav, nis = _stand(covariance, errors, rate, sway, axis, gain, row, spread, weight, nav, tape, place)
            path.nis[k] += nis
        if len(fixes) and not np.isnan(fixes[k, 0]):
            fix = fixes[k, 0], fixes[k, 1], fixes[k, 2]
            nav = _see(covariance, errors, fix, fix_noise, row, spread, weight, nav, tape, place)
        mat = mat_from_quat(nav[2])
        write(path, k, nav, errors, covariance)
        if taped:
            tape.covariance[place] = covariance
    for i in range(10):
        start[i] = path.navigation[last - 1, i]
    state.since[0] = since


def navigate(
    log: pd.DataFrame,
    model: ErrorModel,
    assumptions: Assumptions | None = None,
    smooth: bool = False,
    velocity: np.ndarray | None = None,
) -> Solution:
    """Navigate a walk that begins with a stand, at the origin, with heading zero.

    Parameters
    ----------
    log
        Log of six axes; without long gaps (:func:`imugap.integrity.timestamps.filled`).
    model
        Errors of the sensors: the filter takes its states and noise densities from it.
    assumptions
        What is taken for granted besides.
    smooth
        Whether each sample is told from the whole walk and not from what lies before it.
    velocity
        What is measured of the point at rest, in ``n`` [m/s], shape (n, 3): zero unless a simulation has it otherwise
        (:class:`imugap.effects.StanceMotion`).
    """
    given = _Given.of(log, model, assumptions or Assumptions(), velocity)
    path, state = given.begun()
    (_smoothed if smooth else _filtered)(given.arguments, state, path)
    return Solution(log.index, given.names, path, given.phase, state.covariance, given.stand)


def innovations(
    log: pd.DataFrame,
    model: ErrorModel,
    assumptions: Assumptions | None = None,
    velocity: np.ndarray | None = None,
    sight: Sight | None = None,
    phase: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the innovations of the filter and their variances, shape (n, 10); NaN where there is none.

    The columns are velocity, angular rate of a body that stands, position, and height over the floor. ``phase`` is what
    the foot does, where the detector is not to be asked; the other parameters are those of :func:`navigate`. For a
    filter that knows itself the innovations over their standard deviations are independent standard normal deviates.
    """
    given = _Given.of(log, model, assumptions or Assumptions(), velocity, sight, phase)
    path, state = given.begun()
    tape = Tape.of_innovations(len(log) - 1, MEASURED)
    _filter(*given.arguments[:6], 1, len(log), *given.arguments[6:], state, path, tape)
    known, first = tape.variances > 0, np.full((1, MEASURED), np.nan)
    return tuple(np.vstack([first, np.where(known, one, np.nan)]) for one in (tape.residuals, tape.variances))


@dataclass(frozen=True, eq=False)
class _Given:
    """A walk as the kernel takes it, and what is known before."""

    assumptions: Assumptions
    states: SensorStates
    phase: np.ndarray
    stand: Stand
    arguments: tuple
    sight: Sight | None

    @classmethod
    def of(
        cls, log: pd.DataFrame, model: ErrorModel, assumptions: Assumptions, velocity: np.ndarray | None,
        sight: Sight | None = None, phase: np.ndarray | None = None,
    ) -> "_Given":  # fmt: skip
        if axes(log) != AXES:
            raise LogError("walk", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
        samples = np.ascontiguousarray(log[list(AXES)].to_numpy(dtype=float))
        gyro, accel, step = samples[:, :3], samples[:, 3:], interval(log)
        stand = assumptions.detector.stand(gyro, accel, step)
        phase = assumptions.detector.phases(gyro, accel, step, stand) if phase is None else phase
        steps = np.diff(log.index.to_numpy())
        dt = np.concatenate([steps[:1], steps])
        states = SensorStates.of(model, assumptions.scale_std)
        seen = np.zeros((len(samples), 3)) if velocity is None else np.ascontiguousarray(velocity, dtype=float)
        fixes, noise = (np.empty((0, 3)), 1.0) if sight is None else (sight.position, sight.std**2)
        arguments = samples, dt, phase, seen, fixes, noise, Sensors.of(states), _trust(assumptions)
        return cls(assumptions, states, phase, stand, arguments, sight)

    @property
    def names(self) -> list[str]:
        """Names of the states behind the navigation."""
        arms, floor = self.assumptions.arm_std > 0, self.assumptions.floor_std > 0
        return [*self.states.names, *(ARM if arms else ()), *((FLOOR,) if floor else ())]

    def begun(self) -> tuple[Path, _State]:
        """Return the path at its begin and the state there."""
        samples = self.arguments[0]
        state = _start(samples[: self.stand.count, 3:], self.states, self.assumptions)
        if self.sight is not None:
            state.covariance[range(3), range(3)] = self.sight.origin_std**2
            state.covariance[ATTITUDE + 2, ATTITUDE + 2] = self.sight.heading_std**2
        path = Path.empty(len(samples), len(state.covariance))
        path.begin(state.navigation, state.errors, state.covariance)
        return path, state


def _trust(assumptions: Assumptions) -> _Trust:
    """Return the densities: a motion of standard deviation s and correlation time tau counts as white, 2 s^2 tau."""
    return _Trust(
        velocity_psd=2 * assumptions.velocity_std**2 * assumptions.correlation_s,
        settling_psd=2 * assumptions.settling_std**2 * assumptions.correlation_s,
        settling_s=assumptions.settling_s,
        rate_psd=2 * assumptions.rate_std**2 * assumptions.rate_correlation_s,
        blind=np.repeat([assumptions.blind_gyro, assumptions.blind_accel], 3),
        reach=NEAR * assumptions.full_scale,
        gravity=assumptions.gravity,
        floor_variance=assumptions.floor_std**2,
    )


def _start(accel: np.ndarray, states: SensorStates, assumptions: Assumptions) -> _State:
    """Return the state at the first sample of a stand: at rest, level as far as its mean specific force tells."""
    force = accel.mean(axis=0) - states.fixed[3:]
    rotation = from_euler((*level(force), 0.0))
    tilted = tilt(force, rotation.as_matrix(), states, assumptions.gravity)
    arms = [assumptions.arm_std**2] * len(ARM) if assumptions.arm_std > 0 else []
    floor = [assumptions.floor_std**2] if assumptions.floor_std > 0 else []
    covariance = np.diag([0.0] * NAVIGATION + [*states.variance, *arms, *floor])
    covariance[range(VELOCITY, ATTITUDE), range(VELOCITY, ATTITUDE)] = assumptions.velocity_std**2
    sensors, level_rows = slice(NAVIGATION, NAVIGATION + len(states)), slice(ATTITUDE, ATTITUDE + 2)
    covariance[level_rows, sensors] = tilted * states.variance
    covariance[sensors, level_rows] = covariance[level_rows, sensors].T
    covariance[level_rows, level_rows] = tilted * states.variance @ tilted.T + assumptions.tilt_std**2 * np.eye(2)
    errors = np.zeros(len(covariance) - NAVIGATION)
    return _State(np.concatenate([np.zeros(6), rotation.as_quat()]), errors, covariance, np.full(1, np.inf))


def _filtered(arguments: tuple, state: _State, path: Path) -> None:
    """Fill the path by the filter."""
    _filter(*arguments[:6], 1, len(path.nis), *arguments[6:], state, path, Tape.empty(0, len(state.covariance)))


def _smoothed(arguments: tuple, state: _State, path: Path) -> None:
    """Fill the path by the smoother."""
    size = len(state.covariance)
    edges = [*range(1, len(path.nis), BLOCK), len(path.nis)]
    blocks, starts = list(pairwise(edges)), []
    for first, last in blocks:
        starts.append(state.copy())
        _filter(*arguments[:6], first, last, *arguments[6:], state, path, Tape.empty(0, size))
    adjoint, information = np.zeros(size), np.zeros((size, size))
    for (first, last), start in zip(reversed(blocks), reversed(starts), strict=True):
        tape = Tape.empty(last - first, size, MEASURED)
        _filter(*arguments[:6], first, last, *arguments[6:], start, path, tape)
        go_back(path, first, last, tape, adjoint, information)
