"""Hidden effects outside of the controlled vocabulary: the right answer is a place without a name."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.integrate import solve_ivp

from imu_benchmark.sealing.hidden_effect import (
    AxisRun,
    KnownWaveform,
    ParameterSource,
    StationaryNoise,
    drawn,
    scaled,
    signed,
)
from imu_benchmark.sealing.noise import fractional


@dataclass(frozen=True)
class HiddenSweep(KnownWaveform):
    """Line whose frequency goes from ``begin`` to ``end`` [Hz] over the log, by the same factor in equal times."""

    begin: float = 1.0
    end: float = 2.0
    amplitude: float = scaled()

    @classmethod
    def draw(cls, source: ParameterSource) -> Self:
        """Draw the first frequency as a share of the rate, and the factor to the last."""
        begin = source.log_uniform("frequency_share") / source.run.interval
        return cls(begin, begin * source.log_uniform("factor"))

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the line, of phase zero at the first sample."""
        octaves = np.log(self.end / self.begin)
        cycles = self.begin * run.duration / octaves * np.expm1(octaves * run.time / run.duration)
        return self.amplitude * np.sin(2 * np.pi * cycles)


@dataclass(frozen=True)
class HiddenHysteresis(KnownWaveform):
    """Bias of +-``amplitude`` while the device warms or cools, with play of ``width`` [degC] between."""

    needs_temperature = True
    width: float = drawn(lambda source: np.ptp(source.run.temperature) * source.uniform("width_share"))
    amplitude: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the position of the temperature within the play."""
        half = self.width / 2
        centre = np.empty(run.count)
        at = run.temperature[0]
        for row, value in enumerate(run.temperature.tolist()):
            at = min(max(at, value - half), value + half)
            centre[row] = at
        return self.amplitude * (run.temperature - centre) / half


@dataclass(frozen=True)
class HiddenVanDerPol(KnownWaveform):
    """Limit cycle of x'' - mu (1 - x^2) x' + x = 0, ``frequency`` cycles a second."""

    mu: float = drawn(lambda source: source.log_uniform("mu"))
    frequency: float = drawn(lambda source: source.log_uniform("frequency_share") / source.run.interval)
    amplitude: float = scaled()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the cycle, which reaches +-2 ``amplitude``."""
        phase, cycle = self.cycle()
        return self.amplitude * np.interp(self.frequency * run.time, phase, cycle, period=1.0)

    def cycle(self) -> tuple[np.ndarray, np.ndarray]:
        """Return phase (0 to 1) and values of one cycle, from one upward zero crossing to the next."""

        def rise(_: float, state: np.ndarray) -> float:
            return state[0]

        rise.direction = 1

        def slope(_: float, state: np.ndarray) -> list[float]:
            x, v = state
            return [v, self.mu * (1 - x**2) * v - x]

        span = (0, 20 * (self.mu + np.pi))
        found = solve_ivp(slope, span, [2.0, 0.0], events=rise, dense_output=True, rtol=1e-8, atol=1e-8)
        begin, end = found.t_events[0][-2:]
        phase = np.linspace(0, 1, 4001)
        return phase, found.sol(begin + phase * (end - begin))[0]


@dataclass(frozen=True)
class HiddenFractionalNoise(StationaryNoise):
    """Noise of density a^2 interval |2 sin(pi f interval)|^-exponent, by default between flicker and walk."""

    bases = ("white",)
    exponent: float = 1.5
    amplitude: float = scaled()

    def psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the density."""
        return self.amplitude**2 * interval * (2 * np.sin(np.pi * frequency * interval)) ** -self.exponent

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw by fractional differencing."""
        return self.amplitude * fractional(run.count, self.exponent, rng)


@dataclass(frozen=True)
class HiddenBursts(KnownWaveform):
    """Exponential bursts of ``amplitude`` at random times. Limit: that of as many at equal distances."""

    count: float = drawn(lambda source: round(source.log_uniform("count")))
    decay: float = drawn(lambda source: source.run.duration * source.log_uniform("decay_share"))
    amplitude: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return bursts at equal distances."""
        return self.at((np.arange(self.count) + 0.5) * run.duration / self.count, run)

    def sample(self, run: AxisRun, rng: np.random.Generator) -> np.ndarray:
        """Draw the times."""
        return self.at(rng.uniform(0, run.duration, int(self.count)), run)

    def at(self, times: np.ndarray, run: AxisRun) -> np.ndarray:
        """Return bursts at ``times`` [s]."""
        since = run.time - times[:, None]
        return self.amplitude * np.where(since >= 0, np.exp(-np.maximum(since, 0) / self.decay), 0).sum(axis=0)


@dataclass(frozen=True)
class HiddenSawtooth(KnownWaveform):
    """Drift by ``amplitude`` that jumps back every ``period`` [s]."""

    period: float = drawn(lambda source: source.run.duration / source.log_uniform("teeth"))
    amplitude: float = signed()

    def shape(self, run: AxisRun) -> np.ndarray:
        """Return the drift."""
        return self.amplitude * (run.time / self.period % 1.0)
