"""Hidden effects that add a signal to an axis at rest: waveforms and stationary noises."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from imugap.benchmark.sealing import detection_limits as limits
from imugap.benchmark.sealing.hidden_effect import Additive, Ranges, Scene, Spectrum, Waveform, between, sign
from imugap.benchmark.sealing.noise import fractional, rounded, summed
from imugap.log import ACCEL, GYRO


@dataclass(frozen=True)
class WhiteNoise(Spectrum):
    """White noise of density N. Limit: the spectral test."""

    name: ClassVar[str] = "white_noise"
    bases: ClassVar[tuple[str, ...]] = ("quantization",)
    scaled: ClassVar = ("density",)
    density: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "WhiteNoise":
        """Draw nothing."""
        return cls()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return N^2."""
        return np.full(len(frequency), self.density**2)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw a Wiener process at the ends of the intervals and take its slopes."""
        path = np.r_[0.0, np.cumsum(rng.standard_normal(scene.count))] * np.sqrt(scene.interval)
        return self.density * np.diff(path) / scene.interval


@dataclass(frozen=True)
class BiasInstability(Spectrum):
    """Flicker noise B by fractional differencing. Limit: the spectral test."""

    name: ClassVar[str] = "bias_instability"
    bases: ClassVar[tuple[str, ...]] = ("white", "walk")
    scaled: ClassVar = ("density_b",)
    density_b: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "BiasInstability":
        """Draw nothing."""
        return cls()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return B^2 interval/(2 sin(pi f interval)), at low frequency B^2/(2 pi f)."""
        return self.density_b**2 * interval / (2 * np.sin(np.pi * frequency * interval))

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw by fractional differencing."""
        return self.density_b * fractional(scene.count, 1.0, rng)


@dataclass(frozen=True)
class RandomWalk(Spectrum):
    """Walk K as a cumulated sum. Limit: the spectral test."""

    name: ClassVar[str] = "random_walk"
    bases: ClassVar[tuple[str, ...]] = ("white", "flicker")
    scaled: ClassVar = ("density_k",)
    density_k: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "RandomWalk":
        """Draw nothing."""
        return cls()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return (K interval/(2 sin(pi f interval)))^2."""
        return (self.density_k * interval / (2 * np.sin(np.pi * frequency * interval))) ** 2

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw a cumulated sum."""
        return self.density_k * np.sqrt(scene.interval) * summed(scene.count, rng)


@dataclass(frozen=True)
class Quantization(Spectrum):
    """Rounding error q of the integrated signal, differenced. Limit: the spectral test."""

    name: ClassVar[str] = "quantization"
    scaled: ClassVar = ("q",)
    q: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Quantization":
        """Draw nothing."""
        return cls()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return 4 q^2/interval sin^2(pi f interval)."""
        return 4 * self.q**2 / interval * np.sin(np.pi * frequency * interval) ** 2

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw by rounding a path."""
        return self.q / scene.interval * rounded(scene.count, rng)


@dataclass(frozen=True)
class GaussMarkov(Spectrum):
    """Exponentially correlated noise by circulant embedding. Limit: the spectral test."""

    name: ClassVar[str] = "gauss_markov"
    scaled: ClassVar = ("std",)
    std: float = 1.0
    correlation_time: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "GaussMarkov":
        """Draw the correlation time as a share of the log."""
        return cls(correlation_time=scenes[0].duration * between(rng, ranges["correlation_share"]))

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return that of samples with autocorrelation exp(-|t|/T)."""
        p = np.exp(-interval / self.correlation_time)
        return interval * self.std**2 * (1 - p**2) / (1 - 2 * p * np.cos(2 * np.pi * frequency * interval) + p**2)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw a periodic process, at least twice as long as the log, whose autocovariance is the exponential."""
        length = next_fast_len(2 * scene.count, real=True)
        lag = np.minimum(np.arange(length), length - np.arange(length)) * scene.interval
        power = np.maximum(rfft(np.exp(-lag / self.correlation_time)).real, 0)
        return self.std * irfft(np.sqrt(power) * rfft(rng.standard_normal(length)), length)[: scene.count]


@dataclass(frozen=True)
class RandomTelegraph(Spectrum):
    """Two values at distance ``step``, switched ``rate`` times a second. Limit: the spectral test of its Lorentzian."""

    name: ClassVar[str] = "random_telegraph"
    scaled: ClassVar = ("step",)
    step: float = 1.0
    rate: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "RandomTelegraph":
        """Draw the mean number of switches in the log."""
        return cls(rate=between(rng, ranges["switches"]) / scenes[0].duration)

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return that of samples with autocovariance (step/2)^2 exp(-2 rate |t|)."""
        return GaussMarkov(self.step / 2, 1 / (2 * self.rate)).psd(frequency, interval)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw the instants of a Poisson process and count them up to each sample."""
        begin, end = scene.time[0], scene.time[-1]
        switches = np.sort(rng.uniform(begin, end, rng.poisson(self.rate * (end - begin))))
        odd = np.searchsorted(switches, scene.time, side="right") % 2
        return self.step * sign(rng) * (odd - 0.5)


@dataclass(frozen=True)
class Sinusoid(Waveform):
    """Line at ``frequency``. Limit: the matched test, in white noise 2.33 N sqrt(2/duration)."""

    name: ClassVar[str] = "sinusoid"
    scaled: ClassVar = ("amplitude",)
    frequency: float = 1.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Sinusoid":
        """Draw the frequency as a share of the rate."""
        return cls(frequency=between(rng, ranges["frequency_share"]) / scenes[0].interval)

    def shape(self, scene: Scene) -> np.ndarray:
        """Return a line of phase zero, which the limit hardly depends on."""
        return self.amplitude * np.cos(2 * np.pi * self.frequency * scene.time)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw a phase and return the real part of a phasor."""
        turn = 2 * np.pi * (self.frequency * scene.time + rng.uniform())
        return self.amplitude * np.exp(1j * turn).real


