"""Foot-mounted navigation: strapdown navigation with an error-state filter and zero-velocity updates.

At stance (:mod:`imugap.filters.zero_velocity`) a point of the foot is at rest; where the body stands, so is the angular
rate. Neither holds exactly; :class:`WalkAssumptions` states the deviations. They are motions with a correlation time
tau, not sample noise: n samples of interval T count as n T/(2 tau) independent ones, so that the sampling rate makes no
difference. The velocity of the point is the less certain the more the foot moves: its variance grows with the detection
statistic. A foot that just came down, rolls off, or swings slowly thus counts for little against one that rests.

The point at rest is not the sensor, since a foot rolls over its sole. The arm from the sensor to that point, constant
in ``b``, is a state.

The motion between two samples is unknown. Where the output changes by d from one sample to the next, the interval mean
is uncertain by a share of d: large at a heel strike, small in the swing. How large a share depends on shoe, gait and
device; the velocities that the filter predicts for the begins of stances show it, by their likelihood. A sensor clips
ahead of its filter, so a sample above a share of the full scale (:data:`CLIPPING_SHARE`) may have clipped within: it is
uncertain by a share of its magnitude (:data:`CLIPPED_SHARE`), a strike in every direction, a rate about its axis. A
runner's foot turns faster than many gyroscopes measure; the samples show their full scale
(:mod:`imugap.integrity.clipping`).

A walk that begins in motion has no stand to be levelled on (:attr:`WalkAssumptions.heading_free`). It is levelled on
the quietest stance of its first seconds, as exactly as the motion of a foot at stance allows, and the gyroscopes carry
the level back to the first sample. There the velocity is unknown until the first stance shows it.

Where the body stands, the gyroscope noise enters both the attitude and the measurement of the rate. The filter takes
the two as independent, and is slightly pessimistic about the attitude after a stand.

Zero velocity does not observe the height: an accelerometer bias balanced by a tilt at stance, or a sinking shoe, lifts
every stride by the same amount. Where floors are assumed level (:attr:`WalkAssumptions.floor_std`), the foot is at the
height of the last stance, unless the difference exceeds :data:`STEP_M`: that is a stair or a slope.

The smoother is that of Bryson and Frazier: a backward pass over the innovations that inverts no matrix (Bierman 1973).
It runs the filter again, a block at a time, so that its memory is that of a block.

Sources: E. Foxlin, Pedestrian tracking with shoe-mounted inertial sensors, IEEE Comput. Graph. Appl. 25 (2005) 38-46;
I. Skog, J.-O. Nilsson, P. Handel, Pedestrian tracking using an IMU array, Proc. IEEE CONECCT (2014); G. J. Bierman,
Fixed interval smoothing with discrete measurements, Int. J. Control 18 (1973) 65-75.
"""

from dataclasses import dataclass, field, replace
from functools import reduce
from operator import mul
from typing import NamedTuple

import numpy as np
import pandas as pd
from numba import njit
from scipy.spatial.transform import Rotation

from imugap.filters.alignment import level_sensitivity
from imugap.filters.chords import Chords
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY, predict, transposed_transition
from imugap.filters.sensor_states import SensorStates
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
from imugap.filters.zero_velocity import MOVING, STILL, Detector, Stand
from imugap.integrity.clipping import full_scale
from imugap.kinematics.strapdown import POSITION, increments, level, local_step
from imugap.log import AXES, GYRO, LogError, axes, interval
from imugap.model import ErrorModel
from imugap.numerics.rotation import cross, from_euler, kernel, mat_from_quat, rotate, to_euler
from imugap.units import STANDARD_GRAVITY

