"""Hidden effects on the variance of the noise, on the output of an axis, and on rows and stamps of a log."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import pandas as pd
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.stats import norm

from imu_benchmark.sealing import detection_limits as limits
from imu_benchmark.sealing.hidden_effect import (
    AxisRun,
    HiddenEffect,
    OutputEffect,
    ParameterSource,
    TimestampEffect,
    drawn,
    scaled,
)

BAND = 0.45
"""Highest frequency, over the rate, of the spectral test of a filter; filters differ beyond."""
KOLMOGOROV = 1.63
"""Quantile of 99 % of sqrt(n) times the Kolmogorov-Smirnov statistic."""
TICKS = 200
"""Largest displacement of a stamp considered, in ticks."""


@dataclass(frozen=True)
class HiddenVarianceChange(HiddenEffect):
    """White noise whose variance is ``ratio`` times as large between ``start`` and ``stop``.

    Limit: the excess ratio - 1 at which n/2 (log mean r - mean log r) = 2.71, r the factor of the variance over time.
    """

    start: float = 0.0
    stop: float = 0.0
    ratio: float = 2.0

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw start and length as shares of the log."""
        start, length = source.uniform("start_share"), source.uniform("length_share")
        return cls(source.run.duration * start, source.run.duration * (start + length))

    def variance(self, run: AxisRun) -> np.ndarray:
        """Return the factor of the variance over time."""
        return np.where((run.time >= self.start) & (run.time < self.stop), self.ratio, 1.0)

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the least excess of the ratio over one that can be seen."""
        (run,) = axis_runs
        inside = replace(self, ratio=2.0).variance(run) - 1
        return limits.solve(lambda excess: limits.divergence(1 + excess * inside), 1e-6, 1e6)

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the change whose excess is ``size`` times the limit."""
        return replace(self, ratio=1 + size * self.limit(axis_runs))


