"""Hidden effects that add a signal to an axis at rest: noises, waveforms, outliers, common noise, turn-on bias."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from imu_benchmark.log import ACCEL, GYRO
from imu_benchmark.sealing import detection_limits as limits
from imu_benchmark.sealing.hidden_effect import (
    AxisRun,
    HiddenSignal,
    KnownWaveform,
    ParameterSource,
    StationaryNoise,
    drawn,
    scaled,
    sign,
    signed,
)
from imu_benchmark.sealing.noise import fractional, rounded, summed


@dataclass(frozen=True)
class HiddenWhiteNoise(StationaryNoise):
    """White noise of density N."""

    bases = ("quantization",)
    density: float = scaled()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return N^2."""
        return np.full(len(frequency), self.density**2)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw a Wiener process at the ends of the intervals and return its slopes."""
        path = np.r_[0.0, np.cumsum(rng.standard_normal(run.count))] * np.sqrt(run.interval)
        return self.density * np.diff(path) / run.interval


@dataclass(frozen=True)
class HiddenBiasInstability(StationaryNoise):
    """Flicker noise of coefficient B."""

    bases = ("white", "walk")
    density_b: float = scaled()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return B^2 interval/(2 sin(pi f interval)), at low frequency B^2/(2 pi f)."""
        return self.density_b**2 * interval / (2 * np.sin(np.pi * frequency * interval))

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw by fractional differencing."""
        return self.density_b * fractional(run.count, 1.0, rng)


@dataclass(frozen=True)
class HiddenRandomWalk(StationaryNoise):
    """Random walk of coefficient K."""

    bases = ("white", "flicker")
    density_k: float = scaled()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return (K interval/(2 sin(pi f interval)))^2."""
        return (self.density_k * interval / (2 * np.sin(np.pi * frequency * interval))) ** 2

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw a cumulated sum."""
        return self.density_k * np.sqrt(run.interval) * summed(run.count, rng)


@dataclass(frozen=True)
class HiddenQuantization(StationaryNoise):
    """Rounding error q of the integrated signal, differenced."""

    q: float = scaled()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return 4 q^2/interval sin^2(pi f interval)."""
        return 4 * self.q**2 / interval * np.sin(np.pi * frequency * interval) ** 2

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw by rounding a path."""
        return self.q / run.interval * rounded(run.count, rng)


@dataclass(frozen=True)
class HiddenGaussMarkov(StationaryNoise):
    """Exponentially correlated noise by circulant embedding."""

    std: float = scaled()
    correlation_time: float = drawn(lambda source: source.run.duration * source.log_uniform("correlation_share"))

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return that of samples with autocorrelation exp(-|t|/T)."""
        p = np.exp(-interval / self.correlation_time)
        return interval * self.std**2 * (1 - p**2) / (1 - 2 * p * np.cos(2 * np.pi * frequency * interval) + p**2)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw a periodic process, at least twice as long as the log, whose autocovariance is the exponential."""
        length = next_fast_len(2 * run.count, real=True)
        lag = np.minimum(np.arange(length), length - np.arange(length)) * run.interval
        power = np.maximum(rfft(np.exp(-lag / self.correlation_time)).real, 0)
        return self.std * irfft(np.sqrt(power) * rfft(rng.standard_normal(length)), length)[: run.count]


@dataclass(frozen=True)
class HiddenChirp(KnownWaveform):
    """Line whose frequency [Hz] changes by ``chirp_rate`` [Hz/s]."""

    frequency: float = 1.0
    chirp_rate: float = 0.0
    amplitude: float = scaled()
    phase: float = 0.0

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw the first frequency as a share of the rate, the factor to the last one, and the phase."""
        begin = source.log_uniform("frequency_share") / source.run.interval
        rate = begin * (source.log_uniform("factor") - 1) / source.run.duration
        return cls(begin, rate, phase=source.rng.uniform(0, 2 * np.pi))

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the line."""
        cycles = (self.frequency + self.chirp_rate * run.time / 2) * run.time
        return self.amplitude * np.cos(2 * np.pi * cycles + self.phase)


@dataclass(frozen=True)
class HiddenRandomTelegraph(StationaryNoise):
    """Two values at distance ``step``, switched ``rate`` times a second. Limit: that of its Lorentzian spectrum."""

    step: float = scaled()
    rate: float = drawn(lambda source: source.log_uniform("switches") / source.run.duration)

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return that of samples with autocovariance (step/2)^2 exp(-2 rate |t|)."""
        return HiddenGaussMarkov(self.step / 2, 1 / (2 * self.rate)).psd(frequency, interval)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw the instants of a Poisson process and count them up to each sample."""
        begin, end = run.time[0], run.time[-1]
        switches = np.sort(rng.uniform(begin, end, rng.poisson(self.rate * (end - begin))))
        odd = np.searchsorted(switches, run.time, side="right") % 2
        return self.step * sign(rng) * (odd - 0.5)


@dataclass(frozen=True)
class HiddenSinusoid(KnownWaveform):
    """Line at ``frequency`` [Hz]. In white noise the limit is 2.33 N sqrt(2/duration)."""

    frequency: float = drawn(lambda source: source.log_uniform("frequency_share") / source.run.interval)
    amplitude: float = scaled()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return a line of phase zero; the limit hardly depends on the phase."""
        return self.amplitude * np.cos(2 * np.pi * self.frequency * run.time)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw a phase and return the real part of a phasor."""
        phase = 2 * np.pi * (self.frequency * run.time + rng.uniform())
        return self.amplitude * np.exp(1j * phase).real


@dataclass(frozen=True)
class HiddenRateRamp(KnownWaveform):
    """Trend. In white noise the limit is 2.33 N sqrt(12/duration^3)."""

    slope: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the trend."""
        return self.slope * run.time