LEVER_ARM = ("arm_x", "arm_y", "arm_z")
"""Arm from the sensor to the point at rest, in ``b`` [m]."""
DOWN = POSITION.index("down")
"""Row of the down position."""
FLOOR = "floor"
"""Down position of the device at stance [m]."""
FLAT_S = 0.1
"""Time from the begin of a stance until the foot is flat on the floor [s]."""
CLIPPING_SHARE = 0.9
"""Share of the full scale above which a sensor may have clipped within the sample."""
CLIPPED_SHARE = 0.3
"""Uncertainty of such a sample, as a share of its magnitude."""
SHOCK_SHARES = 0.07, 0.15, 0.35
"""Shares of the change from sample to sample by which a mean specific force is uncertain: from a soft step to a shock
that the sampling does not resolve."""
IMPROBABLE = 9.0
"""Normalised square from which on an innovation counts no more against a share."""
MOTION_EXPONENT = 1.5
"""Exponent of the variance of the velocity at stance over the motion: 1 for an arm that is not known, 2 for a foot that
is not at rest; both occur."""
STEP_M = 0.03
"""Height difference above which two stances are not on one level [m]: a slope of 2 % over a stride of 1.5 m."""
LEVEL_SHARE = 0.1
"""Variance by which the level of a floor changes from stance to stance, as a share of that of a stance upon it."""
STEP_STD_M = 1.0
"""Standard deviation of an unknown height difference [m]."""
MEASUREMENTS = 10
"""Number of measurements of a sample: velocity, angular rate, position, height over the floor."""
START_M_PER_S = 3.0
"""Standard deviation of the velocity at the start of a walk that begins in motion, each axis: that of a swing [m/s]."""
SHORTEST_SWING_S = 0.2
"""Shortest swing of a foot; a shorter motion is part of a stance [s]."""
SHORTEST_STRIDE_M = 0.1
"""Shortest stride; a shorter one is a foot put down again [m]."""


@dataclass(frozen=True)
class WalkAssumptions:
    """Assumptions of the filter besides the error model; the same for all walks.

    Attributes
    ----------
    detector
        Zero-velocity detector.
    velocity_std, correlation_s
        Velocity of the point at rest [m/s] and its correlation time [s].
    motion_std
        Additional velocity where the motion is at the threshold of the detector [m/s].
    rate_std, rate_correlation_s
        Angular rate of a standing body [rad/s] and its correlation time [s].
    arm_std
        Standard deviation of the arm from the sensor to the point at rest, each axis [m]; 0 makes it the sensor itself.
    blind_gyro, blind_accel
        Uncertainty of the interval mean, as a share of the change from sample to sample. Where that of the
        accelerometers is None, it is the most likely of :data:`SHOCK_SHARES`.
    full_scale, rate_full_scale
        Full scale of the accelerometers [m/s^2], inf if unknown, and of the gyroscopes [rad/s], None for that which the
        samples show (:mod:`imugap.integrity.clipping`).
    tilt_std
        Standard deviation of roll and pitch after levelling on a stand of :attr:`imugap.filters.zero_velocity.Detector`
        or longer, without the accelerometer errors [rad]; larger in proportion on a shorter one.
    floor_std
        Standard deviation of the height difference of two stances on a level floor [m]; 0 for no floor assumption.
    scale_std
        Standard deviation of the scale factors of gyroscopes and accelerometers; 0: not a state.
    gravity
        Local gravity [m/s^2].
    heading_free
        Whether a walk may begin in motion. Without a stand it is levelled on a stance of its first seconds, and the
        velocity at its start is unknown. Heading zero is that of the foot at the first sample, wherever it points.
    """

    detector: Detector = field(default_factory=Detector)
    velocity_std: float = 0.002
    correlation_s: float = 0.05
    motion_std: float = 0.02
    rate_std: float = 0.002
    rate_correlation_s: float = 0.1
    arm_std: float = 0.1
    blind_gyro: float = 0.1
    blind_accel: float | None = None
    full_scale: float = np.inf
    rate_full_scale: float | None = None
    tilt_std: float = 0.005
    floor_std: float = 0.0
    scale_std: tuple[float, float] = (0.0, 0.0)
    gravity: float = STANDARD_GRAVITY
    heading_free: bool = False


