"""An effect of one's own: a heater that is switched on and off by a clock, and shifts the bias while it is on."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import Start, SystematicEffect, parameter


@dataclass(frozen=True)
class Heater(SystematicEffect):
    """Bias that is higher by ``amplitude`` during the first half of every period of the heater's clock."""

    name: ClassVar[str] = "heater"
    amplitude: float = parameter("{u}", "shift of the bias while the heater is on", low=-np.inf)
    period: float = parameter("s", "period of the clock, from the heater's data sheet", default=40.0)

    def sample(self, conditions, rng):
        """Return the shift at every sample."""
        return self.amplitude * self._on(conditions)

    def slopes(self, conditions):
        """Return the derivative of :meth:`sample` in the amplitude."""
        return {"amplitude": self._on(conditions)}

    def _on(self, conditions):
        return (conditions.time % self.period < self.period / 2).astype(float)

    @classmethod
    def starts(cls, fit):
        """Yield where its fit starts, once per axis: at no shift, the amplitude free."""
        if not fit.has(cls):
            yield Start(cls(0.0), ("amplitude",))
