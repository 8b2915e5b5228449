"""Simulated drive through a town: one smooth path gives position, attitude, and the output of an ideal device.

Legs (a rest, a speed, a turn) become smooth functions of time on a grid, and splines of fifth order of speed, course,
slope and bank. The rear axle follows the road, except for tyre slip; the device ahead of it swings out in a turn. At
the stamps velocity and attitude of the device are those of the splines. The ideal output of each interval is the one
with which the navigator (:mod:`imugap.kinematics.strapdown`, the ellipsoid in full) gets from one stamp to the next:
the inverted mechanisation, exact to rounding for any interval. The position is that of the navigator. Truth and ideal
output therefore satisfy the equations of the filter exactly.
"""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from numba import njit
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from imugap import log
from imugap.effects import ScaleFactor, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.io import gnss
from imugap.io.references import reference
from imugap.kinematics.strapdown import ATTITUDE, COLUMNS, POSITION, VELOCITY, Ellipsoid, ellipsoid_step, increments
from imugap.log import ACCEL, AXES, GYRO
from imugap.model import ErrorModel
from imugap.numerics.rotation import add_scaled, from_euler, kernel, multiply, to_euler
from imugap.simulation.flight import ORDER, step
from imugap.stream import stream

GRID_S = 0.1
"""Step of the design [s]."""
STEP_S = 1e-3
"""Step of difference quotients [s]."""
ROUNDS = 5
"""Iterations of the inversion; each reduces the error to a hundredth or less."""


@dataclass(frozen=True)
class DriveLeg:
    """Leg of a drive.

    Attributes
    ----------
    duration_s
        Duration [s].
    speed_m_per_s
        Speed at its end, reached smoothly over ``change_s`` from its begin (over the whole leg if 0).
    turn_deg
        Change of heading over the leg, smooth.
    slope_deg
        Slope of the road at its end, up.
    """

    duration_s: float
    speed_m_per_s: float
    turn_deg: float = 0.0
    slope_deg: float = 0.0
    change_s: float = 0.0


@dataclass(frozen=True)
class Axle:
    """Rear axle, which follows the road except for tyre slip.

    Attributes
    ----------
    arm_m
        From the device to its middle, in ``b``.
    slip
        Outward slip angle per lateral acceleration [rad s^2/m].
    std_m_per_s, correlation_s
        Assumptions of a filter on its velocity across and up (:mod:`imugap.filters.nonholonomic`).
    """

    arm_m: tuple[float, float, float]
    slip: float
    std_m_per_s: float
    correlation_s: float


@dataclass(frozen=True)
class Receiver:
    """GNSS receiver: rate, white noise of position [m] and velocity [m/s] (north, east, down), and lever arm.

    ``delay_s`` is the time of the log minus the stamp of a fix.
    """

    rate_hz: float
    position_std: tuple[float, float, float]
    velocity_std: tuple[float, float, float]
    lever_m: tuple[float, float, float]
    delay_s: float = 0.0


