"""Full scale of the output."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import bdtrc

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, parameter
from imugap.integrity.precision import grain, spacing
from imugap.integrity.report import IMPROBABLE
from imugap.numerics.samples.truncated_exponential import log_slope

TAIL = 100
"""Samples below the extreme value from which its expected count is computed."""
LEVELS = 4
"""Smallest range of these samples [steps of the lattice]."""
FLAT = 3
"""Fewest samples at the extreme value without a lattice: a single time may be one repeated value."""
NEXT = 5
"""Samples below the extreme value from which the distance of values there is computed."""
CLEAR = 1.5
"""Ratio to the largest of the other errors above which a single sample is clipped."""
LONE = 1e-4
"""Significance level for a single sample, not reached by a log of less than 5000 samples."""
MANY = 10
"""Fewest samples at the extreme value of a lattice, as fewer may be a heavy tail."""


@dataclass(frozen=True)
class Saturation(Effect):
    """Output clipped at its full scale (IEEE 528: input limits)."""

    name: ClassVar[str] = "saturation"
    stage: ClassVar[Stage] = Stage.RANGE
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    memoryless: ClassVar[bool] = True
    limit: float = parameter("{u}", "full scale, on both sides", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Clip to +-limit."""
        return np.clip(sequence, -self.limit, self.limit)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"limit": self.limit})

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the full scale at which the output ``values``, shape (n,), NaN where lost, is clipped, or None.

        The tail next to the extreme value is taken as exponential; every log-concave density decreases faster. One
        side suffices; the other is clipped too where it reaches as far. Where the motion is known, one sample
        suffices that is below the true input.
        """
        known = np.isfinite(values)
        if np.count_nonzero(known) < TAIL:
            return None
        step, _ = spacing(values[known])
        fine = max(step, float(grain(values[known]).max()))
        sides = {sign: _log_p(sign * values[known], fine, bool(step)) for sign in (1, -1)}
        tops = {sign: float(np.max(sign * values[known])) for sign in sides}
        clipped = [sign for sign, log_p in sides.items() if log_p < np.log(IMPROBABLE)] or [max(tops, key=tops.get)]
        limit = max(tops[sign] for sign in clipped)
        alike = _log_p(np.abs(values[known]), fine, bool(step))
        log_p = min(*sides.values(), alike)
        if log_p >= np.log(IMPROBABLE):
            log_p = _log_shortfall(values[known], np.broadcast_to(conditions.error_free, values.shape)[known])
            if log_p >= np.log(LONE):
                return None
        ends = [sign for sign in sides if sign in clipped or abs(tops[sign] - limit) <= fine]
        flawed = np.any([known & (sign * values == tops[sign]) for sign in ends], axis=0)
        intervals = {"limit": (limit - fine / 2, limit + fine / 2)}
        reached = np.abs(values[flawed])
        bounds = np.where(values > 0, values, -np.inf), np.where(values > 0, np.inf, values)
        return Evidence(cls(limit), intervals, log_p, flawed, (float(reached.min()), float(reached.max())), bounds)


def _log_p(values: np.ndarray, step: float, lattice: bool) -> float:
    """Return the log p-value of the number of samples at the highest of ``values``, shape (n,), without clipping.

    Without a lattice values differ; each equals the highest of n with a probability of at most 1/n. A
    stuck output is at the highest value with probability 1/n; at two separate times the values are equal to the last
    digit with a probability of one over the number of digits in between.
    """
    top = values.max()
    at = values == top
    stays = np.count_nonzero(np.diff(at.astype(int), prepend=0) == 1)
    repeats = np.count_nonzero(values[1:] == values[:-1]) - (np.count_nonzero(at) - stays)
    if top <= 0 or at.all() or (stays == 1 and (np.count_nonzero(at) < FLAT or repeats)):
        return 0.0
    once = stays == 1 or repeats
    if np.count_nonzero(at) < (MANY if lattice else FLAT if once else 2):
        return 0.0
    below = np.sort(top - values[~at])
    if not lattice and not repeats:
        nearest = min(NEXT, len(below))
        apart = below[nearest - 1] / nearest
        alike = 1 / len(values) if stays == 1 else min(1 / len(values), step / apart)
        return float((np.count_nonzero(at) - 1) * np.log(alike))
    entries = top - values[:-1][at[1:] & ~at[:-1]]
    if np.median(entries) < 1.5 * step:
        return 0.0
    reach = max(below[min(TAIL, len(below)) - 1], LEVELS * step)
    inside = below[below <= reach * (1 + 1e-9)]
    levels = max(int(np.rint(reach / step)), 1)
    slope, error = log_slope((inside - step / 2) / reach)
    slope = max(slope - 2 * error, 0.0) / reach
    share = 1 / (1 + _geometric(slope * step, levels))
    near = values >= top - reach * (1 + 1e-9)
    visits = np.count_nonzero(np.diff(near.astype(int), prepend=0) == 1)
    size = visits / np.count_nonzero(near)
    least, most = int(np.count_nonzero(at) * size), int(np.ceil((len(inside) + np.count_nonzero(at)) * size))
    return float(np.log(max(bdtrc(least - 1, most, share), TINY)))


def _log_shortfall(values: np.ndarray, ideal: np.ndarray) -> float:
    """Return the log p-value of the coincidence that the only samples far from their error-free input are the largest.

    Both have shape (n,). Zero unless the largest value is below the largest input, while all other samples agree with
    the input to within the smooth errors of a sensor as a function of its input. Stuck samples deviate at other times
    too.
    """
    size = np.abs(ideal)
    top = int(np.argmax(size))
    at = np.abs(values) == np.abs(values).max()
    if size[top] == 0 or not at[top]:
        return 0.0
    share = ideal / size[top]
    columns = np.column_stack([np.ones_like(share), share, np.abs(share), share**2, share**3])
    error = values - ideal
    rest = error - columns @ np.linalg.lstsq(columns[~at], error[~at], rcond=None)[0]
    short = -np.sign(ideal[at]) * rest[at]
    others = np.abs(rest[~at]).max()
    if short.max() < CLEAR * others or short.min() < -others:
        return 0.0
    return float(-np.log(2 * len(values)))


def _geometric(rate: float, count: int) -> float:
    """Return the sum of exp(rate k) over k = 1..count."""
    return float(count) if rate < 1e-9 else float(np.exp(rate) * np.expm1(rate * count) / np.expm1(rate))


def _step(own, x, now):
    return own.limit if x > own.limit else (-own.limit if x < -own.limit else x)