@dataclass(frozen=True, eq=False)
class WalkSolution(NavigationSolution):
    """Solution of the filter or the smoother for a walk; rows are the samples of the log.

    Attributes
    ----------
    phase
        Phase of the foot (:mod:`imugap.filters.zero_velocity`), shape (n,).
    covariance
        Covariance of the error state at the last sample, shape (states, states).
    stand
        Sensor statistics of the stand at the start.
    chords
        Chords between the middles of the stances, as the smoother knows them; None for the filter.
    """

    phase: np.ndarray
    covariance: np.ndarray
    stand: Stand
    chords: Chords | None = None

    @property
    def nis(self) -> np.ndarray:
        """Normalised innovation squared of the filter, shape (n,).

        Chi-square with 3 degrees of freedom at stance, with 6 where the body stands; NaN elsewhere.
        """
        return self.history.nis

    def stances(self) -> np.ndarray:
        """Return the middle sample of each stance, shape (stances,)."""
        return stances(self.phase, self.time.to_numpy())

    def strides(self) -> pd.DataFrame:
        """Return the strides: ``start``, ``end`` [s] at the middle of stances, ``length`` and ``rise`` [m]."""
        at = self.trajectory.iloc[self.stances()]
        steps = np.diff(at[list(POSITION)].to_numpy(), axis=0)
        table = pd.DataFrame({"start": at.index[:-1], "end": at.index[1:]})
        table = table.assign(length=np.hypot(steps[:, 0], steps[:, 1]), rise=-steps[:, 2])
        return table[table["length"] > SHORTEST_STRIDE_M].reset_index(drop=True)


@dataclass(frozen=True, eq=False)
class PositionAiding:
    """Known positions of the device, besides the start at the origin with heading zero.

    Attributes
    ----------
    position
        Position in the frame of the walk [m], shape (n, 3); NaN where unknown.
    std
        Standard deviation of each coordinate [m].
    heading_std, origin_std
        Standard deviations of the heading and the origin of that frame [rad], [m].
    """

    position: np.ndarray
    std: float
    heading_std: float = 0.0
    origin_std: float = 0.0


class WalkWeights(NamedTuple):
    """What the filter trusts the samples of a walk by.

    Attributes
    ----------
    phase
        Phase of the foot (:mod:`imugap.filters.zero_velocity`), shape (n,).
    velocity_psd
        PSD of the velocity of the point at rest [(m/s)^2/Hz], shape (n,).
    noise_psd
        PSD of the noise of each axis [(rad/s)^2/Hz], [(m/s^2)^2/Hz], shape (n, 6).
    """

    phase: np.ndarray
    velocity_psd: np.ndarray
    noise_psd: np.ndarray


class _Constants(NamedTuple):
    """Assumptions for compiled code: PSD of the angular rate at rest [(rad/s)^2/Hz], gravity [m/s^2], floor [m^2]."""

    rate_psd: float
    gravity: float
    floor_variance: float


class _Inputs(NamedTuple):
    """Inputs of the compiled filter.

    Samples, shape (n, 6); intervals; weights; velocity of the point at rest; known positions and their variance.
    """

    samples: np.ndarray
    dt: np.ndarray
    weights: WalkWeights
    stance_velocity: np.ndarray
    fixes: np.ndarray
    fix_noise: float
    sensors: SensorArrays
    constants: _Constants


class _State(NamedTuple):
    """Filter state: position, velocity, quaternion; errors of sensors and arm; covariance; time since stance."""

    navigation: np.ndarray
    errors: np.ndarray
    covariance: np.ndarray
    stance_s: np.ndarray

    def copy(self) -> "_State":
        return _State(*(one.copy() for one in self))


