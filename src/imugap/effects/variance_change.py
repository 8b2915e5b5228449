"""Change of the noise level."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from imugap.effects.effect import Conditions, Effect, Stage, Start, parameter

if TYPE_CHECKING:
    from imugap.discovery.axis import AxisFit

STRETCHES = 1e5
"""Independent stretches of a long log, on the safe side."""


@dataclass(frozen=True)
class VarianceChange(Effect):
    """White noise whose variance is ``ratio`` times its own for start <= t < stop.

    The spectra and Allan variances of the model are those outside of that time.
    """

    name: ClassVar[str] = "variance_change"
    stage: ClassVar[Stage] = Stage.MODULATION
    start: float = parameter("s", "begin of the change since power-on")
    stop: float = parameter("s", "end of the change since power-on")
    ratio: float = parameter("1", "variance during the change over that outside")

    def __post_init__(self) -> None:
        """Check the limits, and that the end is not before the begin."""
        super().__post_init__()
        if self.stop < self.start:
            raise ValueError(f"{self.name}.stop: expected a time >= start = {self.start!r}; found {self.stop!r}")

    def within(self, time: np.ndarray) -> np.ndarray:
        """Return which times [s] are in the stretch."""
        return (time >= self.start) & (time < self.stop)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Scale the noise by sqrt(ratio) during the change."""
        return np.where(self.within(conditions.time), np.sqrt(self.ratio), 1.0) * sequence

    @classmethod
    def starts(cls, fit: "AxisFit") -> Iterator[Start]:
        """Yield the stretch of the whitened residual whose variance differs most."""
        gain, first, last = fit.stretch
        if gain <= 0:
            return
        time, squares = fit.sequence.conditions.time, fit.whitened**2
        inside, outside = squares[first:last].mean(), np.r_[squares[:first], squares[last:]].mean()
        stop = time[last] if last < len(time) else time[-1] + fit.sequence.conditions.interval
        effect = cls(float(time[first]), float(stop), float(inside / outside))
        yield Start(effect, ("ratio",), trials=STRETCHES, gain=gain)
