"""Samples that are held: a sensor of a lower rate, each value of which is read several times."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Effect, Evidence, Role, Stage, Transform, parameter
from imugap.integrity.report import IMPROBABLE
from imugap.numerics.samples.change_period import change_period

MAX_REPEATS = 0.5
"""Largest share of repeats among new values, on a coarse lattice."""


@dataclass(frozen=True)
class HeldSamples(Effect):
    """Decimation by sample and hold: every so many samples the output takes a new value, and repeats it between."""

    name: ClassVar[str] = "held_samples"
    stage: ClassVar[Stage] = Stage.TRANSFER
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    every: float = parameter("1", "samples from one new value to the next", low=1.0, whole=True, default=2.0)
    first: float = parameter("1", "number of the first sample with a new value, from 0 on", whole=True, default=0.0)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Repeat the new values."""
        return self._held(sequence, 0, np.nan)[0]

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that does so to one part after the other."""
        begin, last = 0, np.nan

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal begin, last
            values, last = self._held(sequence, begin, last)
            begin += len(sequence)
            return values

        return transform

    def _held(self, sequence: np.ndarray, begin: int, last: float) -> tuple[np.ndarray, float]:
        """Return samples from number ``begin`` on behind one of value ``last``, and the last of them."""
        number = np.arange(begin, begin + len(sequence))
        new = (number == 0) | ((number - self.first) % self.every == 0)
        rows = np.maximum.accumulate(np.where(new, np.arange(1, len(sequence) + 1), 0))
        values = np.r_[last, sequence][rows]
        return values, float(values[-1]) if len(values) else last

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        ahead = int(self.first) % int(self.every)
        return Block(_step, {"every": self.every, "left": float(ahead), "last": 0.0}, _start)

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the held samples of an output, shape (n,) or (n, axes) of axes that are held together, or None.

        All samples repeat the one before but those whose number is one and the same modulo the period. Were they not
        held, each would repeat with the probability that a new value is that of the one before, on a lattice.
        """
        columns = values.reshape(len(values), -1)
        period = change_period(columns)
        if period is None:
            return None
        every, first = period
        known, repeats = np.isfinite(columns).all(axis=1), np.all(columns[1:] == columns[:-1], axis=1)
        both = known[1:] & known[:-1]
        number = np.arange(1, len(columns))
        new = number % every == first
        chance = (np.count_nonzero(new & both & repeats) + 1) / (np.count_nonzero(new & both) + 1)
        held = np.count_nonzero(~new & both)
        log_p = held * float(np.log(chance)) + 2 * float(np.log(every))
        if chance > MAX_REPEATS or log_p > np.log(IMPROBABLE):
            return None
        flawed = np.r_[False, ~new & both]
        ends = {"every": (float(every), float(every)), "first": (float(first), float(first))}
        return Evidence(cls(float(every), float(first)), ends, log_p, flawed)


def _start(own, x, now):
    own.last = x


def _step(own, x, now):
    if own.left < 1.0:
        own.last = x
        own.left = own.every
    own.left = own.left - 1.0
    return own.last
