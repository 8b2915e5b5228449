"""Hidden effects that need a motion: known functions of the error-free input and of its derivatives."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from imu_benchmark.log import ACCEL, AXES, GYRO
from imu_benchmark.sealing.hidden_effect import AxisRun, KnownWaveform, ParameterSource, scaled, signed
from imu_benchmark.sealing.motion import AXIS_NUMBER

HALF_STEP_S = 1e-3
"""Half the step of the central differences of the input [s]."""


class MotionWaveform(KnownWaveform):
    """A known signal of the motion."""

    needs_motion = True


@dataclass(frozen=True)
class HiddenScaleFactor(MotionWaveform):
    """Error x u + asymmetry x |u| + nonlinearity x u^2 of the input u, one of the three."""

    error: float = scaled(0.0)
    asymmetry: float = scaled(0.0)
    nonlinearity: float = scaled(0.0)

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw the one of the three, and its sign."""
        name = source.rng.choice(("error", "asymmetry", "nonlinearity"), p=(0.6, 0.2, 0.2))
        return cls(**{str(name): source.sign()})

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the polynomial in the input."""
        u = run.ideal[run.axis].to_numpy()
        return self.error * u + self.asymmetry * np.abs(u) + self.nonlinearity * u**2


@dataclass(frozen=True)
class VectorEffect(MotionWaveform):
    """Scalar product of a vector of parameters with a vector of inputs. Limit: along the drawn direction."""

    x: float = scaled(0.0)
    y: float = scaled(0.0)
    z: float = scaled(0.0)

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw a direction within the components that are free."""
        vector = source.rng.standard_normal(3) * np.asarray(cls.free(source.run.axis))
        return cls(*(vector / np.linalg.norm(vector) + 0.0).tolist())

    @staticmethod
    def free(axis: str) -> list[bool]:
        """Return the components that may differ from zero on ``axis``: all."""
        return [True] * 3

    def inputs(self, run: AxisRun) -> np.ndarray:
        """Return the inputs, shape (n, 3)."""
        raise NotImplementedError

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the scalar product."""
        return self.inputs(run) @ [self.x, self.y, self.z]


@dataclass(frozen=True)
class HiddenMisalignment(VectorEffect):
    """Sensitivity of an axis to the two other inputs of its triad, by small angles."""

    @staticmethod
    def free(axis: str) -> list[bool]:
        """Return the components other than that of the axis."""
        return [number != AXIS_NUMBER[axis] for number in range(3)]

    def inputs(self, run: AxisRun) -> np.ndarray:
        """Return the inputs of the triad."""
        return run.ideal[list(GYRO if run.axis in GYRO else ACCEL)].to_numpy()


@dataclass(frozen=True)
class HiddenGSensitivity(VectorEffect):
    """Sensitivity of a gyroscope to the specific force."""

    candidates = GYRO

    def inputs(self, run: AxisRun) -> np.ndarray:
        """Return the specific force."""
        return run.ideal[list(ACCEL)].to_numpy()


@dataclass(frozen=True)
class HiddenLeverArm(VectorEffect):
    """Specific force w x (w x r) + wdot x r at the arm r, on the three accelerometers."""

    axes = ACCEL

    def inputs(self, run: AxisRun) -> np.ndarray:
        """Return the row of the axis in the matrices that turn the arm into the specific force."""
        return run.motion.arm(run.time)[:, AXIS_NUMBER[run.axis]]


@dataclass(frozen=True)
class HiddenVibrationRectification(MotionWaveform):
    """Bias proportional to the variance of the specific force within a second."""

    coefficient: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the coefficient times the sum of the variances of the three axes."""
        return self.coefficient * sum(running_variance(run.ideal[axis].to_numpy(), run.interval) for axis in ACCEL)


@dataclass(frozen=True)
class HiddenTimeOffset(MotionWaveform):
    """Input delayed by ``offset`` on all axes. Limit: that of -offset times the input's derivative."""

    axes = AXES
    offset: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return -offset times the derivative of the input."""
        later, earlier = (run.motion.ideal(run.time + shift)[run.axis] for shift in (HALF_STEP_S, -HALF_STEP_S))
        return self.offset * (earlier.to_numpy() - later.to_numpy()) / (2 * HALF_STEP_S)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Return the input at the earlier time minus the input."""
        delayed = run.motion.ideal(run.time - self.offset)[run.axis]
        return delayed.to_numpy() - run.ideal[run.axis].to_numpy()


def running_variance(values: np.ndarray, interval: float) -> np.ndarray:
    """Return the variance within a centred window of a second, shape (n,); windows are shorter at the ends."""
    half = int(0.5 / interval)
    row = np.arange(len(values))
    low, high = np.maximum(row - half, 0), np.minimum(row + half + 1, len(values))
    centred = values - values.mean()
    first, second = (np.r_[0.0, np.cumsum(centred**power)] for power in (1, 2))
    mean, square = ((sums[high] - sums[low]) / (high - low) for sums in (first, second))
    return square - mean**2
