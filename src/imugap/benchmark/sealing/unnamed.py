"""Hidden effects of no vocabulary: the right answer is a place without a name."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.integrate import solve_ivp

from imugap.benchmark.sealing.hidden_effect import Ranges, Scene, Spectrum, Waveform, between, sign
from imugap.benchmark.sealing.noise import fractional


@dataclass(frozen=True)
class Chirp(Waveform):
    """Line whose frequency goes from ``begin`` to ``end`` [Hz] over the log. Limit: the matched test."""

    name: ClassVar[str] = "chirp"
    scaled: ClassVar = ("amplitude",)
    begin: float = 1.0
    end: float = 2.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Chirp":
        """Draw the first frequency as a share of the rate, and the factor to the last."""
        begin = between(rng, ranges["frequency_share"]) / scenes[0].interval
        return cls(begin, begin * between(rng, ranges["factor"]))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the line, of phase zero at the first sample."""
        sweep = (self.end - self.begin) / scene.duration
        return self.amplitude * np.sin(2 * np.pi * (self.begin + sweep * scene.time / 2) * scene.time)


@dataclass(frozen=True)
class Hysteresis(Waveform):
    """Bias that is +-``amplitude`` while the device warms or cools, with play of ``width`` [degC] between.

    Limit: the matched test over the temperature of the log.
    """

    name: ClassVar[str] = "hysteresis"
    scaled: ClassVar = ("amplitude",)
    needs_temperature: ClassVar[bool] = True
    width: float = 1.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Hysteresis":
        """Draw the width as a share of the range of the temperature, and the sign."""
        return cls(np.ptp(scenes[0].temperature) * rng.uniform(*ranges["width_share"]), sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return where within the play the temperature is."""
        half = self.width / 2
        dragged = np.empty(scene.count)
        at = scene.temperature[0]
        for row, warmth in enumerate(scene.temperature.tolist()):
            at = min(max(at, warmth - half), warmth + half)
            dragged[row] = at
        return self.amplitude * (scene.temperature - dragged) / half


@dataclass(frozen=True)
class VanDerPol(Waveform):
    """Limit cycle of x'' - mu (1 - x^2) x' + x = 0, ``frequency`` cycles a second. Limit: the matched test."""

    name: ClassVar[str] = "van_der_pol"
    scaled: ClassVar = ("amplitude",)
    mu: float = 5.0
    frequency: float = 1.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "VanDerPol":
        """Draw the nonlinearity, and the frequency as a share of the rate."""
        return cls(between(rng, ranges["mu"]), between(rng, ranges["frequency_share"]) / scenes[0].interval)

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the cycle, which reaches +-2 ``amplitude``."""
        turn, cycle = self.cycle()
        return self.amplitude * np.interp(self.frequency * scene.time, turn, cycle, period=1.0)

    def cycle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return one cycle: turns from 0 to 1 and values, from one rise through zero to the next."""

        def rise(_: float, state: np.ndarray) -> float:
            return state[0]

        rise.direction = 1

        def slope(_: float, state: np.ndarray) -> list[float]:
            x, v = state
            return [v, self.mu * (1 - x**2) * v - x]

        span = (0, 20 * (self.mu + np.pi))
        found = solve_ivp(slope, span, [2.0, 0.0], events=rise, dense_output=True, rtol=1e-8, atol=1e-8)
        begin, end = found.t_events[0][-2:]
        turn = np.linspace(0, 1, 4001)
        return turn, found.sol(begin + turn * (end - begin))[0]


@dataclass(frozen=True)
class FractionalNoise(Spectrum):
    """Noise of density a^2 interval |2 sin(pi f interval)|^-1.5, between flicker and walk. Limit: the spectral test."""

    name: ClassVar[str] = "fractional_noise"
    scaled: ClassVar = ("amplitude",)
    bases: ClassVar[tuple[str, ...]] = ("white",)
    exponent: float = 1.5
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "FractionalNoise":
        """Draw nothing."""
        return cls()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the density."""
        return self.amplitude**2 * interval * (2 * np.sin(np.pi * frequency * interval)) ** -self.exponent

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw by fractional differencing."""
        return self.amplitude * fractional(scene.count, self.exponent, rng)


@dataclass(frozen=True)
class Bursts(Waveform):
    """Exponential bursts of ``amplitude`` at random times. Limit: the matched test for as many at even times."""

    name: ClassVar[str] = "bursts"
    scaled: ClassVar = ("amplitude",)
    count: float = 1.0
    decay: float = 1.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Bursts":
        """Draw the number of bursts, their decay as a share of the log, and the sign."""
        count = round(between(rng, ranges["count"]))
        return cls(count, scenes[0].duration * between(rng, ranges["decay_share"]), sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return bursts at even times."""
        return self.at((np.arange(self.count) + 0.5) * scene.duration / self.count, scene)

    def sample(self, scene: Scene, rng: np.random.Generator) -> np.ndarray:
        """Draw the times."""
        return self.at(rng.uniform(0, scene.duration, int(self.count)), scene)

    def at(self, times: np.ndarray, scene: Scene) -> np.ndarray:
        """Return bursts at ``times`` [s]."""
        since = scene.time - times[:, None]
        return self.amplitude * np.where(since >= 0, np.exp(-np.maximum(since, 0) / self.decay), 0).sum(axis=0)


@dataclass(frozen=True)
class Sawtooth(Waveform):
    """Drift by ``amplitude`` that jumps back every ``period`` [s]. Limit: the matched test."""

    name: ClassVar[str] = "sawtooth"
    scaled: ClassVar = ("amplitude",)
    period: float = 1.0
    amplitude: float = 1.0

    @classmethod
    def draw(cls, scenes: Sequence[Scene], ranges: Ranges, rng: np.random.Generator) -> "Sawtooth":
        """Draw the number of teeth in the log, and the sign."""
        return cls(scenes[0].duration / between(rng, ranges["teeth"]), sign(rng))

    def shape(self, scene: Scene) -> np.ndarray:
        """Return the drift."""
        return self.amplitude * (scene.time / self.period % 1.0)


UNKNOWN = (Chirp, Hysteresis, VanDerPol, FractionalNoise, Bursts, Sawtooth)