@kernel
def _zero_velocity(
    covariance, errors, stance_velocity, gyro, noise, arms, row, cross_covariance, gain, nav, block, slot
):
    """Update by the velocity of a point of the foot; return the corrected navigation and the NIS."""
    total = 0.0
    for i in range(3):
        axes = mat_from_quat(nav[2])[i]
        residual = nav[1][i] - stance_velocity[i]
        row[VELOCITY + i] = 1.0
        arm_velocity = cross(gyro, axes)
        for m in range(len(arms)):
            row[arms[m]] = -arm_velocity[m]
            residual -= arm_velocity[m] * errors[arms[m] - NAVIGATION]
        nav, nis = apply_measurement(
            covariance, errors, row, residual, noise, cross_covariance, gain, nav, block, slot, i, True
        )
        total += nis
    return nav, total


@kernel
def _zero_rate(covariance, errors, rate, noise, axis, sensitivity, row, cross_covariance, gain, nav, block, slot):
    """Update by zero angular rate of the body; return the corrected navigation and the NIS."""
    total = 0.0
    for i in range(3):
        residual = rate[i]
        for s in range(len(axis)):
            if axis[s] == i:
                residual -= sensitivity[s] * errors[s]
                row[NAVIGATION + s] = -sensitivity[s]
        nav, nis = apply_measurement(
            covariance, errors, row, residual, noise[i], cross_covariance, gain, nav, block, slot, 3 + i, True
        )
        total += nis
    return nav, total


@kernel
def _floor_height(covariance, errors, variance, row, cross_covariance, gain, nav, block, slot):
    """Update by the height of the last stance; return the corrected navigation."""
    floor = len(row) - 1
    residual = nav[0][DOWN] - errors[floor - NAVIGATION]
    covariance[floor, floor] += LEVEL_SHARE * variance if abs(residual) < STEP_M else STEP_STD_M * STEP_STD_M
    row[DOWN], row[floor] = 1.0, -1.0
    nav, _ = apply_measurement(
        covariance, errors, row, residual, variance, cross_covariance, gain, nav, block, slot, MEASUREMENTS - 1, True
    )
    return nav


@kernel
def _position(covariance, errors, position, noise, row, cross_covariance, gain, nav, block, slot):
    """Update by a known position; return the corrected navigation."""
    for i in range(3):
        row[i] = 1.0
        residual = nav[0][i] - position[i]
        nav, _ = apply_measurement(
            covariance, errors, row, residual, noise, cross_covariance, gain, nav, block, slot, 6 + i, True
        )
    return nav


