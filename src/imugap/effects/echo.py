"""Echo: an output that contains a delayed copy of itself."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import LONGEST, Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, FilterEffect, Start, Transform, parameter
from imugap.effects.residual import Residual


@dataclass(frozen=True)
class Echo(FilterEffect):
    """Delayed copy in the output, y[k] = x[k] + s a x[k - d], as of a driver that adds an older packet.

    s is 1, or -1 for an ``inverted`` copy. The power gain is 1 + a^2 + 2 s a cos(2 pi f d interval), the comb of
    Bogert, Healy and Tukey (1963), The quefrency alanysis of time series for echoes, where it gives the cepstrum a peak
    at the delay. It acts on the true motion and on the errors. Ahead of the log the output is taken for constant.
    White noise with an inverted copy of one sample has the spectrum of quantization beside white noise.
    """

    name: ClassVar[str] = "echo"
    rippled: ClassVar[bool] = True
    size: float = parameter("1", "a, size of the copy over that of the signal", low=TINY, high=1.0)
    delay: float = parameter("1", "d, delay in samples", low=1.0, high=float(LONGEST), whole=True)
    inverted: float = parameter("1", "1 for a copy that is subtracted", high=1.0, whole=True, default=0)

    @property
    def signed(self) -> float:
        """Size of the copy with its sign."""
        return -self.size if self.inverted else self.size

    def passed(self, values: np.ndarray, interval: float) -> np.ndarray:
        """Return samples with their echo, shape (n,) or (n, m), with the first one as a constant input before."""
        return self._with_copy(values, np.repeat(values[:1], int(self.delay), axis=0))

    def _with_copy(self, values: np.ndarray, earlier: np.ndarray) -> np.ndarray:
        """Return samples with their echo; the ``delay`` samples ahead of them are ``earlier``."""
        return values + self.signed * np.concatenate([earlier, values])[: len(values)]

    def decay(self, count: int, interval: float) -> np.ndarray:
        """Return the copy of a constant input of 1 ahead of the log, in the first ``count`` samples."""
        return np.where(np.arange(count) < self.delay, self.signed, 0.0)

    def gain(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the power gain at ``frequency`` [Hz], shape of it."""
        return self.mean_gain(frequency, 0.0, interval)

    def mean_gain(self, frequency: np.ndarray, width: np.ndarray | float, interval: float) -> np.ndarray:
        """Return the mean power gain over bands of a width [Hz] about ``frequency`` [Hz], shape of it."""
        ripple = np.cos(2 * np.pi * frequency * self.delay * interval) * np.sinc(width * self.delay * interval)
        return 1 + self.size**2 + 2 * self.signed * ripple

    def response(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the complex gain at ``frequency`` [Hz], shape of it."""
        return 1 + self.signed * np.exp(-2j * np.pi * frequency * self.delay * interval)

    def highest(self, interval: float) -> float:
        """Return the largest size."""
        return self.limits()["size"][1]

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return the echo of one part after the other."""
        earlier = np.empty(0)

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal earlier
            earlier = earlier if len(earlier) else np.repeat(sequence[:1], int(self.delay))
            output = self._with_copy(sequence, earlier)
            earlier = np.concatenate([earlier, sequence])[-int(self.delay) :]
            return output

        return transform

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step."""
        return Block(_step, {"size": self.signed, "earlier": np.zeros(int(self.delay))}, _steady)

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the echo of the highest ripple in the spectrum of the residual, where there is no filter yet, at rest.

        In motion the residual has ripples of its own, and a fit behind a filter takes long.
        """
        if fit.description.noise.output_filter is None and fit.sequence.conditions.motion is None:
            sizes, gains = fit.ripples
            best = 1 + int(np.argmax(gains[1:]))  # that of one sample is quantization, or a filter
            size, inverted = min(max(abs(sizes[best]), TINY), 1.0), float(sizes[best] < 0)
            yield Start(cls(size, best + 1.0, inverted), ("size",), trials=len(gains), gain=float(gains[best]))


def _steady(own, x, now):
    for k in range(len(own.earlier)):
        own.earlier[k] = x


def _step(own, x, now):
    y = x + own.size * own.earlier[len(own.earlier) - 1]
    for k in range(len(own.earlier) - 1, 0, -1):
        own.earlier[k] = own.earlier[k - 1]
    own.earlier[0] = x
    return y
