"""Hidden effects that only a motion shows: residuals against the input, other inputs, and their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.benchmark.sealing.hidden_effect import Kind, Ranges, Scene, Waveform, direction, sign
from imugap.benchmark.sealing.motion import AXIS_NUMBER
from imugap.log import ACCEL, AXES, GYRO

NUDGE_S = 1e-3
"""Half the difference of time that derivatives of the input are taken over."""


@dataclass(frozen=True)
class Inertial(Waveform):
    """A known signal of the motion. Limit: the matched test."""

    motion: ClassVar[bool] = True


@dataclass(frozen=True)
class ScaleFactor(Inertial):
    """Error x u + asymmetry x |u| + nonlinearity x u^2 of the input u, one of the three. Limit: the matched test."""

    name: ClassVar[str] = "scale_factor"
    scaled: ClassVar = ("error", "asymmetry", "nonlinearity")
    error: float = 0.0
    asymmetry: float = 0.0
    nonlinearity: float = 0.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "ScaleFactor":
        """Draw which of the three, and the sign."""
        return cls(**{str(rng.choice(cls.scaled, p=(0.6, 0.2, 0.2))): sign(rng)})

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the polynomial in the input."""
        u = scene.ideal[scene.axis].to_numpy()
        return self.error * u + self.asymmetry * np.abs(u) + self.nonlinearity * u**2


@dataclass(frozen=True)
class Misalignment(Inertial):
    """What an axis senses of the two others of its triad. Limit: the matched test along the drawn direction."""

    name: ClassVar[str] = "misalignment"
    scaled: ClassVar = ("x", "y", "z")
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Misalignment":
        """Draw the direction, across the own axis."""
        own = AXIS_NUMBER[scenes[0].axis]
        return cls(*direction(rng, [number != own for number in range(3)]))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the angles times the inputs of the triad."""
        triad = GYRO if scene.axis in GYRO else ACCEL
        return scene.ideal[list(triad)].to_numpy() @ [self.x, self.y, self.z]


@dataclass(frozen=True)
class GSensitivity(Inertial):
    """What a gyroscope senses of the specific force. Limit: the matched test along the drawn direction."""

    name: ClassVar[str] = "g_sensitivity"
    scaled: ClassVar = ("x", "y", "z")
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose a gyroscope."""
        return (str(rng.choice(GYRO)),)

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "GSensitivity":
        """Draw the direction."""
        return cls(*direction(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the sensitivity times the specific force."""
        return scene.ideal[list(ACCEL)].to_numpy() @ [self.x, self.y, self.z]


@dataclass(frozen=True)
class VibrationRectification(Inertial):
    """Bias proportional to the variance of the specific force within a second. Limit: the matched test."""

    name: ClassVar[str] = "vibration_rectification"
    scaled: ClassVar = ("coefficient",)
    coefficient: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "VibrationRectification":
        """Draw the sign."""
        return cls(sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the coefficient times the sum of the variances of the three axes."""
        return self.coefficient * sum(within_a_second(scene.ideal[axis].to_numpy(), scene.interval) for axis in ACCEL)


@dataclass(frozen=True)
class LeverArm(Inertial):
    """Specific force w x (w x r) + wdot x r at the arm r on the three accelerometers. Limit: the matched test."""

    name: ClassVar[str] = "lever_arm"
    scaled: ClassVar = ("x", "y", "z")
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose the accelerometers."""
        return ACCEL

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "LeverArm":
        """Draw the direction."""
        return cls(*direction(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the component of the axis."""
        return scene.motion.arm(scene.time)[:, AXIS_NUMBER[scene.axis]] @ [self.x, self.y, self.z]


@dataclass(frozen=True)
class TimeOffset(Inertial):
    """Input delayed by ``offset`` on all axes. Limit: the matched test for -offset times the input's derivative."""

    name: ClassVar[str] = "time_offset"
    scaled: ClassVar = ("offset",)
    offset: float = 1.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose all axes."""
        return AXES

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "TimeOffset":
        """Draw the sign."""
        return cls(sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return -offset times the derivative of the input."""
        later, earlier = (scene.motion.ideal(scene.time + shift)[scene.axis] for shift in (NUDGE_S, -NUDGE_S))
        return self.offset * (earlier.to_numpy() - later.to_numpy()) / (2 * NUDGE_S)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Return the input at the earlier time less the input."""
        return (scene.motion.ideal(scene.time - self.offset)[scene.axis].to_numpy()) - scene.ideal[
            scene.axis
        ].to_numpy()


INERTIAL: tuple[type[Kind], ...] = (
    ScaleFactor,
    Misalignment,
    GSensitivity,
    VibrationRectification,
    LeverArm,
    TimeOffset,
)


def within_a_second(values: np.ndarray, interval: float) -> np.ndarray:
    """Return the variance within a centred window of a second, shape (n,); at the ends within what there is of it."""
    half = int(0.5 / interval)
    row = np.arange(len(values))
    low, high = np.maximum(row - half, 0), np.minimum(row + half + 1, len(values))
    centred = values - values.mean()
    first, second = (np.r_[0.0, np.cumsum(centred**power)] for power in (1, 2))
    mean, square = ((sums[high] - sums[low]) / (high - low) for sums in (first, second))
    return square - mean**2