@njit(cache=True, error_model="numpy")
def _filter(
    samples, dt, weights, stance_velocity, fixes, fix_noise, sensors, constants, first, last, state, history, block
):
    """Filter the samples ``first`` to ``last`` (excluded) from the state at the sample before.

    Fills ``history`` at these samples, and ``block`` from its begin, unless it is empty.
    """
    axis, scale, decay, driving, white, fixed = sensors
    phase, velocity_psd, noise_psd = weights
    arms = np.arange(NAVIGATION + len(axis), len(state.covariance) - (constants.floor_variance > 0))
    start, errors, covariance = state.navigation, state.errors, state.covariance
    count, size, stored = len(axis), len(covariance), len(block.rows) > 0
    work, shift = np.empty((size, size)), np.empty((6, size))
    sensitivity, decay_factor, driving_variance = np.ones(count), np.ones(count), np.zeros(count)
    row, cross_covariance, gain = np.zeros(size), np.empty(size), np.empty(size)
    now, before = np.empty(6), np.empty(6)
    nav = (start[0], start[1], start[2]), (start[3], start[4], start[5]), (start[6], start[7], start[8], start[9])
    mat, stance_s, step = mat_from_quat(nav[2]), state.stance_s[0], 0.0
    for k in range(first, last):
        interval, slot = dt[k], k - first
        compensate(samples, k, axis, scale, fixed, errors, sensitivity, now, before)
        if interval != step:
            discretise_states(decay, driving, interval, decay_factor, driving_variance)
            step = interval
        gyro = now[0], now[1], now[2]
        accel = now[3], now[4], now[5]
        gyro_before, accel_before = (before[0], before[1], before[2]), (before[3], before[4], before[5])
        rotvec, delta_v = increments(gyro, accel, gyro_before, accel_before, interval, dt[k - 1])
        delta_v_n = rotate(nav[2], delta_v)
        force_n = delta_v_n[0] / interval, delta_v_n[1] / interval, delta_v_n[2] / interval
        nav = local_step(nav[0], nav[1], nav[2], rotvec, delta_v, interval, constants.gravity)
        if stored:
            transposed_transition(
                block.transposed[slot], work, mat, force_n, interval, axis, sensitivity, decay_factor, shift
            )
        predict(
            covariance, work, mat, force_n, interval, axis, sensitivity, decay_factor, driving_variance,
            noise_psd[k], shift,
        )  # fmt: skip
        for s in range(count):
            errors[s] *= decay_factor[s]
        history.nis[k] = np.nan
        stance_s = stance_s + interval if phase[k] > MOVING else 0.0
        if phase[k] > MOVING:
            velocity_variance = velocity_psd[k] / interval
            velocity = stance_velocity[k, 0], stance_velocity[k, 1], stance_velocity[k, 2]
            nav, history.nis[k] = _zero_velocity(
                covariance, errors, velocity, gyro, velocity_variance, arms, row, cross_covariance, gain, nav,
                block, slot,
            )  # fmt: skip
        if constants.floor_variance > 0 and stance_s - interval < FLAT_S <= stance_s:
            nav = _floor_height(
                covariance, errors, constants.floor_variance, row, cross_covariance, gain, nav, block, slot
            )
        if phase[k] == STILL:
            rate = samples[k, 0] - fixed[0], samples[k, 1] - fixed[1], samples[k, 2] - fixed[2]
            rate_variance = (
                (white[0] + constants.rate_psd) / interval,
                (white[1] + constants.rate_psd) / interval,
                (white[2] + constants.rate_psd) / interval,
            )
            nav, nis = _zero_rate(
                covariance, errors, rate, rate_variance, axis, sensitivity, row, cross_covariance, gain, nav,
                block, slot,
            )  # fmt: skip
            history.nis[k] += nis
        if len(fixes) and not np.isnan(fixes[k, 0]):
            fix = fixes[k, 0], fixes[k, 1], fixes[k, 2]
            nav = _position(covariance, errors, fix, fix_noise, row, cross_covariance, gain, nav, block, slot)
        mat = mat_from_quat(nav[2])
        write_epoch(history, k, nav, errors, covariance)
        if stored:
            block.covariance[slot] = covariance
    for i in range(10):
        start[i] = history.navigation[last - 1, i]
    state.stance_s[0] = stance_s


def navigate(
    log: pd.DataFrame,
    model: ErrorModel,
    assumptions: WalkAssumptions | None = None,
    smooth: bool = False,
    velocity: np.ndarray | None = None,
) -> WalkSolution:
    """Navigate a walk that begins with a stand at the origin, with heading zero.

    Parameters
    ----------
    log
        Log of six axes; without long gaps (:func:`imugap.integrity.timestamps.filled`).
    model
        Error model of the sensors, from which the filter takes states and noise densities.
    assumptions
        Assumptions besides the error model.
    smooth
        Whether to return the smoother's solution instead of the filter's.
    velocity
        Measured velocity of the point at rest, in ``n`` [m/s], shape (n, 3); zero except in simulations
        (:class:`imugap.effects.StanceMotion`).
    """
    return solve(align(log, model, assumptions, velocity), smooth)


