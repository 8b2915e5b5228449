"""Comb: lines at a fundamental and its multiples, steady or of a fundamental that changes at a constant rate."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import cos, gcd
from typing import ClassVar, Self

import numpy as np

from imugap.effects.block import Block
from imugap.effects.chirp import Chirp
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Start, SystematicEffect, parameter
from imugap.effects.sinusoid import Sinusoid

HARMONICS = range(1, 7)
"""Numbers of the harmonics."""
NEAR = 1.0
"""Distance of two lines, over the sum of their numbers, up to which they may be of one comb [widths of a line]."""


@dataclass(frozen=True)
class Comb(SystematicEffect):
    """Sum of amplitude_k cos(2 pi k (f t + c t^2/2) + phase_k), as a rotor makes it whose speed drifts.

    No fit starts with it: it takes the place of the lines and chirps of which it is made. Discovery names it where its
    frequency changes: steady lines make a wave of any shape and cause.
    """

    name: ClassVar[str] = "comb"
    tonal: ClassVar[bool] = True
    essential: ClassVar[tuple[str, ...]] = ("chirp_rate",)
    memoryless: ClassVar[bool] = True
    frequency: float = parameter("Hz", "f, fundamental frequency at power-on", low=TINY)
    chirp_rate: float = parameter("Hz/s", "c, change of the fundamental frequency per time", low=-np.inf, default=0.0)
    amplitude_1: float = parameter("{u}", "amplitude of the fundamental", default=0.0)
    phase_1: float = parameter("rad", "phase of the fundamental at power-on", low=-np.inf, default=0.0)
    amplitude_2: float = parameter("{u}", "amplitude at 2 f", default=0.0)
    phase_2: float = parameter("rad", "phase at power-on, at 2 f", low=-np.inf, default=0.0)
    amplitude_3: float = parameter("{u}", "amplitude at 3 f", default=0.0)
    phase_3: float = parameter("rad", "phase at power-on, at 3 f", low=-np.inf, default=0.0)
    amplitude_4: float = parameter("{u}", "amplitude at 4 f", default=0.0)
    phase_4: float = parameter("rad", "phase at power-on, at 4 f", low=-np.inf, default=0.0)
    amplitude_5: float = parameter("{u}", "amplitude at 5 f", default=0.0)
    phase_5: float = parameter("rad", "phase at power-on, at 5 f", low=-np.inf, default=0.0)
    amplitude_6: float = parameter("{u}", "amplitude at 6 f", default=0.0)
    phase_6: float = parameter("rad", "phase at power-on, at 6 f", low=-np.inf, default=0.0)

    @property
    def amplitudes(self) -> dict[int, float]:
        """Return the amplitude of each harmonic that it has, by its number."""
        every = {number: getattr(self, f"amplitude_{number}") for number in HARMONICS}
        return {number: amplitude for number, amplitude in every.items() if amplitude}

    def phase(self, number: int) -> float:
        """Return the phase of a harmonic at power-on [rad]."""
        return getattr(self, f"phase_{number}")

    def turned(self, time: np.ndarray | float) -> np.ndarray | float:
        """Return the angle of the fundamental [rad] at ``time`` [s], less its phase."""
        return 2 * np.pi * (self.frequency + self.chirp_rate * time / 2) * time

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the comb at the sample times."""
        angle = self.turned(conditions.time)
        waves = (size * np.cos(k * angle + self.phase(k)) for k, size in self.amplitudes.items())
        return sum(waves, np.zeros(len(conditions)))

    @property
    def periodic(self) -> bool:
        """Return whether its frequency is steady."""
        return not self.chirp_rate

    def start(self) -> Start:
        """Return it as a start, free but for the harmonics that it has not, and for a rate of zero."""
        free = [f"{name}_{number}" for number in self.amplitudes for name in ("amplitude", "phase")]
        return Start(self, ("frequency", *(["chirp_rate"] if self.chirp_rate else []), *free))

    def simpler(self, time: float) -> Start:
        """Return the comb of the steady frequency, and of the phases, that it has at a time."""
        steady = replace(self, frequency=max(self.frequency + self.chirp_rate * time, TINY), chirp_rate=0.0)
        return self._in_phase(steady, time).start()

    def _in_phase(self, other: Self, time: float) -> Self:
        """Return another comb with the phases that this one has at a time [s]."""
        lead = self.turned(time) - other.turned(time)
        return replace(other, **{f"phase_{k}": _wrapped(self.phase(k) + k * lead) for k in self.amplitudes})

    def sweep(self, duration: float) -> tuple[float, float]:
        """Return the frequencies of the fundamental at both ends of a log."""
        return self.frequency, self.frequency + self.chirp_rate * duration

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        turns = {"omega": 2 * np.pi * self.frequency, "bend": np.pi * self.chirp_rate}
        sizes = [getattr(self, f"amplitude_{number}") for number in HARMONICS]
        return Block(_step, {"amplitude": sizes, "phase": [self.phase(number) for number in HARMONICS], **turns})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivatives in all parameters."""
        time, angle = conditions.time, self.turned(conditions.time)
        found, turning = {}, np.zeros(len(time))
        for number in HARMONICS:
            wave = np.exp(1j * (number * angle + self.phase(number)))
            found[f"amplitude_{number}"] = wave.real
            found[f"phase_{number}"] = -getattr(self, f"amplitude_{number}") * wave.imag
            turning += number * found[f"phase_{number}"]
        by_frequency = 2 * np.pi * time * turning
        return {"frequency": by_frequency, "chirp_rate": by_frequency * time / 2, **found}

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return each harmonic with an amplitude and a phase that change up to the third power of time."""
        angle, centred = self.turned(conditions.time), np.linspace(-1.0, 1.0, len(conditions))
        powers = np.polynomial.legendre.legvander(centred, 3)[:, 1:]
        ways = (powers * np.exp(1j * number * angle)[:, None] for number in self.amplitudes)
        return [np.column_stack([way.real, way.imag]) for way in ways]

    @classmethod
    def of(cls, tone: Sinusoid | Chirp | Self) -> Self:
        """Return a line or a chirp as a comb of one harmonic; a comb as it is."""
        if isinstance(tone, cls):
            return tone
        return cls(tone.frequency, getattr(tone, "chirp_rate", 0.0), tone.amplitude, tone.phase)

    def _within(self, fundamental: Self, number: int, time: float) -> Self:
        """Return it as harmonics of the fundamental of another, whose harmonic of a number is its own, at a time."""
        sizes = {f"amplitude_{number * k}": size for k, size in self.amplitudes.items()}
        lead = number * fundamental.turned(time) - self.turned(time)
        phases = {f"phase_{number * k}": _wrapped(self.phase(k) - k * lead) for k in self.amplitudes}
        return replace(fundamental, **sizes, **phases)

    @classmethod
    def joining(cls, one: Effect, other: Effect, conditions: Conditions) -> Iterator[Start]:
        """Yield the combs of which two lines, chirps or combs may be harmonics."""
        if not (isinstance(one, Sinusoid | Chirp | cls) and isinstance(other, Sinusoid | Chirp | cls)):
            return
        both, time = (cls.of(one), cls.of(other)), float(conditions.time[[0, -1]].mean())
        duration = conditions.interval * len(conditions)
        middle = [comb.frequency + comb.chirp_rate * time for comb in both]
        rates = [comb.chirp_rate for comb in both]
        if not any(rates):
            return  # steady lines make a wave of any shape and cause
        for numbers in product(HARMONICS, repeat=2):
            apart = abs(numbers[1] * middle[0] - numbers[0] * middle[1]) * duration
            own = [{k * number for k in comb.amplitudes} for number, comb in zip(numbers, both, strict=True)]
            whole = own[0] | own[1] <= set(HARMONICS) and not own[0] & own[1]
            if gcd(*numbers) > 1 or not whole or apart > NEAR * sum(numbers):
                continue
            power = [sum((k * size) ** 2 for k, size in comb.amplitudes.items()) for comb in both]
            weights = [size * number for size, number in zip(power, numbers, strict=True)]
            scale = np.dot(weights, numbers)
            rate, frequency = (float(np.dot(weights, values) / scale) for values in (rates, middle))
            if frequency > rate * time:
                joint = cls(frequency - rate * time, rate)
                for comb, number in zip(both, numbers, strict=True):
                    joint = comb._within(joint, number, time)
                yield joint.start()


def _wrapped(angle: float) -> float:
    """Return an angle within half a turn of zero [rad]."""
    return float(np.angle(np.exp(1j * angle)))


def _step(own, x, now):
    turned = (own.omega + own.bend * now.time(0)) * now.time(0)
    for k in range(len(own.amplitude)):
        x = x + own.amplitude[k] * cos((k + 1) * turned + own.phase[k])
    return x