@dataclass(frozen=True)
class HiddenOutputFilter(OutputEffect):
    """Butterworth low-pass of the output, through the bilinear transform.

    Limit: the cotangent s = 1/tan(pi cutoff interval) at which n/2 (log mean r - mean log r) = 2.71 for the gains
    r = 1/(1 + (s tan(pi f interval))^(2 order)) at the cosine frequencies up to :data:`BAND` of the rate.
    """

    rank = 0
    cutoff: float = 1.0
    order: float = drawn(lambda source: int(source.rng.integers(*source.ranges["order"], endpoint=True)))

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the cotangent at the limit."""
        (run,) = axis_runs
        x = run.frequencies() * run.interval
        tangent = np.tan(np.pi * x[x < BAND]) ** (2 * self.order)
        return limits.solve(lambda s: limits.divergence(1 / (1 + s ** (2 * self.order) * tangent)), 1e-4, 1e3)

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the filter whose cotangent is ``size`` times the limit."""
        cotangent = size * self.limit(axis_runs)
        return replace(self, cutoff=float(np.arctan(1 / cotangent) / (np.pi * axis_runs[0].interval)))

    def response(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the complex gain at ``frequency`` [Hz]: the product over the poles of the analog prototype."""
        s = 1j * np.tan(np.pi * frequency * interval) / np.tan(np.pi * self.cutoff * interval)
        angles = np.pi * (2 * np.arange(1, self.order + 1) + self.order - 1) / (2 * self.order)
        return np.prod(1 / (1 - s[:, None] * np.exp(-1j * angles)), axis=1)

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Multiply the spectrum of the values, held at the first one for a lead and at the last for a trail."""
        lead = min(len(values), 2000)
        held = np.r_[np.full(lead, values[0]), values, np.full(lead, values[-1])] - values[0]
        length = next_fast_len(len(held) + lead, real=True)
        padded = np.r_[held, np.linspace(held[-1], 0, length - len(held))]
        filtered = irfft(rfft(padded) * self.response(rfftfreq(length, run.interval), run.interval), length)
        return filtered[lead : lead + len(values)] + values[0]


@dataclass(frozen=True)
class HiddenSaturation(OutputEffect):
    """Output clipped to +-``limit``.

    Limit: the full scale at which the root of the energy that it clips off input and bias, over the noise, is 2.33; a
    smaller one is ``size`` times as strong in this measure.
    """

    rank = 1
    needs_motion = True
    full_scale: float = 1.0

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the full scale whose clipped excess is ``size`` times as strong as at the limit."""
        (run,) = axis_runs
        level = np.abs(run.ideal[run.axis].to_numpy() + run.bias)

        def strength(depth: float) -> float:
            return float(np.linalg.norm(np.maximum(level - level.max() + depth, 0)) / run.std)

        depth = limits.solve(strength, 1e-9 * level.max(), level.max(), size * limits.Z)
        return replace(self, full_scale=float(level.max() - depth))

    def parameters(self) -> dict[str, float]:
        """Return the full scale under its name in the vocabulary."""
        return {"limit": self.full_scale}

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Replace what lies beyond the full scale by it."""
        return np.where(np.abs(values) > self.full_scale, np.sign(values) * self.full_scale, values)


@dataclass(frozen=True)
class HiddenDeadZone(OutputEffect):
    """Output that is zero where its input is within +-``width``/2.

    Limit: the width within which :data:`.detection_limits.GAIN` samples are expected, the log-likelihood ratio of an
    empty zone.
    """

    rank = 1
    needs_motion = True
    width: float = 1.0

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the zone within which ``size`` times as many samples are expected as at the limit."""
        (run,) = axis_runs
        level = run.ideal[run.axis].to_numpy() + run.bias

        def expected(width: float) -> float:
            below, above = (norm.cdf((side * width / 2 - level) / run.std) for side in (-1, 1))
            return float(np.sum(above - below))

        widest = 2 * float(np.abs(level).max()) + 20 * run.std
        return replace(self, width=limits.solve(expected, 1e-9 * run.std, widest, size * limits.GAIN))

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Put zero in the place of what lies within the zone."""
        return np.where(np.abs(values) < self.width / 2, 0.0, values)


@dataclass(frozen=True)
class HiddenResolution(OutputEffect):
    """Output rounded to multiples of ``step``.

    Limit: the step whose lattice moves the distribution function of Gaussian noise of standard deviation s by the 1 %
    value of the Kolmogorov-Smirnov test: step/(2 sqrt(2 pi) s) = 1.63/sqrt(n). Counting equal values sees far less.
    """

    rank = 2
    step: float = scaled()

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return 2 sqrt(2 pi) 1.63 s/sqrt(n)."""
        (run,) = axis_runs
        return float(2 * np.sqrt(2 * np.pi) * KOLMOGOROV * run.std / np.sqrt(run.count))

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Round half a step up: the floor of the shifted count of steps."""
        return np.floor(values / self.step + 0.5) * self.step


@dataclass(frozen=True)
class RandomStretches(HiddenEffect):
    """Stretches of rows: one begins at a row with ``probability`` and has ``length`` rows on average.

    Limit: the probability at which half of the logs have a stretch at all, log 2/n; one is enough to be seen.
    """

    probability: float = scaled()
    length: float = drawn(lambda source: source.log_uniform("length"))

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return log 2/n."""
        return float(np.log(2) / axis_runs[0].count)

    def rows(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Draw which of ``count`` rows lie in a stretch of geometric length, shape (count,); the first never does."""
        starts = 1 + np.flatnonzero(rng.random(count - 1) < self.probability)
        ends = np.minimum(starts + rng.geometric(1 / self.length, len(starts)), count)
        depth = np.zeros(count + 1, int)
        np.add.at(depth, starts, 1)
        np.add.at(depth, ends, -1)
        return np.cumsum(depth)[:count] > 0


@dataclass(frozen=True)
class HiddenStuckSamples(RandomStretches, OutputEffect):
    """Values repeated over stretches of rows."""

    rank = 3

    def act(self, values: np.ndarray, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Take every value from the last row outside of the stretches."""
        fresh = ~self.rows(len(values), rng)
        return values[np.maximum.accumulate(np.where(fresh, np.arange(len(values)), 0))]


@dataclass(frozen=True)
class HiddenSampleLoss(RandomStretches, TimestampEffect):
    """Stretches of rows missing."""

    def act(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Drop the rows of the stretches; the first and the last row stay."""
        lost = self.rows(len(log), rng)
        lost[-1] = False
        return log[~lost]


@dataclass(frozen=True)
class HiddenTimestampJitter(TimestampEffect):
    """Stamps displaced by independent Gaussian errors, written in whole ticks and kept in order.

    Limit: with ticks of ``tick`` [s], the std at which the largest of n displacements is half a tick in half of the
    logs: tick/2 over the normal quantile of 1 - log 2/(2 n). Anything less is rounded away.
    """

    std: float = scaled()
    tick: float = drawn(lambda source: source.log_uniform("tick_s"))

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return half a tick over the quantile of the largest displacement."""
        return float(self.tick / 2 / norm.isf(np.log(2) / (2 * axis_runs[0].count)))

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
class HiddenClockScale(HiddenEffect):
    """Scale error of the sampling clock in one of five runs: stamp = ratio x true time, with regular stamps.

    A line of the device (frequency f, amplitude A, noise s) appears at f/ratio there. Limit of ratio - 1: 2.33 relative
    Cramer-Rao standard deviations sqrt(24 s^2/(A^2 n^3))/(2 pi f interval) of a line's frequency (Rife and Boorstyn
    1974), times sqrt(1 + 1/4) for one run against four; the lines of several axes add up.
    """

    bases = ("line",)
    axes = ("time",)
    runs = 5
    ratio: float = 1.0

    def of_size(self, size: float, axis_runs: Sequence[AxisRun]) -> Self:
        """Return the clock whose ratio differs from one by ``size`` limits, for the axes with a line."""
        pull = sum(line_pull(run) ** -2 for run in axis_runs) ** -0.5
        return replace(self, ratio=1 + size * limits.Z * np.sqrt(5 / 4) * pull)


def line_pull(run: AxisRun) -> float:
    """Return the Cramer-Rao standard deviation of a line's frequency, relative to it."""
    amplitude, frequency = run.noise.amplitude, run.noise.frequency
    error = np.sqrt(24 * run.std**2 / (amplitude**2 * run.count**3))
    return float(error / (2 * np.pi * frequency * run.interval))
