"""Change of the noise level."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block, cos, exp, sqrt
from imugap.effects.effect import TINY, Start, VarianceEffect, parameter
from imugap.effects.residual import Residual

STRETCHES = 1e5
"""Upper limit of the number of independent intervals of a long log."""
LEAST = 1e-6
"""Smallest ratio of variances of a search."""
SWINGS = 1e3
"""Upper limit of the number of independent frequencies of a periodic change."""
DEEPEST = 60.0
"""Largest swing of the logarithm of the variance: beyond it numbers overflow."""
STRETCH, SWING = ("ratio",), ("depth", "frequency", "phase")
"""Parameters that are fitted: of an interval of another variance, and of a periodic change over the whole log."""


@dataclass(frozen=True)
class VarianceChange(VarianceEffect):
    """White noise whose variance is ratio exp(depth cos(2 pi frequency t + phase)) times its own for start <= t < stop.

    The spectra and Allan variances of the model are those outside of that time.
    """

    name: ClassVar[str] = "variance_change"
    most: ClassVar[int] = 3
    memoryless: ClassVar[bool] = True
    start: float = parameter("s", "begin of the change since power-on")
    stop: float = parameter("s", "end of the change since power-on")
    ratio: float = parameter("1", "variance during the change over that outside", low=TINY, default=1.0)
    depth: float = parameter("1", "swing of the logarithm of the variance during the change", high=DEEPEST, default=0.0)
    frequency: float = parameter("Hz", "frequency of the swing", default=0.0)
    phase: float = parameter("rad", "phase of the swing at power-on", low=-np.inf, default=0.0)

    def __post_init__(self) -> None:
        """Check the limits, and that the end is not before the begin."""
        super().__post_init__()
        if self.stop < self.start:
            raise ValueError(f"{self.name}.stop: expected a time >= start = {self.start!r}; found {self.stop!r}")

    @property
    def once(self) -> bool:
        """Return whether the change is limited in time, and not periodic over the whole log."""
        return self.depth == 0

    def within(self, time: np.ndarray) -> np.ndarray:
        """Return the mask of the times [s] within the change."""
        return (time >= self.start) & (time < self.stop)

    def factor(self, time: np.ndarray) -> np.ndarray:
        """Return the factor of the variance at each time [s], shape of it."""
        swing = self.depth * np.cos(2 * np.pi * self.frequency * time + self.phase) if self.depth else 0.0
        return np.where(self.within(time), self.ratio * np.exp(swing), 1.0)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        omega = 2 * np.pi * self.frequency
        swing = {"ratio": self.ratio, "depth": self.depth, "omega": omega, "phase": self.phase}
        return Block(_step, {"begin": self.start, "end": self.stop, **swing})

    def free(self) -> tuple[str, ...]:
        """Return the parameters of a search besides the interval: those of a periodic change, if any."""
        return SWING if self.depth else STRETCH

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the interval of the residual with the most different variance, and the best periodic change."""
        gain, first, last = fit.stretch
        time, squares = fit.sequence.conditions.time, fit.unrounded**2
        end = float(time[-1] + fit.sequence.conditions.interval)
        if gain > 0:
            if first == 0:  # what comes later has changed
                first, last = last, len(time)
            inside, outside = squares[first:last].mean(), np.r_[squares[:first], squares[last:]].mean()
            stop = float(time[last]) if last < len(time) else end
            ratio = float(np.clip(inside / max(outside, LEAST), LEAST, 1 / LEAST))
            yield Start(cls(float(time[first]), stop, ratio), STRETCH, STRETCHES, gain)
        frequency, depth, phase, gain = fit.swing
        effect = cls(float(time[0]), end, depth=depth, frequency=frequency, phase=phase)
        yield Start(effect, SWING, SWINGS, gain)


def _step(own, x, now):
    y = x
    if own.begin <= now.time(0) and now.time(0) < own.end:
        y = sqrt(own.ratio * exp(own.depth * cos(own.omega * now.time(0) + own.phase))) * x
    return y
