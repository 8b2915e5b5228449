"""Delay of an axis."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from imugap.effects.block import CHANNELS, Block, require_short
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect, parameter
from imugap.effects.residual import Residual
from imugap.log import AXES
from imugap.numerics.spectra.band_limited import weights

REACH = 5
"""Largest delay of the starts of a search, either way [samples]."""


@dataclass(frozen=True)
class TimeOffset(SystematicEffect):
    """Input u that arrives late by an offset: u(t - offset) - u(t)."""

    name: ClassVar[str] = "time_offset"
    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    common: ClassVar[tuple[str, ...]] = AXES
    offset: float = parameter("s", "delay of the input", low=-np.inf)

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Interpolate band-limited; the input is constant before the first and after the last known time."""
        self.own_axis(conditions)
        between = conditions.once(_course)
        return between(np.clip(conditions.time - self.offset, *between.x[[0, -1]]))[:, 0] - conditions.error_free

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step; it needs the input ahead unless the delay is by whole samples."""
        require_short(self.name, abs(self.offset) / interval)
        first, shares = weights(self.offset / interval)
        values = {"channel": CHANNELS[axis], "first": first, "weights": shares}
        return Block(_step, values, past=max(-first, 0), ahead=max(first + len(shares) - 1, 0))

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return minus the derivative of the delayed input."""
        self.own_axis(conditions)
        between, earlier = conditions.once(_course), conditions.time - self.offset
        held = (earlier < between.x[0]) | (earlier > between.x[-1])
        return {"offset": np.where(held, 0.0, -between(earlier, 1)[:, 0])}

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the best of the delays by whole samples, zero included, with the gain of a step from there."""
        conditions = fit.sequence.conditions
        if not conditions.knows([conditions.axis]) or fit.has(cls):
            return
        whole = [cls(float(k * conditions.interval)) for k in range(-REACH, REACH + 1)]
        gain, best = max(((one._reached(fit), one) for one in whole), key=lambda found: found[0])
        if gain > 0:
            yield Start(best, ("offset",), gain=gain)

    def _reached(self, fit: Residual) -> float:
        """Return the gain of log-likelihood at the maximum near this delay, to second order."""
        conditions = fit.sequence.conditions
        columns = np.column_stack([self.sample(conditions, None), self.slopes(conditions)["offset"]])
        moved, slope = fit.beyond(fit.whiten(columns)).T
        rest = fit.coefficients - moved
        size = slope @ slope
        step = (slope @ rest) ** 2 / size if size > 0 else 0.0
        return float(0.5 * (fit.coefficients @ fit.coefficients - rest @ rest + step))


def _course(conditions: Conditions) -> CubicHermiteSpline:
    """Return the band-limited interpolation of the input of the own axis."""
    return TimeOffset.interpolated(conditions, [conditions.axis])


def _step(own, x, now):
    late = 0.0
    for k in range(len(own.weights)):
        late = late + own.weights[k] * now.at(own.channel, own.first + k)
    return x + (late - now.at(own.channel, 0))