@dataclass(frozen=True, eq=False)
class AlignedWalk:
    """Inputs of the filter for a walk after the alignment on its stand.

    Attributes
    ----------
    time
        Stamps of the samples [s].
    assumptions, states
        Assumptions, and sensor states of the error model.
    stand
        Sensor statistics of the stand at the start.
    inputs
        Inputs of the compiled filter.
    aiding
        Known positions, or None.
    """

    time: pd.Index
    assumptions: WalkAssumptions
    states: SensorStates
    stand: Stand
    inputs: _Inputs
    aiding: PositionAiding | None

    @property
    def phase(self) -> np.ndarray:
        """Phase of the foot at each sample, shape (n,)."""
        return self.inputs.weights.phase

    def with_samples(self, log: pd.DataFrame, velocity: np.ndarray | None = None) -> "AlignedWalk":
        """Return the walk with the samples of another log of the same instants; its stand and its weights stay.

        Since the weights stay, the innovations are linear in a small error of the samples or of ``velocity``
        (:func:`align`).
        """
        inputs = self.inputs._replace(samples=_samples(log), stance_velocity=_velocity(log, velocity))
        return replace(self, inputs=inputs)

    def with_blind_accel(self, share: float) -> "AlignedWalk":
        """Return the walk with accelerometers that are blind to a share of the changes between samples."""
        weights, dt = self.inputs.weights, self.inputs.dt[:, None]
        noise = weights.noise_psd.copy()
        noise[:, 3:] += _change_variance(self.inputs.samples[:, 3:], share) * dt
        inputs = self.inputs._replace(weights=weights._replace(noise_psd=noise))
        return replace(self, assumptions=replace(self.assumptions, blind_accel=share), inputs=inputs)

    @property
    def names(self) -> list[str]:
        """Names of the states behind the navigation."""
        arms, floor = self.assumptions.arm_std > 0, self.assumptions.floor_std > 0
        return [*self.states.names, *(LEVER_ARM if arms else ()), *((FLOOR,) if floor else ())]

    def initial(self) -> tuple[History, _State]:
        """Return the history with its first row, and the initial state."""
        samples = self.inputs.samples
        begin = self._standing() if self.stand.still else self._moving()
        state = _initial_state(samples[self.stand.rows, 3:].mean(axis=0), self.states, self.assumptions, begin)
        if self.aiding is not None:
            state.covariance[range(3), range(3)] = self.aiding.origin_std**2
            state.covariance[ATTITUDE + 2, ATTITUDE + 2] = self.aiding.heading_std**2
        history = History.empty(len(samples), len(state.covariance))
        history.begin(state.navigation, state.errors, state.covariance)
        return history, state

    def _standing(self) -> "_Start":
        """Return the start on a stand."""
        length = self.stand.count * float(np.median(self.inputs.dt))
        shorter = max(self.assumptions.detector.stand_s / length, 1.0)
        return _Start(Rotation.identity(), self.assumptions.velocity_std, self.assumptions.tilt_std * shorter)

    def _moving(self) -> "_Start":
        """Return the start in motion, carried back by the gyroscopes from the stance that is levelled."""
        before = slice(self.stand.first)
        rates = self.inputs.samples[before, :3] - self.states.fixed[:3]
        steps = Rotation.from_rotvec(rates * self.inputs.dt[before, None])
        gyro = self.states.axis < len(GYRO)
        drift = np.sqrt(self.states.variance[gyro].max(initial=0.0)) * self.inputs.dt[before].sum()
        tilt = self.assumptions.detector.accel_std / self.assumptions.gravity
        return _Start(reduce(mul, steps, Rotation.identity()), START_M_PER_S, float(np.hypot(tilt, drift)))


class _Start(NamedTuple):
    """Turn from the first sample to the stand, and standard deviations of velocity [m/s] and level [rad] there."""

    turn: Rotation
    velocity_std: float
    tilt_std: float