@dataclass(frozen=True)
class RateRamp(Waveform):
    """Trend. Limit: the matched test, in white noise 2.33 N sqrt(12/duration^3)."""

    name: ClassVar[str] = "rate_ramp"
    scaled: ClassVar = ("slope",)
    slope: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "RateRamp":
        """Draw the sign."""
        return cls(sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the trend."""
        return self.slope * scene.time


@dataclass(frozen=True)
class BiasStep(Waveform):
    """Jump of the mean at share x of the log. Limit: the matched test, in white noise 2.33 N/sqrt(T x (1 - x))."""

    name: ClassVar[str] = "bias_step"
    scaled: ClassVar = ("step",)
    time: float = 0.0
    step: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "BiasStep":
        """Draw the time as a share of the log, and the sign."""
        return cls(scenes[0].duration * rng.uniform(*ranges["time_share"]), sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the step."""
        return np.where(scene.time >= self.time, self.step, 0.0)


@dataclass(frozen=True)
class WarmUp(Waveform):
    """Exponential after power-on at the first sample. Limit: the matched test."""

    name: ClassVar[str] = "warm_up"
    scaled: ClassVar = ("amplitude",)
    amplitude: float = 1.0
    time_constant: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "WarmUp":
        """Draw the time constant as a share of the log, and the sign."""
        return cls(sign(rng), scenes[0].duration * between(rng, ranges["constant_share"]))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the exponential."""
        return self.amplitude * np.exp(-scene.time / self.time_constant)


@dataclass(frozen=True)
class Temperature(Waveform):
    """Bias proportional to the temperature. Limit: the matched test over the temperature of the log."""

    name: ClassVar[str] = "temperature"
    needs_temperature: ClassVar[bool] = True
    scaled: ClassVar = ("coefficient",)
    coefficient: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Temperature":
        """Draw the sign."""
        return cls(sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the coefficient times the temperature's distance from 25 degC."""
        return self.coefficient * (scene.temperature - 25)


@dataclass(frozen=True)
class Outliers(Additive):
    """Samples that get an additional Gaussian error of standard deviation ``std`` with ``probability``.

    Limit: where n times the divergence of the mixture from the Gaussian of equal variance is 2.71.
    """

    name: ClassVar[str] = "outliers"
    scaled: ClassVar = ("std",)
    probability: float = 0.0
    std: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Outliers":
        """Draw the probability."""
        return cls(between(rng, ranges["probability"]))

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the std at which n times the divergence is 2.71."""
        (scene,) = scenes
        return scene.std * limits.reach(lambda std: scene.count * self.divergence(std), 1e-2, 1e4)

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

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw the number of outliers, their places and their values."""
        places = rng.choice(scene.count, rng.binomial(scene.count, self.probability), replace=False)
        signal = np.zeros(scene.count)
        signal[places] = rng.normal(scale=self.std, size=len(places))
        return signal


@dataclass(frozen=True)
class CommonMode(Additive):
    """White noise that axes of a triad share.

    Limit: where the divergence -n/2 log det R of the correlation matrix R of the axes from independent axes is 2.71.
    """

    name: ClassVar[str] = "common_mode"
    scaled: ClassVar = ("density",)
    shared: ClassVar[bool] = True
    density: float = 1.0
    loading: float = 1.0

    @classmethod
    def choose(cls, rng: np.random.Generator) -> tuple[str, ...]:
        """Choose two or three axes of a triad."""
        triad = (GYRO, ACCEL)[rng.integers(2)]
        return tuple(sorted(rng.choice(triad, rng.integers(2, 4), replace=False).tolist()))

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "CommonMode":
        """Draw nothing: all axes have the loading one."""
        return cls()

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the density at which -n/2 log det R is 2.71."""
        std = np.array([scene.std for scene in scenes]) * np.sqrt(scenes[0].interval)

        def gain(density: float) -> float:
            weight = density**2 / std**2
            return scenes[0].count / 2 * (np.sum(np.log1p(weight)) - np.log1p(np.sum(weight)))

        return limits.reach(gain, 1e-6 * std.min(), 1e6 * std.max())

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw what all axes share."""
        return self.loading * self.density / np.sqrt(scene.interval) * rng.standard_normal(scene.count)


@dataclass(frozen=True)
class TurnOnBias(Additive):
    """A bias that differs between five runs.

    Limit: with r = 1 + std^2/m over the variance m of a run's mean, where 2 (r - 1 - log r), the divergence of the four
    differences between the runs, is 2.71.
    """

    name: ClassVar[str] = "turn_on_bias"
    bases: ClassVar[tuple[str, ...]] = ("white",)
    runs: ClassVar[int] = 5
    scaled: ClassVar = ("std",)
    std: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "TurnOnBias":
        """Draw nothing."""
        return cls()

    def limit(self, scenes: Sequence[Scene]) -> float:
        """Return the std at which the divergence of the runs is 2.71, for white noise."""
        (scene,) = scenes
        excess = limits.reach(lambda x: 2 * (x - np.log1p(x)), 1e-3, 1e3)
        return float(np.sqrt(excess / scene.duration) * scene.noise.density)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw the bias of the run."""
        return np.full(scene.count, rng.normal(scale=self.std))
