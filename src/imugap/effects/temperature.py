"""Sensitivity of the bias to temperature."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.ndimage import uniform_filter1d

from imugap.effects.block import CHANNELS, Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import TEMPERATURE

LAWS = (("coefficient",), ("coefficient", "quadratic"), ("coefficient", "rate"))
"""Sets of parameters of the starts of a search."""
SMOOTH = 50
"""Share of the log over which the change of the temperature is smoothed: 1/50."""


@dataclass(frozen=True)
class Temperature(SystematicEffect):
    """Bias by the difference d of the temperature from a reference (IEEE 1554: bias temperature sensitivity).

    Bias = coefficient d + quadratic d^2 + rate dT/dt.
    """

    name: ClassVar[str] = "temperature"
    of_temperature: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    coefficient: float = parameter("{u}/degC", "change of the bias per degree", low=-np.inf)
    reference: float = parameter("degC", "temperature at which the static effect is zero", low=-273.15, default=25.0)
    quadratic: float = parameter("{u}/degC^2", "curvature of the bias over temperature", low=-np.inf, default=0.0)
    rate: float = parameter("{u}*s/degC", "bias per rate of change of the temperature", low=-np.inf, default=0.0)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the bias at every sample; dT/dt by central differences."""
        distance = self._distance(conditions)
        static = self.coefficient * distance + self.quadratic * distance**2
        if self.rate == 0:
            return static
        return static + self.rate * np.gradient(conditions.temperature, conditions.time)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        rate = {"rate": self.rate, "channel": CHANNELS[TEMPERATURE]}
        laws = {"coefficient": self.coefficient, "quadratic": self.quadratic, "reference": self.reference}
        return Block(_step, {**laws, **rate}, past=1, ahead=int(self.rate != 0))

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return d, d^2 and dT/dt."""
        distance = self._distance(conditions)
        rate = np.gradient(conditions.temperature, conditions.time)
        return {"coefficient": distance, "quadratic": distance**2, "rate": rate}

    def _distance(self, conditions: Conditions) -> np.ndarray:
        """Return the temperature less the reference."""
        if conditions.temperature is None:
            raise ValueError("temperature: expected conditions with a temperature; found none")
        return conditions.temperature - self.reference

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return the cube and, for hysteresis, the sign of the slow change of the temperature with and without it."""
        distance = conditions.temperature - np.mean(conditions.temperature)
        rate = uniform_filter1d(np.gradient(conditions.temperature), max(len(distance) // SMOOTH, 1))
        sign = np.tanh(rate / np.std(rate))
        return [np.column_stack([distance**3]), np.column_stack([sign, distance * sign])]

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the linear, the quadratic and the rate-dependent law, where the temperature is known and varies."""
        temperature = fit.sequence.conditions.temperature
        if temperature is None or np.ptp(temperature) == 0 or fit.has(cls):
            return
        start = cls(0.0, float(np.mean(temperature)))
        for free in LAWS:
            yield Start(start, free, trials=len(LAWS))


def _step(own, x, now):
    distance = now.at(own.channel, 0) - own.reference
    y = x + (own.coefficient * distance + own.quadratic * (distance * distance))
    if own.rate != 0.0:
        change = now.at(own.channel, 1) - now.at(own.channel, -1)
        y = y + own.rate * (change / (now.time(1) - now.time(-1)))
    return y
