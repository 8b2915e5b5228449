"""Simulated walk of a foot with a device on it: one smooth motion gives position, angular rate and specific force.

The contact point of the foot and its attitude are designed stride by stride on a grid: a swing, in which the point
moves forward, up and down while the foot pitches nose down at the push and nose up before the strike; then a stance, in
which the point rests and the foot rolls over it. The device is at an arm from that point. Both are interpolated by
splines of fifth order, which are the truth (:mod:`imugap.simulation.flight`). Earth rate is neglected.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.interpolate import BSpline, make_interp_spline

from imugap.io.references import reference
from imugap.kinematics.site import Site
from imugap.kinematics.strapdown import ATTITUDE, COLUMNS, POSITION, VELOCITY
from imugap.model import ErrorModel
from imugap.numerics.rotation import from_euler, to_euler
from imugap.simulation.flight import ORDER, ideal, step
from imugap.stream import stream

GRID_S = 0.002
"""Step of the design [s]."""
IMPACT_PERIODS = 2.0
"""Length of an impact, in periods of its vibration."""


@dataclass(frozen=True)
class Gait:
    """Gait of a foot.

    Attributes
    ----------
    stride_s, swing_share
        Length of a stride [s] and the share of it in which the foot swings.
    length_m, clearance_m
        Length of a full stride and lift of the foot in its swing [m].
    push_deg, strike_deg
        Pitch, nose down at the push and nose up before the strike [deg].
    roll_deg
        Pitch, nose up, that the foot takes and gives back at stance [deg].
    drift_m_per_s
        Standard deviation of the mean velocity of the point on the ground at a stance, each axis [m/s].
    impact_m_per_s2, impact_hz
        Amplitude of the vibration after a strike, down and half of it forward [m/s^2], and its frequency [Hz].
    """

    stride_s: float = 1.1
    swing_share: float = 0.6
    length_m: float = 1.35
    clearance_m: float = 0.08
    push_deg: float = 55.0
    strike_deg: float = 20.0
    roll_deg: float = 3.0
    drift_m_per_s: float = 0.0
    impact_m_per_s2: float = 40.0
    impact_hz: float = 25.0


@dataclass(frozen=True)
class WalkLeg:
    """Number of equal strides, turn of each [deg], rise of each [m], and share of a full length (0: on the spot)."""

    strides: int
    turn_deg: float = 0.0
    rise_m: float = 0.0
    share: float = 1.0


@dataclass(frozen=True)
class WalkCourse:
    """A stand [s], legs, and a stand."""

    stand_s: float
    legs: tuple[WalkLeg, ...]
    end_s: float

    @classmethod
    def out_and_back(cls, strides: int, stand_s: float = 5.0, end_s: float = 2.0) -> "WalkCourse":
        """Go straight out, turn on the spot, come back and turn again: position and heading close exactly."""
        half = (WalkLeg(strides), WalkLeg(3, turn_deg=60.0, share=0.0))
        return cls(stand_s, half * 2, end_s)

    @classmethod
    def loop(cls, strides: int, stand_s: float = 5.0, end_s: float = 2.0) -> "WalkCourse":
        """Walk a circle of so many strides: position and heading close exactly."""
        return cls(stand_s, (WalkLeg(strides, turn_deg=360.0 / strides),), end_s)

    def strides(self) -> Iterator[WalkLeg]:
        """Iterate over the strides."""
        for leg in self.legs:
            yield from [leg] * leg.strides


@dataclass(frozen=True, eq=False)
class FootMotion:
    """The motion of a device: position [m] in ``n`` and Euler angles of ``b`` [rad] over time [s]."""

    position: BSpline
    euler: BSpline


@dataclass(frozen=True)
class Walk:
    """A recipe: gait, course, device, site, rate, and where the point on the ground lies, in ``b`` [m]."""

    gait: Gait
    course: WalkCourse
    model: ErrorModel
    site: Site
    rate_hz: float
    contact_m: tuple[float, float, float] = (0.05, 0.0, 0.06)

    @classmethod
    def read(cls, path: str | Path) -> "Walk":
        """Read a recipe (YAML with ``gait``, ``course``, ``model``, ``site``, ``rate_hz`` and ``contact_m``)."""
        recipe = yaml.safe_load(Path(path).read_text())
        try:
            course = recipe["course"] | {"legs": tuple(WalkLeg(**leg) for leg in recipe["course"]["legs"])}
            return cls(
                Gait(**recipe["gait"]),
                WalkCourse(**course),
                ErrorModel.from_mapping(recipe["model"]),
                Site.from_mapping(recipe["site"]),
                recipe["rate_hz"],
                tuple(recipe["contact_m"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a recipe with gait, course, model, site; found {error}") from error

    @property
    def duration_s(self) -> float:
        """Length of the walk [s], both stands included."""
        count = sum(leg.strides for leg in self.course.legs)
        return self.course.stand_s + count * self.gait.stride_s + self.course.end_s

    def times(self) -> np.ndarray:
        """Return the stamps of the samples [s]; each sample is the mean over the interval that ends there."""
        return np.arange(1, round(self.duration_s * self.rate_hz) + 1) / self.rate_hz

    def motion(self, run: int, seed: int) -> FootMotion:
        """Return the motion on walk ``run``; without drift at stance all walks are one."""
        return _motion(self.gait, self.course, self.contact_m, *((run, seed) if self.gait.drift_m_per_s else (0, 0)))

    def truth(self, run: int, seed: int) -> pd.DataFrame:
        """Return the true Trajectory at the stamps, with the columns of a Reference."""
        time, motion = self.times(), self.motion(run, seed)
        table = pd.DataFrame(index=pd.Index(time, name="time"), columns=list(COLUMNS), dtype=float)
        euler = motion.euler(time)
        table[list(POSITION)] = motion.position(time) - motion.position(0.0)
        table[list(VELOCITY)] = motion.position.derivative()(time)
        table[list(ATTITUDE)] = to_euler(from_euler(euler))
        moving = (time > self.course.stand_s) & (time < self.duration_s - self.course.end_s)
        return table.join(reference.from_rotations(time, from_euler(euler), moving))

    def ideal(self, run: int, seed: int) -> pd.DataFrame:
        """Return the output of an error-free device on walk ``run``."""
        motion = self.motion(run, seed)
        return ideal(self.times(), 1 / self.rate_hz, motion.position.derivative(2), motion.euler, self.site.gravity)

    def record(self, run: int, seed: int) -> pd.DataFrame:
        """Return the log of the device on walk ``run``."""
        return self.model.simulate(self.ideal(run, seed), seed, "walk", run)

    def static(self, run: int, duration: float, seed: int) -> pd.DataFrame:
        """Return a static log of the device, level, ``duration`` [s] long: run ``run`` of its calibration."""
        rest = self.site.rest(round(duration * self.rate_hz), 1 / self.rate_hz)
        return self.model.simulate(rest, seed, "static", run)


@lru_cache(maxsize=4)
def _motion(gait: Gait, course: WalkCourse, contact: tuple[float, float, float], run: int, seed: int) -> FootMotion:
    """Design contact point and foot attitude stride by stride, and place the device on them."""
    strides = list(course.strides())
    time = np.arange(-0.1, course.stand_s + len(strides) * gait.stride_s + course.end_s + 0.1, GRID_S)
    point, euler = np.zeros((len(time), 3)), np.zeros((len(time), 3))
    drift = gait.drift_m_per_s * stream(seed, "gait", run).standard_normal((len(strides), 3))
    heading, swing = 0.0, gait.stride_s * gait.swing_share
    reach = gait.stride_s + IMPACT_PERIODS / gait.impact_hz
    for number, leg in enumerate(strides):
        begin = course.stand_s + number * gait.stride_s
        first, done = np.searchsorted(time, [begin, begin + reach], "right")
        rows, since = slice(first, done), time[first:done] - begin
        x, y = since / swing, (since - swing) / (gait.stride_s - swing)
        turn = np.radians(leg.turn_deg)
        along = np.array([np.cos(heading + turn / 2), np.sin(heading + turn / 2), 0.0])
        advance = gait.length_m * leg.share * along - [0, 0, leg.rise_m]
        slip = drift[number] * (gait.stride_s - swing)
        point[rows] += step(x)[:, None] * advance + step(y)[:, None] * slip
        point[rows, 2] -= gait.clearance_m * _bump(x)
        point[rows] += _impact(gait, since - swing)[:, None] * (along / 2 + [0, 0, 1])
        euler[rows, 1] += np.radians(gait.strike_deg) * _bump(2 * x - 1) - np.radians(gait.push_deg) * _bump(x / 0.7)
        euler[rows, 1] += np.radians(gait.roll_deg) * _bump(y)
        euler[rows, 2] += turn * step(x)
        point[done:] += advance + slip
        euler[done:, 2] += turn
        heading += turn
    device = point - from_euler(euler).apply(contact)
    return FootMotion(make_interp_spline(time, device, ORDER), make_interp_spline(time, euler, ORDER))


def _bump(x: np.ndarray) -> np.ndarray:
    """Return a bump of height 1 between 0 and 1 with two continuous derivatives, and 0 elsewhere."""
    x = np.clip(x, 0, 1)
    return (4 * x * (1 - x)) ** 3


def _impact(gait: Gait, since: np.ndarray) -> np.ndarray:
    """Return the displacement [m] at times since the strike [s]."""
    turn = 2 * np.pi * gait.impact_hz
    return gait.impact_m_per_s2 / turn**2 * np.sin(turn * since) * _bump(since * gait.impact_hz / IMPACT_PERIODS)
