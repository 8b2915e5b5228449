"""Hidden effects that scale the noise, act on the output of an axis, or act on rows and stamps of a log."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.stats import norm

from imugap.benchmark.sealing import detection_limits as limits
from imugap.benchmark.sealing.hidden_effect import Kind, Modulation, Output, Ranges, Scene, Stamp, between

BAND = 0.45
"""Share of the rate up to which the spectral test of a filter looks; filters differ beyond."""
KOLMOGOROV = 1.63
"""Value of sqrt(n) times the Kolmogorov-Smirnov statistic that is exceeded in 1 % of samples."""
TICKS = 200
"""Displacements of stamps, in ticks, above which there are none."""


@dataclass(frozen=True)
class VarianceChange(Modulation):
    """White noise whose variance is ``ratio`` times as large between ``start`` and ``stop``.

    Limit: the excess ratio - 1 at which n/2 (log mean r - mean log r) = 2.71, r the factor of the variance over time.
    """

    name: ClassVar[str] = "variance_change"
    start: float = 0.0
    stop: float = 0.0
    ratio: float = 2.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "VarianceChange":
        """Draw start and length as shares of the log."""
        start, length = rng.uniform(*ranges["start_share"]), rng.uniform(*ranges["length_share"])
        return cls(scenes[0].duration * start, scenes[0].duration * (start + length))

    def variance(self, scene: Scene) -> np.ndarray:
        """Return the factor of the variance over time."""
        return np.where((scene.time >= self.start) & (scene.time < self.stop), self.ratio, 1.0)

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the least excess of the ratio over one that can be seen."""
        (scene,) = scenes
        inside = replace(self, ratio=2.0).variance(scene) - 1
        return limits.reach(lambda excess: limits.divergence(1 + excess * inside), 1e-6, 1e6)

    def of_size(self, size: float, scenes: Sequence[Scene]) -> "VarianceChange":
        """Return the change whose excess is ``size`` times the limit."""
        return replace(self, ratio=1 + size * self.limit(scenes))