@dataclass(frozen=True)
class Drive:
    """A recipe: legs, device, receiver, site and rate."""

    legs: tuple[DriveLeg, ...]
    laps: int
    heading_deg: float
    bank: float
    axle: Axle
    model: ErrorModel
    scale_std: tuple[float, float]
    receiver: Receiver
    ellipsoid: Ellipsoid
    rate_hz: float

    @classmethod
    def read(cls, path: str | Path) -> "Drive":
        """Read a recipe (YAML): ``course``, ``axle``, ``model``, ``scale_std``, ``receiver``, ``site``, ``rate_hz``."""
        recipe = yaml.safe_load(Path(path).read_text())

        def given(part: dict) -> dict:
            return {key: tuple(value) if isinstance(value, list) else value for key, value in part.items()}

        try:
            course, site = recipe["course"], recipe["site"]
            return cls(
                tuple(DriveLeg(**leg) for leg in course["legs"]),
                course["laps"],
                course["heading_deg"],
                course["bank"],
                Axle(**given(recipe["axle"])),
                ErrorModel.from_mapping(recipe["model"]),
                tuple(recipe["scale_std"]),
                Receiver(**given(recipe["receiver"])),
                Ellipsoid(np.radians(site["latitude_deg"]), np.radians(site["longitude_deg"]), site["height_m"]),
                recipe["rate_hz"],
            )
        except (KeyError, TypeError, ValueError) as error:
            expected = "a recipe with course, axle, model, receiver, site"
            raise ValueError(f"{path}: expected {expected}; found {error}") from error

    @property
    def duration_s(self) -> float:
        """Length of the drive [s]."""
        return self.laps * sum(leg.duration_s for leg in self.legs)

    @property
    def path(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """True Trajectory with the columns of a Reference, and the output of an error-free device."""
        return _path(self.legs, self.laps, self.heading_deg, self.bank, self.axle, self.ellipsoid, self.rate_hz)

    def device(self, run: int, seed: int) -> ErrorModel:
        """Return the model of the device of ``run``, with drawn scale factors."""
        drawn = stream(seed, "scale", run).standard_normal(len(AXES)) * np.repeat(self.scale_std, 3)
        own = {
            axis: self.model.axes.get(axis, AxisModel()) + ScaleFactor(error=float(error))
            for axis, error in zip(AXES, drawn, strict=True)
        }
        return ErrorModel(own)

    def record(self, run: int, seed: int) -> pd.DataFrame:
        """Return the log of the device on drive ``run``."""
        return self.device(run, seed).simulate(self.path[1], seed, "drive", run)

    def errors(self, run: int, seed: int) -> pd.DataFrame:
        """Return the true sensor errors on drive ``run`` that filter states estimate: all but white noise.

        Columns are the axes, and the axes with ``_scale`` for the scale factors.
        """
        device, ideal = self.device(run, seed), self.path[1]
        slow = {axis: _without(model, WhiteNoise, ScaleFactor) for axis, model in device.axes.items()}
        table = ErrorModel(slow).simulate(ideal, seed, "drive", run) - ideal
        return table.assign(**{f"{axis}_scale": model.effects[-1].error for axis, model in device.axes.items()})

    def antenna(self) -> pd.DataFrame:
        """Return error-free fixes, with columns :data:`imugap.io.gnss.COMPONENTS`."""
        truth, ideal = self.path
        every = round(self.rate_hz / self.receiver.rate_hz)
        rows = np.arange(every, len(truth), every)
        turn, rate = reference.rotations(truth.iloc[rows]), ideal[list(GYRO)].to_numpy()
        after = np.minimum(rows + 1, len(truth) - 1)
        lever = np.array(self.receiver.lever_m)
        place = truth[list(POSITION)].to_numpy()[rows] + turn.apply(lever)
        swing = np.cross((rate[rows] + rate[after]) / 2, lever)
        velocity = truth[list(VELOCITY)].to_numpy()[rows] + turn.apply(swing)
        return pd.DataFrame(np.hstack([place, velocity]), index=truth.index[rows], columns=list(gnss.COMPONENTS))

    def fixes(self, run: int, seed: int) -> pd.DataFrame:
        """Return the log of the receiver on drive ``run``, without gross errors."""
        true = self.antenna()
        std = np.tile([*self.receiver.position_std, *self.receiver.velocity_std], (len(true), 1))
        seen = true.to_numpy() + std * stream(seed, "receiver", run).standard_normal(std.shape)
        return gnss.from_local(true.index.to_numpy() - self.receiver.delay_s, seen, std, self.ellipsoid)


def _without(model: AxisModel, *kinds: type) -> AxisModel:
    return AxisModel(tuple(effect for effect in model if not isinstance(effect, kinds)))


@lru_cache(maxsize=4)
def _path(
    legs: tuple[DriveLeg, ...],
    laps: int,
    heading_deg: float,
    bank: float,
    axle: Axle,
    ellipsoid: Ellipsoid,
    rate_hz: float,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Design the path, and invert the mechanisation along it."""
    duration = laps * sum(leg.duration_s for leg in legs)
    time = np.arange(round(duration * rate_hz) + 1) / rate_hz
    grid = np.arange(-1, duration + 1, GRID_S)
    speed, course, slope = (make_interp_spline(grid, one, ORDER) for one in _design(legs * laps, heading_deg, grid))
    turning, surge = course.derivative(), speed.derivative()

    def attitude(at: np.ndarray) -> Rotation:
        lean, squat = -bank * speed(at) * turning(at), bank * surge(at)
        return from_euler(np.column_stack([lean, slope(at) + squat, course(at)]))

    way = course(time) - axle.slip * speed(time) * turning(time)
    climb, rotation = slope(time), attitude(time)
    level = np.column_stack([np.cos(way), np.sin(way)]) * (speed(time) * np.cos(climb))[:, None]
    swing = (attitude(time + STEP_S).apply(axle.arm_m) - attitude(time - STEP_S).apply(axle.arm_m)) / (2 * STEP_S)
    velocity = np.column_stack([level, -speed(time) * np.sin(climb)]) - swing
    origin = ellipsoid.origin
    place, rate, force = _invert(time, velocity, rotation.as_quat(), origin)
    table = pd.DataFrame(index=pd.Index(time, name=log.TIME), columns=list(COLUMNS), dtype=float)
    table[list(POSITION)], table[list(VELOCITY)], table[list(ATTITUDE)] = place, velocity, to_euler(rotation)
    truth = table.join(reference.from_rotations(time, rotation, speed(time) > 0.1))
    samples = dict(zip((*GYRO, *ACCEL), np.hstack([rate, force]).T, strict=True))
    return truth, log.check(pd.DataFrame(samples, index=table.index)[list(AXES)])


def _design(
    legs: tuple[DriveLeg, ...], heading_deg: float, grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return speed [m/s], course and slope [rad] on the grid."""
    begin, speed, slope = 0.0, 0.0, 0.0
    found = np.zeros((3, len(grid)))
    found[1] = np.radians(heading_deg)
    for leg in legs:
        since = grid - begin
        found[0] += (leg.speed_m_per_s - speed) * step(since / (leg.change_s or leg.duration_s))
        found[1] += np.radians(leg.turn_deg) * step(since / leg.duration_s)
        found[2] += np.radians(leg.slope_deg - slope) * step(since / leg.duration_s)
        begin, speed, slope = begin + leg.duration_s, leg.speed_m_per_s, leg.slope_deg
    return found[0], found[1], found[2]


@kernel
def _row(table, k):
    return table[k, 0], table[k, 1], table[k, 2]


@kernel
def _against(quat, other):
    """Return the product of the inverse of ``quat`` and ``other``."""
    return multiply((-quat[0], -quat[1], -quat[2], quat[3]), other)


@njit(cache=True)
def _invert(time, velocity, quat, origin):
    """Return positions, and the rates and specific forces whose navigation gives velocity and attitude at each stamp.

    The step is linear in the increments to first order: the residual is added to rate and force, iteratively. The first
    sample, which only the corrections of the second use, equals the second.
    """
    count = len(time)
    place, rate, force = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3))
    for k in range(1, count):
        dt = time[k] - time[k - 1]
        w, f = _row(rate, k - 1), _row(force, k - 1)
        start = (quat[k - 1, 0], quat[k - 1, 1], quat[k - 1, 2], quat[k - 1, 3])
        aim = (quat[k, 0], quat[k, 1], quat[k, 2], quat[k, 3])
        for _ in range(ROUNDS):
            w0, f0 = (_row(rate, k - 1), _row(force, k - 1)) if k > 1 else (w, f)
            rotvec, delta_v = increments(w, f, w0, f0, dt, dt)
            found = ellipsoid_step(_row(place, k - 1), _row(velocity, k - 1), start, rotvec, delta_v, dt, origin)
            miss = _against(found[2], aim)
            scale = np.copysign(2 / dt, miss[3])
            short = add_scaled(_row(velocity, k), -1.0, found[1])
            back = _against(found[2], multiply((short[0], short[1], short[2], 0.0), found[2]))
            w, f = add_scaled(w, scale, (miss[0], miss[1], miss[2])), add_scaled(f, 1 / dt, (back[0], back[1], back[2]))
            for i in range(3):
                place[k, i], rate[k, i], force[k, i] = found[0][i], w[i], f[i]
    for i in range(3):
        rate[0, i], force[0, i] = rate[1, i], force[1, i]
    return place, rate, force
