"""Words that are read while they change: high bits of the sample before with the low bits of this one."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import bdtrc, betaincinv

from imugap.effects.block import Block, isnan, rint
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, Transform, parameter
from imugap.integrity.precision import spacing
from imugap.integrity.report import IMPROBABLE

BYTES = (8, 16)
"""Numbers of low bits of words that are transferred in bytes."""
FEWEST = 3
"""Fewest torn samples."""
LIKELY = 6.0
"""Standard deviations within which a repaired sample lies about its neighbours."""
PASSES = 3
"""Number of times that words are compared with neighbours, which may be torn too until they are repaired."""
MIN_SHARE = 0.8
"""Least share of the samples far from their neighbours that are torn."""
LIMITS = 0.025, 0.975
"""Probabilities of the ends of an interval."""


@dataclass(frozen=True)
class TornWords(Effect):
    """Integer words whose high bits are, with some probability, still those of the sample before.

    Samples are whole numbers of ``step`` from ``offset`` on, in two's complement. A torn sample is off by 2^bits steps
    where the high bits have changed, and right elsewhere.
    """

    name: ClassVar[str] = "torn_words"
    stage: ClassVar[Stage] = Stage.WORD
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    probability: float = parameter("1", "probability that a word is torn", high=1.0)
    step: float = parameter("{u}", "value of the lowest bit", low=TINY)
    bits: float = parameter("1", "number of low bits, which are read anew", low=1.0, high=32.0, whole=True, default=8.0)
    offset: float = parameter("{u}", "output of the word zero", low=-np.inf, default=0.0)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Round to words, and tear some."""
        return self._torn(sequence, rng, None)[0]

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that tears words of one part after the other."""
        high = None

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal high
            values, high = self._torn(sequence, rng, high)
            return values

        return transform

    def _torn(
        self, sequence: np.ndarray, rng: np.random.Generator, before: float | None
    ) -> tuple[np.ndarray, float | None]:
        """Return the torn words after one with some high bits, and the high bits of the last."""
        words = np.rint((sequence - self.offset) / self.step)
        high = np.floor(words / 2.0**self.bits)
        last = np.r_[high[:1] if before is None else before, high[:-1]]
        torn = rng.random(len(sequence)) < self.probability
        values = self.offset + self.step * (words - 2.0**self.bits * np.where(torn, high - last, 0.0))
        return values, float(high[-1]) if len(high) else before

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        base = 2.0**self.bits
        constants = {"probability": self.probability, "size": self.step, "offset": self.offset, "base": base}
        return Block(_step, constants | {"middle": (base - 1) / 2, "high": 0.0, "first": 1.0})

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the torn samples of an output, shape (n,), NaN where lost, or None.

        A sample far from its neighbours is torn if it is among them once a change of its high bits to those of the
        sample before is undone, and all such changes are at one boundary. By chance an outlier is so with the share of
        the words that are among the neighbours.
        """
        at = np.flatnonzero(np.isfinite(values))
        step, error = spacing(values[at])
        if not step or len(at) < 2 * FEWEST:
            return None
        words = np.rint(values[at] / step)
        found = [one for bits in BYTES if (one := _Tears.of(words, bits)) is not None]
        if not found:
            return None
        tears = min(found, key=lambda one: one.log_p)
        count, chances = np.count_nonzero(tears.torn), tears.chances
        low, high = betaincinv(count + np.array([0, 1]), chances - count + np.array([1, 0]), LIMITS)
        offset, bits = step * tears.boundary, float(tears.bits)
        limits = {
            "probability": (float(low), float(high)),
            "step": (step - error, step + error),
            "bits": (bits, bits),
            "offset": (offset - step, offset + step),
        }
        flawed = np.zeros(len(values), bool)
        flawed[at[tears.torn]] = True
        return Evidence(cls(count / chances, step, bits, offset), limits, tears.log_p, flawed)


@dataclass(frozen=True, eq=False)
class _Tears:
    """Torn words of an output.

    Attributes
    ----------
    log_p
        Log p-value.
    bits, boundary
        Low bits, and a word at which the high bits change.
    torn
        Which words are torn, shape (n,).
    chances
        Number of words whose high bits differ from those of the word before.
    """

    log_p: float
    bits: int
    boundary: float
    torn: np.ndarray
    chances: int

    @classmethod
    def of(cls, words: np.ndarray, bits: int) -> "_Tears | None":
        """Return the torn words among some, shape (n,), or None."""
        base, repaired = 2**bits, words
        for _ in range(PASSES):
            level = _neighbours(repaired)
            apart = words - level
            repaired = np.where(np.abs(apart) > base / 2, words - base * np.rint(apart / base), words)
        far = repaired != words
        near = LIKELY * 1.4826 * float(np.median(np.abs(apart))) + 0.5
        if near > base / 2 or np.count_nonzero(far) < FEWEST:
            return None
        before = np.r_[repaired[:1], repaired[:-1]]
        rises = np.sign(repaired - words) == np.sign(repaired - before)
        among = far & rises & (np.abs(repaired - level) <= near) & (np.abs(repaired - words) <= base)
        boundary = _boundary(before[among], repaired[among], base)
        high, last = (np.floor((one - boundary) / base) for one in (repaired, before))
        torn = among & (high - last == (repaired - words) / base)
        count, outside = np.count_nonzero(torn), np.count_nonzero(far)
        if count < max(FEWEST, MIN_SHARE * outside):
            return None
        p_value = base * float(bdtrc(count - 1, outside, min(2 * near / base, 1.0)))
        if p_value > IMPROBABLE:
            return None
        return cls(float(np.log(max(p_value, TINY))), bits, boundary, torn, max(np.count_nonzero(high != last), count))


def _boundary(before: np.ndarray, after: np.ndarray, base: int) -> float:
    """Return the word, of the smallest magnitude, that most pairs of words have between them, modulo a base."""
    low, high = np.minimum(before, after) + 1, np.maximum(before, after)
    crossed = np.zeros(base + 1)
    first, length = np.mod(low, base).astype(int), np.minimum(high - low + 1, base).astype(int)
    np.add.at(crossed, first, 1)
    stop = first + length
    np.add.at(crossed, np.minimum(stop, base), -1)
    wrapped = stop > base
    crossed[0] += np.count_nonzero(wrapped)
    np.add.at(crossed, stop[wrapped] - base, -1)
    most = np.cumsum(crossed[:base])
    best = np.flatnonzero(most == most.max())
    best = np.where(best > base / 2, best - base, best)
    return float(best[np.argmin(np.abs(best))])


def _neighbours(words: np.ndarray) -> np.ndarray:
    """Return the median of the two words before each and the two behind it, shape (n,)."""
    padded = np.pad(words, 2, mode="reflect")
    return np.median([padded[k : k + len(words)] for k in (0, 1, 3, 4)], axis=0)


def _step(own, x, now):
    y = x
    if not isnan(x):
        word = rint((x - own.offset) / own.size)
        high = rint((word - own.middle) / own.base)
        y = own.offset + own.size * word
        if own.first > 0.0:
            own.high = high
        own.first = 0.0
        if own.draw.uniform() < own.probability:
            y = own.offset + own.size * (word - own.base * (high - own.high))
        own.high = high
    return y
