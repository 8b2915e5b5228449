"""Linear chirp: a spectral line whose frequency changes at a constant rate."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos
from typing import ClassVar

import numpy as np
from scipy.fft import fft, next_fast_len

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.effects.sinusoid import LINE, Sinusoid
from imugap.numerics.spectra.stack_slide import highest_track

CHIRP = ("frequency", "chirp_rate", "amplitude", "phase")
"""Parameters that a fit adjusts."""
HIGHEST = 0.48
"""Highest frequency times interval of a harmonic."""
REACH, FINER = 2.0, 4
"""Frequencies, and drifts of them over the log, about a track that are searched, in widths of a line in a segment of
the track; steps per width of a line in the log."""
GRID = 2**21
"""Largest number of points of the grid of frequencies and drifts that are held at a time."""
SLOWEST, SLOW_STEP = 24, 2
"""Drift over the log, in widths of a line, from which on the track of a chirp is seen, and step of the lesser ones."""
BAND = 64
"""Frequencies of a band over which the level of the power is taken."""
EVEN = float(np.log(2) + 3 * np.sqrt(2 / BAND))
"""Median of exponentially distributed power of mean 1 over a band, and three standard deviations."""


@dataclass(frozen=True)
class Chirp(SystematicEffect):
    """Linear chirp amplitude cos(2 pi (f t + c t^2/2) + phase) (Djuric and Kay 1990, doi:10.1109/29.61538).

    A chirp of negative frequency is one of the opposite chirp rate and phase, so that the frequency at power-on is
    positive without loss of generality.
    """

    name: ClassVar[str] = "chirp"
    most: ClassVar[int] = 3
    tonal: ClassVar[bool] = True
    essential: ClassVar[tuple[str, ...]] = ("chirp_rate",)
    memoryless: ClassVar[bool] = True
    frequency: float = parameter("Hz", "f, frequency at power-on")
    chirp_rate: float = parameter("Hz/s", "c, change of the frequency per time", low=-np.inf)
    amplitude: float = parameter("{u}", "amplitude")
    phase: float = parameter("rad", "phase at power-on", low=-np.inf, default=0.0)

    def angle(self, time: np.ndarray) -> np.ndarray:
        """Return the argument of the cosine [rad] at ``time`` [s]."""
        return 2 * np.pi * (self.frequency + self.chirp_rate * time / 2) * time + self.phase

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the chirp at the sample times."""
        return self.amplitude * np.cos(self.angle(conditions.time))

    def simpler(self, time: float) -> Start:
        """Return the line of the frequency and the phase at a time."""
        frequency, bend = self.frequency + self.chirp_rate * time, np.pi * self.chirp_rate * time**2
        line = Sinusoid(max(abs(frequency), TINY), self.amplitude, float(np.sign(frequency) * (self.phase - bend)))
        return Start(line, LINE)

    def sweep(self, duration: float) -> tuple[float, float]:
        """Return the frequencies at both ends of a log."""
        return self.frequency, self.frequency + self.chirp_rate * duration

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        turns = {"omega": 2 * np.pi * self.frequency, "bend": np.pi * self.chirp_rate}
        return Block(_step, {"amplitude": self.amplitude, "phase": self.phase, **turns})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivatives in all parameters."""
        time = conditions.time
        angle = self.angle(time)
        sine = -self.amplitude * np.sin(angle)
        by_frequency = 2 * np.pi * time * sine
        return {
            "frequency": by_frequency,
            "chirp_rate": by_frequency * time / 2,
            "amplitude": np.cos(angle),
            "phase": sine,
        }

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return a chirp whose amplitude and phase change up to the third power of time, and its next two harmonics."""
        wave = np.exp(1j * self.angle(conditions.time))
        centred = np.linspace(-1.0, 1.0, len(conditions))
        drifting = np.polynomial.legendre.legvander(centred, 3)[:, 1:] * wave[:, None]
        ends = np.abs(self.frequency + self.chirp_rate * conditions.time[[0, -1]])
        harmonics = [wave[:, None] ** k for k in (2, 3) if k * ends.max() * conditions.interval < HIGHEST]
        return [np.column_stack([way.real, way.imag]) for way in (drifting, *harmonics)]

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the highest chirp of the whitened residual, as it fits best beside the terms."""
        frequency, rate, trials, level = fit.once(_highest)
        angle = cls(frequency, rate, 1.0).angle(fit.sequence.conditions.time)
        columns = fit.whiten(np.column_stack([np.cos(angle), -np.sin(angle)]))
        (cosine, sine), *_ = np.linalg.lstsq(columns, fit.coefficients, rcond=None)
        gain, _ = fit.joint_gain(columns)
        effect = cls(frequency, rate, float(np.hypot(cosine, sine)), float(np.arctan2(sine, cosine)))
        yield Start(effect, CHIRP, trials, gain / level, level)


def _highest(fit: Residual) -> tuple[float, float, float, float]:
    """Return frequency at power-on [Hz], chirp rate [Hz/s], trials and level of the highest chirp of a residual.

    The trials are the frequencies, 1/T apart over the log of T, times the chirp rates, 4/T^2 apart.
    """
    whitened, conditions = fit.unrounded, fit.sequence.conditions
    count, interval = len(whitened), conditions.interval
    track = highest_track(whitened)
    likely = [_near(whitened, *_slow(whitened), SLOW_STEP)]
    if track is not None:
        likely.append(_near(whitened, track.begin * count, track.drift * count, int(REACH * track.segments)))
    _, level, begin, drift = max(likely)
    rate = drift / (count * interval) ** 2
    frequency = begin / (count * interval) - rate * float(conditions.time[0])
    if frequency < 0:
        frequency, rate = -frequency, -rate
    return frequency, rate, count**2 / 8, level


def _slow(whitened: np.ndarray) -> tuple[float, float]:
    """Return first frequency and drift over the log [cycles per log] of the highest chirp of little drift."""
    count = len(whitened)
    length = next_fast_len(count)
    curve = np.pi * ((np.arange(count) - (count - 1) / 2) / count) ** 2
    best, turned, step = (0.0, 0.0, 0.0), whitened.astype(complex), np.exp(-1j * SLOW_STEP * curve)
    for drift in np.arange(0.0, SLOWEST + SLOW_STEP, SLOW_STEP):
        lines = fft(turned.astype(np.complex64), length)
        turned *= step
        power = (lines.real**2 + lines.imag**2) / np.float32(count)
        up, down = power[2 : length // 2], power[: length - length // 2 : -1]
        for side, power in ((1, up), (-1, down[1 : len(up) + 1])):
            at, gain = _highest_line(power)
            best = max(best, (gain, (at + 2) * count / length - side * drift / 2, side * drift))
    return best[1:]


def _highest_line(power: np.ndarray) -> tuple[int, float]:
    """Return place and gain of the highest of exponentially distributed powers, shape (n,), over their level.

    The level is that of a band about each, at least 1; the last band has the remaining powers.
    """
    bands = max(len(power) // BAND, 1)
    parts = np.ascontiguousarray(power[: bands * BAND]).reshape(bands, -1)
    middle = np.partition(parts, parts.shape[1] // 2, axis=1)[:, parts.shape[1] // 2]
    level = np.maximum(middle / np.float32(EVEN), np.float32(1.0))
    highest = parts.argmax(axis=1)
    gains = parts[np.arange(bands), highest] / level
    band = int(np.argmax(gains))
    found = band * parts.shape[1] + int(highest[band]), float(gains[band])
    rest = power[parts.size :]
    if rest.size and rest.max() / level[-1] > found[1]:
        return parts.size + int(np.argmax(rest)), float(rest.max() / level[-1])
    return found


def _near(whitened: np.ndarray, begin: float, drift: float, width: int) -> tuple[float, float, float, float]:
    """Return gain and level, first frequency and drift [cycles per log] of the highest chirp about a given one.

    Samples less the phase of the given chirp are averaged to few; the peak of their spectrum is taken over a grid of
    drifts. Gains are over the level of the power around the peak.
    """
    count = len(whitened)
    block = max(count // max(8 * width, 2 * BAND), 1)
    blocks = count // block
    time = np.arange(count) / count
    turned = whitened * np.exp(-2j * np.pi * (begin + drift * time / 2) * time)
    means = turned[: blocks * block].reshape(blocks, block).sum(axis=1)
    centre = (np.arange(blocks) + 0.5) * block / count - 0.5
    drifts = np.arange(-width * FINER, width * FINER + 1) / FINER
    shifts = np.r_[: width * FINER + 1, -width * FINER : 0]
    highest, best, shift = 0.0, 0, 0
    parts = min(-(-len(drifts) * FINER * blocks // GRID), len(drifts))
    for rows in np.array_split(np.arange(len(drifts)), parts):
        power = _powers(means, centre, drifts[rows])[:, shifts]
        row, column = np.unravel_index(np.argmax(power), power.shape)
        if power[row, column] > highest:
            highest, best, shift = float(power[row, column]), int(rows[row]), int(shifts[column])
    spectrum = _powers(means, centre, drifts[[best]])[0, ::FINER] / count
    level = max(float(np.median(spectrum)) / EVEN, 1.0)
    first = begin + shift * count / (FINER * blocks * block) - drifts[best] / 2
    return highest / count / level, level, float(first), float(drift + drifts[best])


def _powers(means: np.ndarray, centre: np.ndarray, drifts: np.ndarray) -> np.ndarray:
    """Return the squared spectra of means without a drift each, shape (drifts, FINER * blocks)."""
    turned = means * np.exp(-1j * np.pi * drifts[:, None] * centre**2)
    return np.abs(fft(turned, FINER * len(means), axis=1)) ** 2


def _step(own, x, now):
    return x + own.amplitude * cos((own.omega + own.bend * now.time(0)) * now.time(0) + own.phase)
