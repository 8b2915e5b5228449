"""Low-pass filter of the output."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numba import njit
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from imugap.effects.block import CHANNELS, Block, require_short
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, FilterEffect, Start, Transform, parameter
from imugap.effects.residual import Residual
from imugap.numerics.spectra.fractional_bank import frequencies, least_phase

DEFICIT = -2.5
"""Deficit of the power near half the rate [standard deviations] below which a search tries a filter."""
BILINEAR, ALL_POLE, ANALOGUE, SAMPLED = 0, 1, 2, 3
"""Forms: Butterworth by the bilinear transform, all-pole, and analogue Butterworth before the sampling, of a signal
without power beyond half the rate, or with aliasing."""
AHEAD = (ANALOGUE, SAMPLED)
"""Forms of a filter before the sampling."""
SHAPES = ((1, 0), (2, 0), (3, 0), (4, 0), (1, 1), (2, 1), (1, 2), (2, 2), (3, 2), (4, 2), (2, 3), (3, 3), (4, 3))
"""Order and form of the filters of a search."""
LOWEST = 1e-6
"""Product of cutoff and interval of a digital filter below which rounding moves its poles: 1 + a1 + a2 of a section is
(2 pi cutoff interval)^2, and a1 and a2 are rounded to 2e-16."""
OPEN = 20.0
"""Angle pi cutoff interval above which the gain is 1 to rounding."""
LARGEST_POWER = 1e300
"""Attenuation of power above which a filter passes nothing."""
SETTLED = 20.0
"""Settling time of an analogue filter [radians of the cutoff, for each order]."""
TAPS, FINE = 48, 4096
"""Samples over which the impulse response fades at either end, and fewest frequencies of a filter of least phase."""
FOLDS = 8
"""Largest multiple of the rate from which noise is aliased, either way."""


@dataclass(frozen=True)
class OutputFilter(FilterEffect):
    """Maximally flat low-pass filter of the output: 1/(1 + (w(f)/c)^(2 order)) is its power gain.

    It acts on the true motion and on the errors; its effect on the motion is an error too.

    With w(f) = tan(pi f interval) and c = tan(pi cutoff interval) it is the Butterworth filter through the bilinear
    transform, with a zero at half the sampling rate. With w(f) = sin(pi f interval) and c = sinh(pi cutoff interval) it
    is all-pole; of order 1 it is exponential smoothing, and white noise after it has the spectrum of sampled noise
    after an RC element of this cutoff. With w(f) = f and c = cutoff it is the analogue Butterworth filter of a signal
    without power beyond half the rate. The last form is the analogue filter of white noise, sampled with aliasing: its
    power gain is the sum of the gains at all aliases of a frequency, over the sum at 0; of order 1 it equals the
    all-pole form. The cutoff of the last two forms may exceed half the rate.
    """

    name: ClassVar[str] = "output_filter"
    cutoff: float = parameter("Hz", "frequency at which the power gain is 1/2 ahead of the sampling", low=TINY)
    order: float = parameter("1", "order", low=1.0, high=8.0, whole=True, default=1)
    form: float = parameter(
        "1", "0: bilinear, 1: poles alone, 2: analogue, 3: analogue, folded", high=3.0, whole=True, default=0
    )

    @property
    def centre(self) -> float:
        """Cutoff [Hz]."""
        return self.cutoff

    def passed(self, values: np.ndarray, interval: float) -> np.ndarray:
        """Return filtered samples, shape (n,) or (n, m), with the first one as a constant input before."""
        if self.form in AHEAD:
            return self._analogue(values, interval)
        from scipy.signal import sosfilt  # long import, and most models have no filter

        sections, steady = _sections(self, interval)
        state = steady * values[0] if values.ndim == 1 else steady[..., None] * values[0]
        return sosfilt(sections, values, axis=0, zi=state)[0]

    def decay(self, count: int, interval: float) -> np.ndarray:
        """Return the response of the first ``count`` samples to a constant input of 1 before them, shape (count,)."""
        return _decay(self, count, interval)

    def gain(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the power gain at ``frequency`` [Hz], shape of it."""
        self.check_rate(interval)
        if self.form == SAMPLED:
            own = np.atleast_1d(np.asarray(frequency, float))
            folded = _folded(own, 1 / interval, self.cutoff, int(self.order))
            return (folded / _folded(np.zeros(1), 1 / interval, self.cutoff, int(self.order))).reshape(
                np.shape(frequency)
            )
        return self._plain(np.asarray(frequency, float), interval)

    def _plain(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the power gain without folding."""
        ratio = np.minimum(np.abs(self._ratio(frequency, interval)), LARGEST_POWER ** (0.5 / self.order))
        return 1 / (1 + ratio ** (2 * self.order))

    def _ratio(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return w(f)/c."""
        if self.form in AHEAD:
            return frequency / self.cutoff
        x = np.pi * frequency * interval
        return np.sin(x) / self.corner(interval) if self.form == ALL_POLE else np.tan(x) / self.corner(interval)

    def corner(self, interval: float) -> float:
        """Return c of the digital filters; an all-pole filter far beyond the rate has gain 1."""
        angle = np.pi * self.cutoff * interval
        return float(np.sinh(min(angle, OPEN)) if self.form == ALL_POLE else np.tan(angle))

    def response(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the complex gain at ``frequency`` [Hz], shape of it."""
        from scipy.signal import buttap, sosfreqz

        if self.form in AHEAD:
            own = np.asarray(frequency, float)
            passed = 1 / np.prod(1j * own[..., None] / self.cutoff - buttap(int(self.order))[1], axis=-1)
            return passed * np.sqrt(self.gain(own, interval) / self._plain(own, interval))
        return sosfreqz(_sections(self, interval)[0], worN=frequency, fs=1 / interval)[1]

    def _analogue(self, values: np.ndarray, interval: float) -> np.ndarray:
        """Filter in the frequency domain; the first sample is held before the log, a slope leads back to it after."""
        count = len(values)
        lead = min(int(np.ceil(SETTLED * self.order / (2 * np.pi * self.cutoff * interval))), count) + 1
        length = next_fast_len(count + 3 * lead, real=True)
        own = values[:, None] if values.ndim == 1 else values
        slope = np.linspace(1.0, 0.0, length - count - 2 * lead)[:, None]
        held = np.vstack([np.zeros((lead, own.shape[1])), own - own[0], np.repeat(own[-1:] - own[0], lead, axis=0)])
        padded = np.vstack([held, slope * (own[-1:] - own[0])])
        gain = _response(self, length, interval)
        passed = irfft(rfft(padded, axis=0) * gain, length, axis=0)[lead : lead + count] + own[0]
        return passed.reshape(values.shape)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform | None:
        """Return a digital filter of one part after the other; None for the forms that need the samples to come."""
        if self.form in AHEAD:
            return None
        from scipy.signal import sosfilt

        sections, steady = _sections(self, run.interval)
        state = None

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal state
            passed, state = sosfilt(sections, sequence, zi=steady * sequence[0] if state is None else state)
            return passed

        return transform

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step.

        The digital forms are recursions. Those ahead of the sampling are not causal as filters of samples: the input,
        which is known ahead, passes the band-limited impulse response (:data:`TAPS`), and the errors a causal filter of
        the same power gain, of least phase.
        """
        self.check_rate(interval)
        if self.form not in AHEAD:
            sections, steady = _sections(self, interval)
            b0, b1, b2, _, a1, a2 = sections.T
            values = {"b0": b0, "b1": b1, "b2": b2, "a1": a1, "a2": a2, "held": steady[:, 0], "last": steady[:, 1]}
            return Block(_recursion, values, _steady)
        settling = SETTLED * self.order / (2 * np.pi * self.cutoff * interval)
        require_short(self.name, settling)
        impulse = self._impulse(int(np.ceil(settling)), interval)
        causal = least_phase(self.gain(frequencies(max(4 * int(settling), FINE)) / interval, interval))
        values = {
            "channel": CHANNELS[axis], "first": TAPS + 1 - len(impulse), "impulse": impulse[::-1],
            "causal": causal / causal.sum(), "errors": np.zeros(len(causal)),
        }  # fmt: skip
        return Block(_convolution, values, _held, past=len(impulse), ahead=TAPS)

    def _impulse(self, settling: int, interval: float) -> np.ndarray:
        """Return the band-limited impulse response from :data:`TAPS` samples ahead on, with tapered ends, of sum 1."""
        length = next_fast_len(8 * (settling + TAPS), real=True)
        weights = np.roll(irfft(_response(self, length, interval)[:, 0], length), TAPS)[: 2 * TAPS + settling]
        fade = 0.5 - 0.5 * np.cos(np.pi * (np.arange(TAPS) + 0.5) / TAPS)
        weights[:TAPS] *= fade
        weights[-TAPS:] *= fade[::-1]
        return weights / weights.sum()

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield filters of a few orders, where there is none yet."""
        if fit.description.noise.output_filter is None and fit.top < DEFICIT:
            for shape in SHAPES:
                yield Start(cls(0.3 / fit.sequence.conditions.interval, *shape), ("cutoff",), trials=len(SHAPES))

    def highest(self, interval: float) -> float:
        """Return the highest identifiable cutoff [Hz]."""
        return (0.499 if self.form == BILINEAR else 1.0) / interval

    def check_rate(self, interval: float) -> None:
        """Raise ValueError if the rate is too low for the cutoff."""
        if self.form == BILINEAR and self.cutoff * interval >= 0.5:
            raise ValueError(
                f"{self.name}.cutoff: expected less than half the rate, {0.5 / interval:g} Hz; found {self.cutoff:g} Hz"
            )


@njit(cache=True, error_model="numpy")
def _folded(frequency, rate, cutoff, order):
    """Return the sum of the power gains of an analogue filter at all aliases of each frequency [Hz], shape (n,)."""
    count, total = len(frequency), np.zeros(len(frequency))
    square, power = np.empty(count), np.empty(count)
    for fold in range(-FOLDS, FOLDS + 1):
        for k in range(count):
            square[k] = power[k] = ((frequency[k] + fold * rate) / cutoff) ** 2
        for _ in range(order - 1):
            for k in range(count):
                power[k] *= square[k]
        for k in range(count):
            total[k] += 1 / (1 + power[k])
    return total


@lru_cache(maxsize=64)
def _sections(one: OutputFilter, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the sections of second order of a digital filter, and their states after a constant input.

    All-pole: where (sin^2(pi f interval))^order is -(sinh^2(pi cutoff interval))^order, sin^2 being
    (2 - z - 1/z)/4, inside the unit circle.
    """
    from scipy.signal import butter, sosfilt_zi, zpk2sos

    one.check_rate(interval)
    if one.cutoff * interval < LOWEST:
        expected = f"expected at least {LOWEST / interval:g} Hz at {1 / interval:g} Hz, as rounding limits the filter"
        raise ValueError(f"{one.name}.cutoff: {expected}; found {one.cutoff:g} Hz")
    if one.form == BILINEAR:
        sections = butter(int(one.order), one.cutoff, fs=1 / interval, output="sos")
    else:
        turns = np.exp(1j * np.pi * (2 * np.arange(one.order) + 1) / one.order)
        middle = 1 - 2 * one.corner(interval) ** 2 * turns
        root = np.sqrt(middle**2 - 1)
        poles = 1 / np.where(np.abs(middle + root) > 1, middle + root, middle - root)
        sections = zpk2sos(np.zeros(len(poles)), poles, np.prod(1 - poles).real)
    return sections, sosfilt_zi(sections)


@lru_cache(maxsize=4)
def _response(one: OutputFilter, length: int, interval: float) -> np.ndarray:
    """Return the complex gain at the frequencies of ``length`` samples, shape (length // 2 + 1, 1), read-only."""
    gain = one.response(rfftfreq(length, interval), interval)[:, None]
    gain.flags.writeable = False
    return gain


@lru_cache(maxsize=4)
def _decay(one: OutputFilter, count: int, interval: float) -> np.ndarray:
    """Return the response to a constant input of 1 before the first sample, cached and read-only."""
    left = 1 - one.passed(np.r_[0.0, np.ones(count)], interval)[1:]
    left.flags.writeable = False
    return left


def _steady(own, x, now):
    for k in range(len(own.held)):
        own.held[k] = own.held[k] * x
        own.last[k] = own.last[k] * x


def _recursion(own, x, now):
    for k in range(len(own.held)):
        y = own.b0[k] * x + own.held[k]
        own.held[k] = own.b1[k] * x - own.a1[k] * y + own.last[k]
        own.last[k] = own.b2[k] * x - own.a2[k] * y
        x = y
    return x


def _held(own, x, now):
    for k in range(len(own.errors)):
        own.errors[k] = x - now.at(own.channel, 0)


def _convolution(own, x, now):
    for k in range(len(own.errors) - 1, 0, -1):
        own.errors[k] = own.errors[k - 1]
    own.errors[0] = x - now.at(own.channel, 0)
    y = 0.0
    for k in range(len(own.impulse)):
        y = y + own.impulse[k] * now.at(own.channel, own.first + k)
    for k in range(len(own.causal)):
        y = y + own.causal[k] * own.errors[k]
    return y
