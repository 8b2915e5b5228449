"""Change of the noise level."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import Conditions, Effect, Stage, parameter


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

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Scale the noise by sqrt(ratio) during the change."""
        changed = (conditions.time >= self.start) & (conditions.time < self.stop)
        return np.where(changed, np.sqrt(self.ratio), 1.0) * sequence