@dataclass(frozen=True)
class HiddenBiasStep(KnownWaveform):
    """Step of the mean at share x of the log. In white noise the limit is 2.33 N/sqrt(T x (1 - x))."""

    time: float = drawn(lambda source: source.run.duration * source.uniform("time_share"))
    step: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the step."""
        return np.where(run.time >= self.time, self.step, 0.0)


@dataclass(frozen=True)
class HiddenWarmUp(KnownWaveform):
    """Exponential after power-on at the first sample."""

    amplitude: float = signed()
    time_constant: float = drawn(lambda source: source.run.duration * source.log_uniform("constant_share"))

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the exponential."""
        return self.amplitude * np.exp(-run.time / self.time_constant)


@dataclass(frozen=True)
class HiddenTemperature(KnownWaveform):
    """Bias proportional to the temperature."""

    needs_temperature = True
    coefficient: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the coefficient times the difference of the temperature from 25 degC."""
        return self.coefficient * (run.temperature - 25)


@dataclass(frozen=True)
class HiddenOutliers(HiddenSignal):
    """Additional Gaussian error of standard deviation ``std``, in a sample with ``probability``.

    Limit: where n times the divergence of the mixture from the Gaussian of equal variance is 2.71.
    """

    probability: float = drawn(lambda source: source.log_uniform("probability"))
    std: float = scaled()

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the std at which n times the divergence is 2.71."""
        (run,) = axis_runs
        return run.std * limits.solve(lambda std: run.count * self.divergence(std), 1e-2, 1e4)

    def divergence(self, std: float) -> float:
        """Return the divergence per sample for ``std`` in units of that of the noise, by the trapezoidal rule."""
        wide = np.hypot(1, std)
        reach = np.exp(np.linspace(np.log(1e-3), np.log(12 * wide), 4001))
        y = np.r_[0.0, reach]
        narrow, broad = (np.exp(-(y**2) / (2 * s**2)) / (s * np.sqrt(2 * np.pi)) for s in (1, wide))
        mixture = (1 - self.probability) * narrow + self.probability * broad
        variance = 1 + self.probability * std**2
        log_gauss = -(y**2) / (2 * variance) - np.log(2 * np.pi * variance) / 2
        return float(2 * np.trapezoid(mixture * (np.log(mixture) - log_gauss), y))

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw number, positions and values of the outliers."""
        rows = rng.choice(run.count, rng.binomial(run.count, self.probability), replace=False)
        signal = np.zeros(run.count)
        signal[rows] = rng.normal(scale=self.std, size=len(rows))
        return signal


@dataclass(frozen=True)
class HiddenCommonMode(HiddenSignal):
    """White noise shared by axes of a triad, each with the ``loading`` one.

    Limit: where the divergence -n/2 log det R of the correlation matrix R of the axes from independent axes is 2.71.
    """

    shared = True
    density: float = scaled()
    loading: float = 1.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Draw two or three axes of a triad."""
        triad = (GYRO, ACCEL)[rng.integers(2)]
        return tuple(sorted(rng.choice(triad, rng.integers(2, 4), replace=False).tolist()))

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the density at which -n/2 log det R is 2.71."""
        std = np.array([run.std for run in axis_runs]) * np.sqrt(axis_runs[0].interval)

        def gain(density: float) -> float:
            weight = density**2 / std**2
            return axis_runs[0].count / 2 * (np.sum(np.log1p(weight)) - np.log1p(np.sum(weight)))

        return limits.solve(gain, 1e-6 * std.min(), 1e6 * std.max())

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw the shared noise."""
        return self.loading * self.density / np.sqrt(run.interval) * rng.standard_normal(run.count)


@dataclass(frozen=True)
class HiddenTurnOnBias(HiddenSignal):
    """A bias that differs between five runs.

    Limit: with r = 1 + std^2/m over the variance m of a run's mean, where 2 (r - 1 - log r), the divergence of the four
    differences between the runs, is 2.71.
    """

    bases = ("white",)
    runs = 5
    std: float = scaled()

    def limit(self, axis_runs: Sequence[AxisRun]) -> float:
        """Return the std at which the divergence of the runs is 2.71, for white noise."""
        (run,) = axis_runs
        excess = limits.solve(lambda x: 2 * (x - np.log1p(x)), 1e-3, 1e3)
        return float(np.sqrt(excess / run.duration) * run.noise.density)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw the bias of the run."""
        return np.full(run.count, rng.normal(scale=self.std))
