"""What sensitivity to specific force and misalignment share: errors in proportion to the signals of other axes."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import CHANNELS, Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Start, SystematicEffect
from imugap.effects.residual import Residual
from imugap.log import triad


@dataclass(frozen=True)
class CrossAxisEffect(SystematicEffect):
    """An error in proportion to the error-free signals along x, y and z of a triad, by parameters of these names."""

    of_motion: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True

    @classmethod
    def inputs(cls, axis: str) -> tuple[str, ...]:
        """Return the axes whose signals add to the error of ``axis``; none where the effect has no place on it."""
        raise NotImplementedError

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return the sum of the signals, each times its parameter; those with a parameter of 0 need not be known."""
        own = {axis: getattr(self, axis[-1]) for axis in self.inputs(self.own_axis(conditions))}
        own = {axis: value for axis, value in own.items() if value}
        return self.error_free(conditions, list(own)) @ np.array(list(own.values()))

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        first = triad(self.inputs(axis)[0])[0]
        return Block(_step, {"channel": CHANNELS[first]} | self.parameters())

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the known signals."""
        axes = self.inputs(self.own_axis(conditions))
        known = [axis for axis in axes if conditions.knows([axis])] or axes
        return {axis[-1]: column for axis, column in zip(known, self.error_free(conditions, known).T, strict=True)}

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the parameters of the known signals that vary."""
        conditions, start = fit.sequence.conditions, cls(0.0, 0.0, 0.0)
        if conditions.axis is None or fit.has(cls):
            return
        if not any(conditions.knows([axis]) for axis in cls.inputs(conditions.axis)):
            return
        free = tuple(name for name, slope in start.slopes(conditions).items() if np.ptp(slope) > 0)
        if free:
            yield from start.proposed(fit, free)


def _step(own, x, now):
    across = own.x * now.at(own.channel, 0) + own.y * now.at(own.channel + 1, 0) + own.z * now.at(own.channel + 2, 0)
    return x + across
