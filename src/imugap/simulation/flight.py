"""Simulated flight of a small aircraft: one smooth course gives attitude, angular rate and specific force.

Velocity and Euler angles are designed on a grid and interpolated by splines of fifth order, which are the truth: the
specific force follows from the derivative of the velocity, the angular rate from that of the angles, and both are
averaged over the sampling intervals. Earth rate is neglected, as in :class:`imugap.kinematics.strapdown.Local`.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.interpolate import BSpline, make_interp_spline

from imugap import log
from imugap.io.references import reference
from imugap.kinematics.site import Site
from imugap.kinematics.strapdown import ATTITUDE, COLUMNS, POSITION, VELOCITY
from imugap.model import ErrorModel
from imugap.numerics.rotation import from_euler, rate_from_euler

GRID_S = 0.1
"""Step of the design [s]."""
ORDER = 5
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class Swing:
    """A harmonic of the velocity."""

    amplitude_m_per_s: float
    period_s: float

    def at(self, time: np.ndarray) -> np.ndarray:
        """Return the value [m/s] at ``time`` [s]."""
        return self.amplitude_m_per_s * np.sin(2 * np.pi * time / self.period_s)


@dataclass(frozen=True)
class Turn:
    """A change of heading that begins and ends smoothly."""

    start_s: float
    duration_s: float
    angle_deg: float

    def at(self, time: np.ndarray) -> np.ndarray:
        """Return the heading gained [rad]."""
        return np.radians(self.angle_deg) * step((time - self.start_s) / self.duration_s)


@dataclass(frozen=True)
class Disturbance:
    """Swings of the attitude and of the side velocity under a sine-squared envelope."""

    start_s: float
    duration_s: float
    period_s: float
    roll_deg: float
    pitch_deg: float
    heading_deg: float
    side_m_per_s: float

    def at(self, time: np.ndarray) -> np.ndarray:
        """Return the swing for an amplitude of one."""
        since = np.clip(time - self.start_s, 0, self.duration_s)
        return np.sin(np.pi * since / self.duration_s) ** 2 * np.sin(2 * np.pi * since / self.period_s)


@dataclass(frozen=True)
class FlightCourse:
    """How the aircraft rests, is launched and flies: the keys of ``course`` in a recipe."""

    rest_s: float
    launch_s: float
    flight_s: float
    speed_m_per_s: float
    speed_swing: Swing
    climb_swing: Swing
    trim_pitch_deg: float
    heading_deg: float
    turns: tuple[Turn, ...]
    disturbance: Disturbance

    @classmethod
    def from_mapping(cls, mapping: dict) -> "FlightCourse":
        """Build from plain data."""
        parts = {
            "speed_swing": Swing(**mapping["speed_swing"]),
            "climb_swing": Swing(**mapping["climb_swing"]),
            "turns": tuple(Turn(**turn) for turn in mapping["turns"]),
            "disturbance": Disturbance(**mapping["disturbance"]),
        }
        return cls(**(mapping | parts))

    @property
    def begin_s(self) -> float:
        """Time of the first sample [s]."""
        return -self.launch_s - self.rest_s

    def splines(self, gravity: float) -> tuple[BSpline, BSpline]:
        """Return velocity [m/s] and Euler angles [rad] over time [s]; the bank is that of a coordinated turn."""
        time = np.arange(self.begin_s - 1, self.flight_s + 1, GRID_S)
        launched, gust = step(time / self.launch_s + 1), self.disturbance.at(time)
        speed = launched * (self.speed_m_per_s + self.speed_swing.at(time))
        climb = launched * self.climb_swing.at(time)
        course = np.radians(self.heading_deg) + sum(turn.at(time) for turn in self.turns)
        along = np.column_stack([np.cos(course), np.sin(course)])
        across = np.column_stack([-along[:, 1], along[:, 0]])
        side = self.disturbance.side_m_per_s * gust
        velocity = np.column_stack([speed[:, None] * along + side[:, None] * across, -climb])
        rate = make_interp_spline(time, course, ORDER).derivative()(time)
        swing = np.radians([self.disturbance.roll_deg, self.disturbance.pitch_deg, self.disturbance.heading_deg])
        pitch = launched * np.radians(self.trim_pitch_deg) + climb / self.speed_m_per_s
        euler = np.column_stack([np.arctan(speed * rate / gravity), pitch, course]) + gust[:, None] * swing
        return make_interp_spline(time, velocity, ORDER), make_interp_spline(time, euler, ORDER)


@dataclass(frozen=True)
class Flight:
    """A recipe: the course, the device, the site and the rate."""

    course: FlightCourse
    model: ErrorModel
    site: Site
    rate_hz: float

    @classmethod
    def read(cls, path: str | Path) -> "Flight":
        """Read a recipe (YAML with ``course``, ``model``, ``site`` and ``rate_hz``)."""
        recipe = yaml.safe_load(Path(path).read_text())
        try:
            return cls(
                FlightCourse.from_mapping(recipe["course"]),
                ErrorModel.from_mapping(recipe["model"]),
                Site.from_mapping(recipe["site"]),
                recipe["rate_hz"],
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a recipe with course, model, site, rate_hz; found {error}") from error

    def times(self) -> np.ndarray:
        """Return the stamps of the samples [s]; each sample is the mean over the interval that ends there."""
        course = self.course
        count = round((course.flight_s - course.begin_s) * self.rate_hz)
        return course.begin_s + np.arange(1, count + 1) / self.rate_hz

    def truth(self) -> pd.DataFrame:
        """Return the true Trajectory at the stamps, with the columns of a Reference; the scored flight is "moving"."""
        time = self.times()
        velocity, euler = self.course.splines(self.site.gravity)
        position = velocity.antiderivative()
        table = pd.DataFrame(index=pd.Index(time, name="time"), columns=list(COLUMNS), dtype=float)
        table[list(POSITION)] = position(time) - position(self.course.begin_s)
        table[list(VELOCITY)], table[list(ATTITUDE)] = velocity(time), euler(time)
        return table.join(reference.from_rotations(time, from_euler(euler(time)), time >= 0))

    def ideal(self) -> pd.DataFrame:
        """Return the output of an error-free device: interval means of angular rate and specific force."""
        velocity, euler = self.course.splines(self.site.gravity)
        return ideal(self.times(), 1 / self.rate_hz, velocity.derivative(), euler, self.site.gravity)

    def fly(self, run: int, seed: int) -> pd.DataFrame:
        """Return the log of the device aboard on flight ``run``: rest, launch and flight."""
        return self.model.simulate(self.ideal(), seed, "flight", run)

    def static(self, run: int, duration: float, seed: int) -> pd.DataFrame:
        """Return a static log of the device, level, ``duration`` [s] long, ahead of flight ``run``."""
        rest = self.site.rest(round(duration * self.rate_hz), 1 / self.rate_hz)
        return self.model.simulate(rest, seed, "static", run)


def ideal(time: np.ndarray, interval: float, acceleration: BSpline, euler: BSpline, gravity: float) -> pd.DataFrame:
    """Return the output of an error-free device: interval means of angular rate and specific force.

    Parameters
    ----------
    time, interval
        Ends of the intervals [s], shape (n,), and their length [s].
    acceleration, euler
        Acceleration in ``n`` [m/s^2] and roll, pitch, heading [rad] over time [s].
    """
    inner = (time[:, None] + (NODES - 1) / 2 * interval).ravel()
    angles = euler(inner)
    rate = rate_from_euler(angles, euler.derivative()(inner))
    force = from_euler(angles).inv().apply(acceleration(inner) - [0, 0, gravity])
    means = np.tensordot(np.hstack([rate, force]).reshape(len(time), len(NODES), 6), WEIGHTS / 2, ([1], [0]))
    return log.check(pd.DataFrame(means, index=pd.Index(time, name="time"), columns=list(log.AXES)))


def step(x: np.ndarray) -> np.ndarray:
    """Return 0 below 0, 1 above 1, and between them a step with two continuous derivatives."""
    x = np.clip(x, 0, 1)
    return x**3 * (10 + x * (6 * x - 15))
