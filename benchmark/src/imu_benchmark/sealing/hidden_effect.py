"""Base classes of hidden effects: how parameters are drawn and scaled to a detection limit, and how effects act."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, ClassVar, Self

import numpy as np
import pandas as pd

from imu_benchmark.log import AXES
from imu_benchmark.sealing import detection_limits as limits
from imu_benchmark.sealing.motion import AnalyticMotion
from imu_benchmark.sealing.noise import BaseNoise, modes

Ranges = Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class AxisRun:
    """One axis of the base device in one run.

    Attributes
    ----------
    axis, time, interval
        Canonical name; true instants of the samples [s], shape (n,); nominal interval [s].
    noise
        Noise of the base device.
    temperature
        True temperature [degC], shape (n,).
    motion, ideal
        Motion of the device (None at rest), and the error-free log of all axes.
    bias
        Bias of the base device [unit].
    """

    axis: str
    time: np.ndarray
    interval: float
    noise: BaseNoise
    temperature: np.ndarray
    motion: AnalyticMotion | None
    ideal: pd.DataFrame
    bias: float

    @property
    def count(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    @property
    def duration(self) -> float:
        """Return the length of the log [s]."""
        return self.count * self.interval

    @property
    def std(self) -> float:
        """Return the standard deviation of a sample's white or quantization noise [unit]."""
        return float(np.hypot(self.noise.density / np.sqrt(self.interval), np.sqrt(2) * self.noise.q / self.interval))

    def frequencies(self) -> np.ndarray:
        """Return the frequencies [Hz] of the cosine coefficients, shape (n - 1,)."""
        return modes(self.count, self.interval)

    def mode_variance(self) -> np.ndarray:
        """Return the variances [unit^2] of the cosine coefficients of the noise, shape (n - 1,)."""
        return self.noise.mode_variance(self.count, self.interval)


@dataclass(frozen=True, eq=False)
class ParameterSource:
    """Source of an effect's random parameters: its first axis, the ranges of the recipe, the random generator."""

    run: AxisRun
    ranges: Ranges
    rng: np.random.Generator

    def log_uniform(self, name: str) -> float:
        """Draw from the range ``name`` of positive numbers, uniformly in the logarithm."""
        return log_uniform(self.rng, self.ranges[name])

    def uniform(self, name: str) -> float:
        """Draw uniformly from the range ``name``."""
        return self.rng.uniform(*self.ranges[name])

    def sign(self) -> float:
        """Draw +1 or -1."""
        return sign(self.rng)


def drawn(draw: Callable[[ParameterSource], float]) -> Any:
    """Declare a parameter that ``draw`` draws."""
    return field(default=1.0, metadata={"draw": draw})


def scaled(default: float = 1.0) -> Any:
    """Declare a parameter that carries the size: of unit value, multiplied by the size and the detection limit."""
    return field(default=default, metadata={"scaled": True})


def signed() -> Any:
    """Declare a parameter that carries the size, of random sign."""
    return field(default=1.0, metadata={"scaled": True, "draw": ParameterSource.sign})


@dataclass(frozen=True)
class HiddenEffect:
    """One hidden effect: its fields are its parameters, named as in the controlled vocabulary, SI.

    Its name is that of the class without the prefix. Parameters are drawn in the order of the fields.
    """

    name: ClassVar[str]
    bases: ClassVar[tuple[str, ...]] = ("white", "flicker", "walk")
    """Base devices from whose noise it can be distinguished."""
    axes: ClassVar[tuple[str, ...]] = ()
    """Axes on which it always acts; if empty, it acts on one of ``candidates``."""
    candidates: ClassVar[tuple[str, ...]] = AXES
    needs_motion: ClassVar[bool] = False
    runs: ClassVar[int] = 1
    """Number of logs of one device that it needs."""
    needs_temperature: ClassVar[bool] = False

    def __init_subclass__(cls) -> None:
        """Derive the name in the vocabulary from the name of the class."""
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__.removeprefix("Hidden")).lower()

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Draw the axes on which it acts."""
        return cls.axes or (str(rng.choice(cls.candidates)),)

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw the parameters; those that carry the size have unit magnitude."""
        return cls(**{one.name: one.metadata["draw"](source) for one in fields(cls) if "draw" in one.metadata})

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the detection limit of the parameters that carry the size, for an effect on these axes."""
        raise NotImplementedError

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the effect at ``size`` times its limit."""
        factor = size * self.limit(axis_runs)
        return replace(self, **{name: factor * getattr(self, name) for name in self.size_parameters})

    @property
    def size_parameters(self) -> tuple[str, ...]:
        """Return the names of the parameters that carry the size."""
        return tuple(one.name for one in fields(self) if "scaled" in one.metadata)

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name, SI."""
        return {name: float(value) for name, value in asdict(self).items()}


class HiddenSignal(HiddenEffect):
    """An effect that adds a signal to an axis."""

    shared: ClassVar[bool] = False
    """Whether all its axes use the same random numbers."""

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw the signal [unit], shape (n,)."""
        raise NotImplementedError


class KnownWaveform(HiddenSignal):
    """A signal known but for its amplitude. Limit: the matched test (:func:`.detection_limits.matched_test`)."""

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the signal for the present parameters, shape (n,)."""
        raise NotImplementedError

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return 2.33/sqrt(sum |c_k|^2/v_k) over the cosine coefficients except that of the mean."""
        return limits.matched_test([self.shape(run) for run in axis_runs], [run.mode_variance() for run in axis_runs])

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Return the signal."""
        return self.shape(run)


class StationaryNoise(HiddenSignal):
    """A stationary random signal. Limit: the spectral test (:func:`.detection_limits.spectral_test`)."""

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided density [unit^2/Hz] of the samples at ``frequency`` [Hz]."""
        raise NotImplementedError

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the amplitude at which n/2 (log mean r - mean log r) = 2.71, r = 1 + a^2 S(f)/(v(f) interval)."""
        (run,) = axis_runs
        return limits.spectral_test(self.psd(run.frequencies(), run.interval) / run.interval, run.mode_variance())


class OutputEffect(HiddenEffect):
    """An effect on the output of an axis; effects are applied in the order of ``rank``."""

    rank: ClassVar[int]

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Return the output for the undisturbed output ``values``, shape (n,)."""
        raise NotImplementedError


class TimestampEffect(HiddenEffect):
    """An effect on rows and stamps of the whole log, assigned to the pseudo-axis ``time``."""

    axes = ("time",)

    def act(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the disturbed log."""
        raise NotImplementedError


def log_uniform(rng: np.random.Generator, span: Sequence[float]) -> float:
    """Draw from a range of positive numbers, uniformly in the logarithm."""
    low, high = span
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sign(rng: np.random.Generator) -> float:
    """Draw +1 or -1."""
    return float(rng.choice((-1.0, 1.0)))
