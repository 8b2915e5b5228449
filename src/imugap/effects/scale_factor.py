"""Scale factor errors."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import CHANNELS, Block, fabs
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual

LAWS = (("error",), ("error", "asymmetry"), ("error", "nonlinearity"))
"""Sets of parameters of the starts of a search."""


@dataclass(frozen=True)
class ScaleFactor(SystematicEffect):
    """Error that depends on the input u of the own axis (IEEE 528: scale factor error, asymmetry, nonlinearity)."""

    name: ClassVar[str] = "scale_factor"
    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    error: float = parameter("1", "relative error of the scale factor", low=-np.inf)
    asymmetry: float = parameter("1", "half the scale factor of u > 0 less that of u < 0", low=-np.inf, default=0.0)
    nonlinearity: float = parameter("1/({u})", "error per square of the input", low=-np.inf, default=0.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return error u + asymmetry abs(u) + nonlinearity u^2."""
        u = self.error_free(conditions, [self.own_axis(conditions)])[:, 0]
        return self.error * u + self.asymmetry * np.abs(u) + self.nonlinearity * u**2

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        laws = {"error": self.error, "asymmetry": self.asymmetry, "nonlinearity": self.nonlinearity}
        return Block(_step, {"channel": CHANNELS[axis], **laws})

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return u, abs(u) and u^2."""
        u = self.error_free(conditions, [self.own_axis(conditions)])[:, 0]
        return {"error": u, "asymmetry": np.abs(u), "nonlinearity": u**2}

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the error alone, with an asymmetry, and with a nonlinearity, where the input is known."""
        conditions = fit.sequence.conditions
        if conditions.knows([conditions.axis]) and not fit.has(cls):
            for free in LAWS:
                yield from cls(0.0).proposed(fit, free, trials=len(LAWS))


def _step(own, x, now):
    u = now.at(own.channel, 0)
    return x + (own.error * u + own.asymmetry * fabs(u) + own.nonlinearity * (u * u))
