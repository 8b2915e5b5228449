"""Spectral line."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import diric

from imugap.effects.block import Block, cos
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, AllanEffect, Start, SystematicEffect, parameter
from imugap.effects.residual import Residual

HIGHEST = 0.48
"""Highest frequency times interval of a harmonic."""
LINE = ("frequency", "amplitude", "phase")
"""Parameters of a line that a fit adjusts."""


@dataclass(frozen=True)
class Sinusoid(SystematicEffect, AllanEffect):
    """Sinusoid amplitude cos(2 pi f t + phase) (IEEE 952, sinusoidal noise).

    Its Allan variance is the mean over a random phase; a run that is long against the period has it, whatever its
    phase.
    """

    name: ClassVar[str] = "sinusoid"
    most: ClassVar[int] = 5
    line: ClassVar[bool] = True
    tonal: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    frequency: float = parameter("Hz", "f", low=TINY)
    amplitude: float = parameter("{u}", "amplitude")
    phase: float = parameter("rad", "phase at power-on", low=-np.inf, default=0.0)

    @property
    def centre(self) -> float:
        """Frequency [Hz] of the line."""
        return self.frequency

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sinusoid at the sample times."""
        return self.amplitude * np.cos(2 * np.pi * self.frequency * conditions.time + self.phase)

    def sweep(self, duration: float) -> tuple[float, float]:
        """Return its one frequency twice."""
        return self.frequency, self.frequency

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        omega = 2 * np.pi * self.frequency
        return Block(_step, {"amplitude": self.amplitude, "omega": omega, "phase": self.phase})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivatives in frequency, amplitude and phase."""
        angle = 2 * np.pi * self.frequency * conditions.time + self.phase
        sine = -self.amplitude * np.sin(angle)
        return {"frequency": 2 * np.pi * conditions.time * sine, "amplitude": np.cos(angle), "phase": sine}

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return a line whose amplitude and phase change linearly and quadratically, and its next two harmonics."""
        angle = 2 * np.pi * self.frequency * conditions.time + self.phase
        centred = np.linspace(-1.0, 1.0, len(conditions))
        wave = np.exp(1j * angle)
        drifting = np.column_stack([centred * wave, (centred**2 - 1 / 3) * wave])
        harmonics = [wave[:, None] ** k for k in (2, 3) if k * self.frequency * conditions.interval < HIGHEST]
        return [np.column_stack([way.real, way.imag]) for way in (drifting, *harmonics)]

    @classmethod
    def at(cls, frequency: float, fit: Residual) -> "Sinusoid":
        """Return the line of a frequency [Hz] fitted to the residual of a fit, before the output filter."""
        output_filter, conditions = fit.description.noise.output_filter, fit.sequence.conditions
        passed = 1.0 if output_filter is None else output_filter.response(np.array([frequency]), conditions.interval)[0]
        wave = 2 * np.mean(fit.residual * np.exp(-2j * np.pi * frequency * conditions.time)) / passed
        return cls(frequency, float(abs(wave)), float(np.angle(wave)))

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the highest line of the spectrum of the whitened residual."""
        frequency, gains, level = fit.lines
        best = int(np.argmax(gains))
        effect = cls.at(float(frequency[best]), fit)
        yield Start(effect, LINE, len(gains) / 2, float(gains[best]), float(level[best]))

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return amplitude^2 sin^4(pi f tau)/(pi f tau)^2 (IEEE 952)."""
        turns = self.frequency * np.asarray(tau, float)
        return (self.amplitude * np.sin(np.pi * turns) * np.sinc(turns)) ** 2

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return amplitude^2 sin^4(n u)/(n sin u)^2, u = pi f interval: means of n samples in place of integrals."""
        n, u = np.asarray(averaging), np.pi * self.frequency * interval
        return (self.amplitude * np.sin(n * u) * diric(2 * u, n)) ** 2


def _step(own, x, now):
    return x + own.amplitude * cos(own.omega * now.time(0) + own.phase)