@dataclass(frozen=True)
class OutputFilter(Output):
    """Butterworth low-pass of the output, through the bilinear transform.

    Limit: the cotangent s = 1/tan(pi cutoff interval) at which n/2 (log mean r - mean log r) = 2.71 for the gains
    r = 1/(1 + (s tan(pi f interval))^(2 order)) at the cosine frequencies up to :data:`BAND` of the rate.
    """

    name: ClassVar[str] = "output_filter"
    rank: ClassVar[int] = 0
    cutoff: float = 1.0
    order: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "OutputFilter":
        """Draw the order."""
        low, high = ranges["order"]
        return cls(order=int(rng.integers(low, high + 1)))

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the cotangent at the limit."""
        (scene,) = scenes
        x = scene.frequencies() * scene.interval
        tangent = np.tan(np.pi * x[x < BAND]) ** (2 * self.order)
        return limits.reach(lambda s: limits.divergence(1 / (1 + s ** (2 * self.order) * tangent)), 1e-4, 1e3)

    def of_size(self, size: float, scenes: Sequence[Scene]) -> "OutputFilter":
        """Return the filter whose cotangent is ``size`` times the limit."""
        cotangent = size * self.limit(scenes)
        return replace(self, cutoff=float(np.arctan(1 / cotangent) / (np.pi * scenes[0].interval)))

    def response(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the complex gain at ``frequency`` [Hz]: the product over the poles of the analog prototype."""
        s = 1j * np.tan(np.pi * frequency * interval) / np.tan(np.pi * self.cutoff * interval)
        angles = np.pi * (2 * np.arange(1, self.order + 1) + self.order - 1) / (2 * self.order)
        return np.prod(1 / (1 - s[:, None] * np.exp(-1j * angles)), axis=1)

    def act(self, values: np.ndarray, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Multiply the spectrum of the values, held at the first one for a lead and at the last for a trail."""
        lead = min(len(values), 2000)
        held = np.r_[np.full(lead, values[0]), values, np.full(lead, values[-1])] - values[0]
        length = next_fast_len(len(held) + lead, real=True)
        padded = np.r_[held, np.linspace(held[-1], 0, length - len(held))]
        filtered = irfft(rfft(padded) * self.response(rfftfreq(length, scene.interval), scene.interval), length)
        return filtered[lead : lead + len(values)] + values[0]


@dataclass(frozen=True)
class Saturation(Output):
    """Output clipped to +-``limit``.

    Limit: the full scale at which the root of the energy that it clips off input and bias, over the noise, is 2.33; a
    smaller one is ``size`` times as strong in this measure.
    """

    name: ClassVar[str] = "saturation"
    rank: ClassVar[int] = 1
    motion: ClassVar[bool] = True
    full_scale: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Saturation":
        """Draw nothing."""
        return cls()

    def of_size(self, size: float, scenes: Sequence[Scene]) -> "Saturation":
        """Return the full scale whose clipped excess is ``size`` times as strong as at the limit."""
        (scene,) = scenes
        level = np.abs(scene.ideal[scene.axis].to_numpy() + scene.bias)

        def strength(depth: float) -> float:
            return float(np.linalg.norm(np.maximum(level - level.max() + depth, 0)) / scene.std)

        depth = limits.reach(strength, 1e-9 * level.max(), level.max(), size * limits.Z)
        return replace(self, full_scale=float(level.max() - depth))

    def parameters(self) -> dict[str, float]:
        """Return the full scale under its name in the vocabulary."""
        return {"limit": self.full_scale}

    def act(self, values: np.ndarray, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Replace what lies beyond the full scale by it."""
        return np.where(np.abs(values) > self.full_scale, np.sign(values) * self.full_scale, values)


@dataclass(frozen=True)
class Resolution(Output):
    """Output rounded to multiples of ``step``.

    Limit: the step whose lattice moves the distribution function of Gaussian noise of standard deviation s by the 1 %
    value of the Kolmogorov-Smirnov test: step/(2 sqrt(2 pi) s) = 1.63/sqrt(n). Counting equal values sees far less.
    """

    name: ClassVar[str] = "resolution"
    rank: ClassVar[int] = 2
    scaled: ClassVar = ("step",)
    step: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Resolution":
        """Draw nothing."""
        return cls()

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return 2 sqrt(2 pi) 1.63 s/sqrt(n)."""
        (scene,) = scenes
        return float(2 * np.sqrt(2 * np.pi) * KOLMOGOROV * scene.std / np.sqrt(scene.count))

    def act(self, values: np.ndarray, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Round half a step up: the floor of the shifted count of steps."""
        return np.floor(values / self.step + 0.5) * self.step


@dataclass(frozen=True)
class StuckSamples(Output):
    """Values repeated: a stretch begins at a sample with ``probability`` and repeats it ``length`` times on average.

    Limit: the probability at which half of the logs have a stretch at all, log 2/n; one is enough to be seen.
    """

    name: ClassVar[str] = "stuck_samples"
    rank: ClassVar[int] = 3
    scaled: ClassVar = ("probability",)
    probability: float = 1.0
    length: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "StuckSamples":
        """Draw the mean length."""
        return cls(length=between(rng, ranges["length"]))

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return log 2/n."""
        return float(np.log(2) / scenes[0].count)

    def act(self, values: np.ndarray, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Take every value from the last row that was fresh."""
        fresh = ~stretches(len(values), self.probability, self.length, rng)
        return values[np.maximum.accumulate(np.where(fresh, np.arange(len(values)), 0))]


@dataclass(frozen=True)
class SampleLoss(Stamp):
    """Rows missing: a gap begins at a row with ``probability`` and loses ``length`` rows on average.

    Limit: the probability at which half of the logs have a gap at all, log 2/n; one is enough to be seen.
    """

    name: ClassVar[str] = "sample_loss"
    scaled: ClassVar = ("probability",)
    probability: float = 1.0
    length: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "SampleLoss":
        """Draw the mean length."""
        return cls(length=between(rng, ranges["length"]))

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return log 2/n."""
        return float(np.log(2) / scenes[0].count)

    def act(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Drop the rows of the gaps; the first and the last row stay."""
        lost = stretches(len(log), self.probability, self.length, rng)
        lost[-1] = False
        return log[~lost]


@dataclass(frozen=True)
class TimestampJitter(Stamp):
    """Stamps displaced by independent Gaussian errors, written in whole ticks and kept in order.

    Limit: with ticks of ``tick`` [s], the std at which the largest of n displacements is half a tick in half of the
    logs: tick/2 over the normal quantile of 1 - log 2/(2 n). Anything less is rounded away.
    """

    name: ClassVar[str] = "timestamp_jitter"
    scaled: ClassVar = ("std",)
    std: float = 1.0
    tick: float = 1e-4

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "TimestampJitter":
        """Draw the tick."""
        return cls(tick=between(rng, ranges["tick_s"]))

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return half a tick over the quantile of the largest displacement."""
        return float(self.tick / 2 / norm.isf(np.log(2) / (2 * scenes[0].count)))

    def parameters(self) -> dict[str, float]:
        """Return the standard deviation of the displacements as they are written; the vocabulary has no tick."""
        edges = norm.cdf((np.arange(-TICKS, TICKS) + 0.5) * self.tick / self.std)
        return {"std": self.tick * float(np.sqrt(np.diff(edges) @ np.arange(1 - TICKS, TICKS) ** 2))}

    def act(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Displace the stamps by whole ticks; a stamp that would not come after the one before comes a tick later."""
        time = log.index.to_numpy()
        ticks = np.rint(rng.normal(scale=self.std, size=len(time)) / self.tick).astype(int)
        displaced = time / self.tick + ticks
        row = np.arange(len(time))
        ordered = np.maximum.accumulate(displaced - row) + row
        return log.set_index(pd.Index(np.where(ordered == time / self.tick, time, ordered * self.tick), name="time"))


@dataclass(frozen=True)
class ClockScale(Kind):
    """Sampling clock that is off in one of five runs: stamp = ratio x true time, the stamps being as regular as ever.

    A line of the device (frequency f, amplitude A, noise s) appears at f/ratio there. Limit of ratio - 1: 2.33 relative
    Cramer-Rao standard deviations sqrt(24 s^2/(A^2 n^3))/(2 pi f interval) of a line's frequency (Rife and Boorstyn
    1974), times sqrt(1 + 1/4) for one run against four; the lines of several axes add up.
    """

    name: ClassVar[str] = "clock_scale"
    bases: ClassVar[tuple[str, ...]] = ("line",)
    runs: ClassVar[int] = 5
    ratio: float = 1.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose the time."""
        return ("time",)

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "ClockScale":
        """Draw nothing."""
        return cls()

    def of_size(self, size: float, scenes: Sequence[Scene]) -> "ClockScale":
        """Return the clock whose ratio is ``size`` limits off one; ``scenes`` are those of the axes with a line."""
        pull = sum(line_pull(scene) ** -2 for scene in scenes) ** -0.5
        return replace(self, ratio=1 + size * limits.Z * np.sqrt(5 / 4) * pull)


def line_pull(scene: Scene) -> float:
    """Return the Cramer-Rao standard deviation of a line's frequency, relative to it."""
    amplitude, frequency = scene.noise.amplitude, scene.noise.frequency
    error = np.sqrt(24 * scene.std**2 / (amplitude**2 * scene.count**3))
    return float(error / (2 * np.pi * frequency * scene.interval))


def stretches(count: int, probability: float, length: float, rng: np.random.Generator) -> np.ndarray:
    """Draw which of ``count`` rows lie in a stretch of geometric length; the first row never does."""
    starts = 1 + np.flatnonzero(rng.random(count - 1) < probability)
    ends = np.minimum(starts + rng.geometric(1 / length, len(starts)), count)
    depth = np.zeros(count + 1, int)
    np.add.at(depth, starts, 1)
    np.add.at(depth, ends, -1)
    return np.cumsum(depth)[:count] > 0
