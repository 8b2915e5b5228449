"""Motions in closed form: every angle and acceleration is a sum of sines, with its derivatives known at any time.

Angles are roll, pitch, heading from north, east, down to the body.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from imu_benchmark.log import ACCEL, AXES, GYRO

GRAVITY = 9.81


@dataclass(frozen=True, eq=False)
class SineSums:
    """Three sums of sines: ``amplitude``, ``frequency`` [Hz] and ``phase`` [rad], each of shape (3, m)."""

    amplitude: np.ndarray
    frequency: np.ndarray
    phase: np.ndarray

    def at(self, time: np.ndarray, derivative: int = 0) -> np.ndarray:
        """Return the sums at ``time`` [s], shape (n,), or their derivative, shape (3, n)."""
        omega = 2 * np.pi * self.frequency
        amplitude, phase = self.amplitude * omega**derivative, self.phase + derivative * np.pi / 2
        total = np.zeros((3, len(time)))
        for row, *sines in zip(total, amplitude, omega, phase, strict=True):
            for a, w, p in zip(*sines, strict=True):
                row += a * np.sin(w * time + p)
        return total


@dataclass(frozen=True, eq=False)
class AnalyticMotion:
    """A motion: Euler angles [rad] relative to the initial ones, acceleration [m/s^2] in the navigation frame."""

    start: np.ndarray
    angles: SineSums
    acceleration: SineSums

    def ideal(self, time: np.ndarray) -> pd.DataFrame:
        """Return the error-free log of six axes at the instants ``time`` [s]."""
        euler = self.start[:, None] + self.angles.at(time)
        first = self.angles.at(time, 1)
        force = self.acceleration.at(time) - np.array([[0.0], [0.0], [GRAVITY]])
        sensed = Rotation.from_euler("ZYX", euler[::-1].T).inv().apply(force.T)
        columns = [*body_rate(euler, first), *sensed.T]
        return pd.DataFrame(dict(zip(AXES, columns, strict=True)), index=pd.Index(time, name="time"))

    def angular_acceleration(self, time: np.ndarray) -> np.ndarray:
        """Return the derivative of the body's angular rate [rad/s^2], shape (3, n)."""
        roll, pitch, _ = self.start[:, None] + self.angles.at(time)
        (u, v, w), second = self.angles.at(time, 1), self.angles.at(time, 2)
        turned = body_rate(np.array([roll, pitch, roll]), second)
        zero = np.zeros(len(time))
        by_roll = u * np.array([zero, -v * np.sin(roll) + w * np.cos(pitch) * np.cos(roll),
                                -v * np.cos(roll) - w * np.cos(pitch) * np.sin(roll)])  # fmt: skip
        by_pitch = v * w * np.array([-np.cos(pitch), -np.sin(pitch) * np.sin(roll), -np.sin(pitch) * np.cos(roll)])
        return turned + by_roll + by_pitch

    def arm(self, time: np.ndarray) -> np.ndarray:
        """Return the matrices, shape (n, 3, 3), from a lever arm [m] to the specific force that it adds."""
        rate = self.ideal(time)[list(GYRO)].to_numpy()
        return cross(rate) @ cross(rate) + cross(self.angular_acceleration(time).T)


def body_rate(euler: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the angular rate in the body, shape (3, n), from Euler angles and their derivatives."""
    (roll, pitch, _), (u, v, w) = euler, slope
    return np.array([
        u - w * np.sin(pitch),
        v * np.cos(roll) + w * np.cos(pitch) * np.sin(roll),
        -v * np.sin(roll) + w * np.cos(pitch) * np.cos(roll),
    ])  # fmt: skip


def cross(vectors: np.ndarray) -> np.ndarray:
    """Return the matrices, shape (n, 3, 3), of the cross products with ``vectors``, shape (n, 3)."""
    x, y, z = vectors.T
    zero = np.zeros(len(x))
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def draw_sines(
    rng: np.random.Generator, sizes: tuple[float, float, float], band: tuple[float, float], count: int
) -> SineSums:
    """Draw ``count`` sines within ``band`` [Hz] for each of three sums of standard deviations ``sizes``."""
    share = rng.dirichlet(np.full(count, 3.0), 3)
    amplitude = np.sqrt(2 * share) * np.asarray(sizes)[:, None]
    frequency = np.exp(rng.uniform(*np.log(band), (3, count)))
    return SineSums(amplitude, frequency, rng.uniform(0, 2 * np.pi, (3, count)))


def combined(*parts: SineSums) -> SineSums:
    """Return the sum of several sums of sines."""
    return SineSums(*(np.hstack([getattr(part, n) for part in parts]) for n in ("amplitude", "frequency", "phase")))


def modulated(carrier: SineSums, beat_hz: float) -> SineSums:
    """Return ``carrier`` times 1 - cos(2 pi beat t): each sine with two side lines."""
    sides = [
        SineSums(-carrier.amplitude / 2, carrier.frequency + shift, carrier.phase) for shift in (-beat_hz, beat_hz)
    ]
    return combined(carrier, *sides)


def rest() -> AnalyticMotion:
    """Return the motion of a level device at rest."""
    none = SineSums(*np.zeros((3, 3, 0)))
    return AnalyticMotion(np.zeros(3), none, none)


def hand(rng: np.random.Generator) -> AnalyticMotion:
    """Draw hand-held swings: turns of some tenths of a radian, accelerations of some m/s^2, at 0.1 to 2 Hz."""
    start = np.array([*rng.uniform(-0.3, 0.3, 2), rng.uniform(-np.pi, np.pi)])
    return AnalyticMotion(
        start, draw_sines(rng, (0.35, 0.25, 0.6), (0.1, 1.5), 6), draw_sines(rng, (1.5, 1.5, 1.2), (0.3, 2.0), 6)
    )


def vehicle(rng: np.random.Generator) -> AnalyticMotion:
    """Draw a drive: slow turns, small roll and pitch, and bursts of vibration at 3 to 9 Hz on the acceleration."""
    start = np.array([*rng.uniform(-0.05, 0.05, 2), rng.uniform(-np.pi, np.pi)])
    turns = combined(
        draw_sines(rng, (0.0, 0.0, 1.2), (0.01, 0.06), 5), draw_sines(rng, (0.03, 0.03, 0.005), (0.2, 1.5), 5)
    )
    shaking = modulated(draw_sines(rng, (0.5, 0.5, 1.0), (3.0, 9.0), 5), 1 / rng.uniform(30, 120))
    return AnalyticMotion(start, turns, combined(draw_sines(rng, (0.8, 0.8, 0.1), (0.01, 0.2), 5), shaking))


MOTIONS = {"hand": hand, "vehicle": vehicle}
AXIS_NUMBER = {axis: number for triad in (GYRO, ACCEL) for number, axis in enumerate(triad)}
