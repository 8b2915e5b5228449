"""What every hidden effect is here: parameters drawn for the place where it hides, a detection limit, and an action."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np
import pandas as pd

from imugap.benchmark.sealing import detection_limits as limits
from imugap.benchmark.sealing.motion import Motion
from imugap.benchmark.sealing.noise import Noise, modes
from imugap.log import AXES

Ranges = Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class Scene:
    """What an effect meets on one axis of one run.

    Attributes
    ----------
    axis, time, interval
        Canonical name; true instants of the samples [s], shape (n,); nominal interval [s].
    noise
        Noise of the base device.
    temperature
        True temperature [degC], shape (n,).
    motion, ideal
        How the device moves (None at rest), and the error-free log of all axes.
    bias
        Bias of the base device [unit].
    """

    axis: str
    time: np.ndarray
    interval: float
    noise: Noise
    temperature: np.ndarray
    motion: Motion | None
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


@dataclass(frozen=True)
class Kind:
    """One hidden effect: its parameters are the fields, named as in the controlled vocabulary, SI.

    ``scaled`` names the parameters that carry the size: drawn as a unit (vector), they are multiplied by the size and
    by the limit.
    """

    name: ClassVar[str]
    scaled: ClassVar[tuple[str, ...]] = ()
    bases: ClassVar[tuple[str, ...]] = ("white", "flicker", "walk")
    """Base devices that it can be told from."""
    motion: ClassVar[bool] = False
    """Whether it shows in motion only."""
    runs: ClassVar[int] = 1
    """Logs of one device that it takes."""
    needs_temperature: ClassVar[bool] = False

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose the axes on which it hides."""
        return (str(rng.choice(AXES)),)

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Kind":
        """Draw the parameters that are not scaled from ``ranges``, the ``scaled`` ones as a unit."""
        raise NotImplementedError

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the detection limit of the scaled parameters on the axes of ``scenes``, one for each axis."""
        raise NotImplementedError

    def of_size(self, size: float, scenes: Sequence[Scene]) -> "Kind":
        """Return the effect at ``size`` times its limit."""
        factor = size * self.limit(scenes)
        return replace(self, **{name: factor * getattr(self, name) for name in self.scaled})

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name, SI."""
        return {name: float(value) for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Additive(Kind):
    """An effect that adds a signal to an axis."""

    shared: ClassVar[bool] = False
    """Whether all its axes draw the same random numbers."""

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw the signal [unit], shape (n,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class Waveform(Additive):
    """A known signal but for its amplitude; its limit is that of the matched test (:func:`.limits.matched`)."""

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the signal for the present parameters, shape (n,)."""
        raise NotImplementedError

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return 2.33/sqrt(sum |c_k|^2/v_k) over the cosine coefficients but that of the mean."""
        return limits.matched([self.shape(scene) for scene in scenes], [scene.mode_variance() for scene in scenes])

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Return the signal."""
        return self.shape(scene)


@dataclass(frozen=True)
class Spectrum(Additive):
    """A stationary signal with a spectrum; its limit is that of the spectral test (:func:`.limits.spectral`)."""

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided density [unit^2/Hz] of the samples at ``frequency`` [Hz]."""
        raise NotImplementedError

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the amplitude at which n/2 (log mean r - mean log r) = 2.71, r = 1 + a^2 S(f)/(v(f) interval)."""
        (scene,) = scenes
        extra = self.psd(scene.frequencies(), scene.interval) / scene.interval
        return limits.spectral(extra, scene.mode_variance())


@dataclass(frozen=True)
class Modulation(Kind):
    """An effect that scales the white noise of an axis."""

    def variance(self, scene: Scene) -> np.ndarray:
        """Return the factor of the variance over time, shape (n,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class Output(Kind):
    """An effect that acts on what the axis gives out; the one of lowest ``rank`` comes first."""

    rank: ClassVar[int]

    def act(self, values: np.ndarray, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Return what becomes of ``values``, shape (n,)."""
        raise NotImplementedError


@dataclass(frozen=True)
class Stamp(Kind):
    """An effect on the rows and stamps of the whole log: it hides on the pseudo-axis ``time``."""

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose the time."""
        return ("time",)

    def act(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return what becomes of a log."""
        raise NotImplementedError


def between(rng: np.random.Generator, span: Sequence[float]) -> float:
    """Draw from a range of positive numbers, all magnitudes alike."""
    low, high = span
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sign(rng: np.random.Generator) -> float:
    """Draw +1 or -1."""
    return float(rng.choice((-1.0, 1.0)))


def direction(rng: np.random.Generator, free: Sequence[bool] = (True, True, True)) -> tuple[float, float, float]:
    """Draw a unit vector with zeros where it is not ``free``."""
    vector = rng.standard_normal(3) * np.asarray(free)
    x, y, z = vector / np.linalg.norm(vector) + 0.0
    return float(x), float(y), float(z)