def align(
    log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions | None = None,
    velocity: np.ndarray | None = None, aiding: PositionAiding | None = None,
) -> AlignedWalk:  # fmt: skip
    """Find the stand at the start, the phases of the foot and the weights of the samples.

    Parameters
    ----------
    aiding
        Known positions; the other parameters are those of :func:`navigate`.
    """
    if axes(log) != AXES:
        raise LogError("walk", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    assumptions = assumptions or WalkAssumptions()
    samples, step = _samples(log), interval(log)
    stand = _stand(samples, step, assumptions)
    steps = np.diff(log.index.to_numpy())
    dt = np.concatenate([steps[:1], steps])
    states = SensorStates.of(model, assumptions.scale_std)
    fixes, noise = (np.empty((0, 3)), 1.0) if aiding is None else (aiding.position, aiding.std**2)
    inputs = _Inputs(
        samples, dt, _weights(samples, dt, step, stand, states.white, assumptions), _velocity(log, velocity), fixes,
        noise, SensorArrays.of(states), _constants(assumptions),
    )  # fmt: skip
    aligned = AlignedWalk(log.index, assumptions, states, stand, inputs, aiding)
    shares = SHOCK_SHARES if assumptions.blind_accel is None else (assumptions.blind_accel,)
    walks = [aligned.with_blind_accel(share) for share in shares]
    return walks[0] if len(walks) == 1 else max(walks, key=_likelihood)


def innovations(aligned: AlignedWalk) -> tuple[np.ndarray, np.ndarray]:
    """Return the innovations of the filter and their variances, shape (n, 10); NaN where there is none.

    The columns are velocity, angular rate of a standing body, position, and height over the floor. For a consistent
    filter the innovations over their standard deviations are independent and standard normal.
    """
    history, state = aligned.initial()
    block = SmootherBlock.of_innovations(len(aligned.time) - 1, MEASUREMENTS)
    _filter(*aligned.inputs, 1, len(aligned.time), state, history, block)
    known, first = block.variances > 0, np.full((1, MEASUREMENTS), np.nan)
    return tuple(np.vstack([first, np.where(known, one, np.nan)]) for one in (block.residuals, block.variances))


def _likelihood(aligned: AlignedWalk) -> float:
    """Return the log-likelihood of the velocities at the begins of stances, up to a constant, robust to outliers."""
    residual, variance = innovations(aligned)
    rest = aligned.phase > MOVING
    begins = rest & ~np.append(True, rest[:-1])
    square, spread = residual[begins, :3] ** 2, variance[begins, :3]
    return -float(np.sum(np.minimum(square / spread, IMPROBABLE) + np.log(spread)))


def solve(aligned: AlignedWalk, smooth: bool = False) -> WalkSolution:
    """Run the filter, or the smoother, over an aligned walk."""
    history, state = aligned.initial()

    def step(first: int, last: int, state: _State, block: SmootherBlock) -> None:
        _filter(*aligned.inputs, first, last, state, history, block)

    chords = None
    if smooth:
        ends = stances(aligned.phase, aligned.time.to_numpy())
        chords = run_smoother(step, state, history, MEASUREMENTS, ends, SHORTEST_STRIDE_M)
    else:
        run_filter(step, state, history)
    return WalkSolution(aligned.time, aligned.names, history, aligned.phase, state.covariance, aligned.stand, chords)


def stances(phase: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return the middle sample of each stance, from the second sample on, shape (stances,).

    Two stances with a motion shorter than :data:`SHORTEST_SWING_S` between them are one.

    Parameters
    ----------
    phase, time
        Phase of the foot and stamp [s] of each sample, shape (n,).
    """
    edges = np.diff(np.r_[0, phase > MOVING, 0])
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    if not len(first):
        return first
    apart = time[first[1:]] - time[last[:-1]] > SHORTEST_SWING_S
    return np.maximum((first[np.r_[True, apart]] + last[np.r_[apart, True]]) // 2, 1)


def _stand(samples: np.ndarray, step: float, assumptions: WalkAssumptions) -> Stand:
    """Return the stand at the start, or the stance that takes its place."""
    gyro, accel = samples[:, :3], samples[:, 3:]
    if assumptions.heading_free:
        return assumptions.detector.stand_or_stance(gyro, accel, step, assumptions.gravity)
    return assumptions.detector.stand(gyro, accel, step)


def _samples(log: pd.DataFrame) -> np.ndarray:
    """Return the samples, shape (n, 6)."""
    return np.ascontiguousarray(log[list(AXES)].to_numpy(dtype=float))


def _velocity(log: pd.DataFrame, velocity: np.ndarray | None) -> np.ndarray:
    """Return the measured velocity of the point at rest [m/s], shape (n, 3)."""
    return np.zeros((len(log), 3)) if velocity is None else np.ascontiguousarray(velocity, dtype=float)


def _weights(
    samples: np.ndarray, dt: np.ndarray, step: float, stand: Stand, white: np.ndarray, assumptions: WalkAssumptions
) -> WalkWeights:
    """Return the weights of the samples."""
    gyro, accel, detector = samples[:, :3], samples[:, 3:], assumptions.detector
    motion = detector.motion(gyro, accel, step, stand) ** MOTION_EXPONENT
    stds = assumptions.velocity_std, assumptions.motion_std
    own, moving = (_psd(std, assumptions.correlation_s) for std in stds)
    variance = _clipping_variance(samples, assumptions)
    variance[:, :3] += _change_variance(gyro, assumptions.blind_gyro)
    return WalkWeights(detector.phases(gyro, accel, step, stand), own + moving * motion, white + variance * dt[:, None])


def _change_variance(samples: np.ndarray, blind: float) -> np.ndarray:
    """Return the variance of interval means that miss a share ``blind`` of each change of a sample, shape (n, 3)."""
    return (blind * np.diff(samples, axis=0, prepend=samples[:1])) ** 2


def _clipping_variance(samples: np.ndarray, assumptions: WalkAssumptions) -> np.ndarray:
    """Return the variance of the interval means by clipping, shape (n, 6)."""
    rate_full_scale = assumptions.rate_full_scale
    rate_full_scale = full_scale(samples[:, :3]) if rate_full_scale is None else rate_full_scale
    rate, force = np.abs(samples[:, :3]), np.abs(samples[:, 3:]).max(axis=1, keepdims=True)
    parts = ((rate, rate_full_scale), (np.repeat(force, 3, axis=1), assumptions.full_scale))
    clipped = [np.where(size > CLIPPING_SHARE * full, CLIPPED_SHARE * size, 0.0) ** 2 for size, full in parts]
    return np.hstack(clipped)


def _psd(std: float, correlation_s: float) -> float:
    """Return the PSD of a motion of a standard deviation and a correlation time, taken for white noise."""
    return 2 * std**2 * correlation_s


def _constants(assumptions: WalkAssumptions) -> _Constants:
    """Return the constants."""
    rate_psd = _psd(assumptions.rate_std, assumptions.rate_correlation_s)
    return _Constants(rate_psd, assumptions.gravity, assumptions.floor_std**2)


def _initial_state(force: np.ndarray, states: SensorStates, assumptions: WalkAssumptions, begin: _Start) -> _State:
    """Return the state at the first sample, levelled by the mean specific force of the stand, with heading zero."""
    force = force - states.fixed[3:]
    stood = from_euler((*level(force), 0.0))
    first = stood * begin.turn.inv()
    north = from_euler((0.0, 0.0, -float(to_euler(first)[2])))
    tilted = level_sensitivity(force, (north * stood).as_matrix(), states, assumptions.gravity)
    arms = [assumptions.arm_std**2] * len(LEVER_ARM) if assumptions.arm_std > 0 else []
    floor = [assumptions.floor_std**2] if assumptions.floor_std > 0 else []
    covariance = np.diag([0.0] * NAVIGATION + [*states.variance, *arms, *floor])
    covariance[range(VELOCITY, ATTITUDE), range(VELOCITY, ATTITUDE)] = begin.velocity_std**2
    sensors, level_rows = slice(NAVIGATION, NAVIGATION + len(states)), slice(ATTITUDE, ATTITUDE + 2)
    covariance[level_rows, sensors] = tilted * states.variance
    covariance[sensors, level_rows] = covariance[level_rows, sensors].T
    covariance[level_rows, level_rows] = tilted * states.variance @ tilted.T + begin.tilt_std**2 * np.eye(2)
    errors = np.zeros(len(covariance) - NAVIGATION)
    start = np.concatenate([np.zeros(6), (north * first).as_quat()])
    return _State(start, errors, covariance, np.full(1, np.inf))
