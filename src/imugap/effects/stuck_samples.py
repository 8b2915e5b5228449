"""Repeated values."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import bdtrc, pdtrc

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, Transform, parameter
from imugap.integrity.precision import grain, spacing
from imugap.integrity.report import IMPROBABLE
from imugap.numerics.samples.change_period import change_period
from imugap.numerics.samples.random_runs import (
    RunEstimate,
    estimate_from_repeats,
    estimate_from_runs,
    runs_in_parts,
    simulate_runs,
)

STEEP = 1.27
"""Log ratio of differences of one and of two steps above which the lattice is too coarse for the noise."""
SHAPE = 0.05
"""Relative uncertainty of the probability of a random repeat from the non-normality of noise."""
FEW = 30
"""Number of steps between neighbours of a lattice below which the smallest steps of any size are used."""
SPARSE = 0.3
"""Relative uncertainty of the probability of a random repeat then."""
PART, FEWEST = 250, 8
"""Samples of a part of the log, and fewest steps between neighbours of a lattice to estimate its noise."""
FAR = 4.0
"""Standard deviations of the number of random repeats beyond which a part has other noise."""
RARE = 0.01
"""Expected share of random repeats below which every repeat is a fault."""
SAFE = 2.0
"""Factor of safety on the expected simultaneous repeats of several axes."""
TURNS = 3.0
"""Mean number of repeats of a smooth signal at its extremes."""
ROUNDS = 20
"""Iterations of the shares of the levels."""
SLOW, FAST = 0.4, 4.0
"""Change of the motion per sample, in standard deviations of the noise of a difference: root mean square below which
the motion is negligible, and value above which noise does not cancel it."""


@dataclass(frozen=True)
class StuckSamples(Effect):
    """Output that repeats its last value for a run of samples.

    The runs are those of :func:`imugap.numerics.samples.random_runs.simulate_runs`.
    """

    name: ClassVar[str] = "stuck_samples"
    stage: ClassVar[Stage] = Stage.TRANSFER
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    probability: float = parameter("1", "probability that a stretch begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of repeats of a value", low=1.0)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Replace the samples of a run by the last value before it."""
        stuck = simulate_runs(len(sequence), self.probability, self.length, rng)
        return sequence[np.maximum.accumulate(np.where(stuck, 0, np.arange(len(sequence))))]

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that does so to one part after the other."""
        following, last = runs_in_parts(run.count, self.probability, self.length, rng), np.nan

        def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
            nonlocal last
            rows = np.where(following(len(sequence)), 0, np.arange(1, len(sequence) + 1))
            values = np.r_[last, sequence][np.maximum.accumulate(rows)]
            last = values[-1]
            return values

        return transform

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        runs = {"begin": self.probability, "end": 1 / self.length, "inside": 0.0}
        return Block(_step, {**runs, "last": 0.0})

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the runs of repeats in the output ``values``, NaN where lost, or None.

        ``values`` has shape (n,), or (n, axes) for repeats of all axes at once. The probability of a random repeat on a
        lattice follows from the numbers of one-step and two-step differences, since the logarithm of a normal density
        is a parabola. Parts of the log with another noise level are excluded. An axis with too coarse a lattice is
        tested for repeats where the others are stuck. In fast motion zero differences are compared with one-step
        differences. Repeats of one axis that prefer a value, and those of a period, are of another cause.
        """
        columns = values.reshape(len(values), -1)
        known = np.flatnonzero(np.isfinite(columns).all(axis=1))
        if not _repeats(columns[known]).any() or change_period(columns) is not None:
            return None
        known = known[np.all([_alike(column) for column in columns[known].T], axis=0)]
        told = [_repeat_probability(column[known]) for column in columns.T]
        telling = np.array([one is not None for one in told])
        if not telling.any():
            return None
        ideal, probabilities = np.broadcast_to(conditions.error_free, len(values))[known], list(filter(None, told))
        found = _estimated(columns[np.ix_(known, telling)], ideal, probabilities)
        if found is None or found[0].log_p > np.log(IMPROBABLE) or not found[1].any():
            return None
        estimate, stuck = found
        if not all(_along(column[known], stuck) for column in columns.T[~telling]):
            return None
        if columns.shape[1] == 1 and _at_one_level(columns[known, 0], stuck):
            return None
        flawed = np.zeros(len(values), bool)
        flawed[known[stuck]] = True
        probability, length = estimate.probability, estimate.length
        intervals = {"probability": probability[1:], "length": (max(length[1], 1.0), length[2])}
        return Evidence(cls(probability[0], max(length[0], 1.0)), intervals, estimate.log_p, flawed)


def _estimated(
    columns: np.ndarray, ideal: np.ndarray, probabilities: list[tuple[float, float]]
) -> tuple[RunEstimate, np.ndarray] | None:
    """Return the estimate of the runs in ``columns``, shape (n, axes), and the mask of their rows, shape (n,)."""
    repeats = _repeats(columns)
    first = np.flatnonzero(np.r_[True, ~repeats])
    runs = np.diff(np.r_[first, len(columns)]) - 1
    probability, spread = (
        float(np.prod([c for c, _ in probabilities])),
        float(np.hypot.reduce([s for _, s in probabilities])),
    )
    begun = np.count_nonzero(runs)
    if not begun:
        return None
    steps = np.column_stack([_steps(column) for column in columns.T])
    expected = max(max(probability, 1e-12) * len(columns), _at_once(steps))
    if expected < RARE * begun:
        estimate = estimate_from_runs(runs[runs > 0], max(len(first) - 1, begun))
        log_p = float(np.log(max(pdtrc(begun - 1, expected), TINY)))
        return replace(estimate, log_p=log_p), _within(runs > 0, runs, first)
    fast = _fast(columns[:, 0], ideal)
    if fast is None or (len(probabilities) > 1 and pdtrc(begun - 1, SAFE * expected) < IMPROBABLE):
        lengths = np.unique(runs, return_counts=True)
        estimate = estimate_from_repeats(*lengths, expected / len(columns), spread, np.log(IMPROBABLE))
        if estimate is None or (len(probabilities) == 1 and estimate.length[1] < TURNS and _smooth(steps[:, 0])):
            return None
        return estimate, _within(runs >= estimate.least, runs, first)
    open_to = fast[first[:-1]]
    held = open_to & (runs[:-1] > 0)
    if not held.any():
        return None
    near = open_to & np.all(np.abs(steps[first[:-1]]) < 1.5, axis=1)
    log_p = np.log(max(bdtrc(held.sum() - 1, near.sum(), 1 / 3 ** len(probabilities)), TINY))
    through = np.logical_or.reduceat(np.r_[repeats & fast, False], first)
    return replace(estimate_from_runs(runs[:-1][held], int(open_to.sum())), log_p=float(log_p)), _within(
        through, runs, first
    )


def _smooth(steps: np.ndarray) -> bool:
    """Return whether neighbouring ``steps``, shape (n,), are positively correlated."""
    return bool(steps[1:] @ steps[:-1] > 0)


def _at_once(steps: np.ndarray) -> float:
    """Return the expected number of simultaneous random repeats from ``steps``, shape (n, axes); 0 for one axis.

    Axes at rest at the same times repeat together more often than independent ones: each is evaluated where the others
    change by at most one step, and the result applies to rows with a change.
    """
    if steps.shape[1] == 1:
        return 0.0
    near = np.abs(steps) < 1.5
    staying = 1.0
    for axis in range(steps.shape[1]):
        one, two = _counts(steps[np.delete(near, axis, axis=1).all(axis=1), axis])
        expected = _expected(one, two) if min(one, two) > 0 else one / 2
        staying *= expected / max(expected + one, 1.0)
    return float(np.count_nonzero(near.all(axis=1) & (steps != 0).any(axis=1)) * staying / (1 - staying))


def _within(held: np.ndarray, runs: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return the mask of the rows that repeat the previous one in the runs ``held``, shape (runs,)."""
    rows = np.repeat(held, runs + 1)
    rows[first] = False
    return rows


def _fast(values: np.ndarray, ideal: np.ndarray) -> np.ndarray | None:
    """Return the mask of samples after the first, shape (n - 1,), to which the true signal changes more than the noise.

    None where the motion is slow relative to the noise, as at rest: it does not change the probability of a repeat.
    """
    moved = np.diff(ideal)
    noise = np.median(np.abs(np.diff(values) - moved)) / 0.6745
    return None if np.sqrt(np.mean(moved**2)) <= SLOW * noise else np.abs(moved) > FAST * noise


def _repeats(columns: np.ndarray) -> np.ndarray:
    """Return the mask of the rows after the first, shape (n - 1,), that equal the previous one."""
    return np.all(columns[1:] == columns[:-1], axis=1)


def _repeat_probability(values: np.ndarray) -> tuple[float, float] | None:
    """Return the probability of a random repeat and the uncertainty of its logarithm; None for too coarse a lattice."""
    steps = _steps(values)
    one, two = _counts(steps)
    apart = np.abs(steps[steps != 0])
    if one < FEW:
        near = np.partition(apart, FEW)[FEW] if len(apart) > FEW else np.inf
        return FEW / 2 / near / len(steps), SPARSE
    if two == 0 or np.log(one / two) > STEEP:
        return None
    expected = _expected(one, two)
    return max(expected / (len(apart) + expected), _coincidence(values)), float(_uncertainty(one, two))


def _along(values: np.ndarray, stuck: np.ndarray) -> bool:
    """Return whether values repeat significantly more often in stuck rows, shape (n,), than in all rows."""
    same = np.r_[False, values[1:] == values[:-1]]
    return bdtrc(np.count_nonzero(same & stuck) - 1, np.count_nonzero(stuck), same.mean()) < IMPROBABLE


def _at_one_level(values: np.ndarray, stuck: np.ndarray) -> bool:
    """Return whether repeats, mask of shape (n,), prefer one value, as at a limit or in a dead zone."""
    begins = values[:-1][stuck[1:] & ~stuck[:-1]]
    level, counts = np.unique(begins, return_counts=True)
    share = np.mean(values[~stuck] == level[np.argmax(counts)])
    return bool(bdtrc(counts.max() - 1, len(begins), share) < IMPROBABLE)


def _coincidence(values: np.ndarray) -> float:
    """Return the probability that two independent values are equal; exceeds that of the steps where codes are missing.

    Among samples that differ from the previous one, a level of share p has a share proportional to ``p (1 - p)``.
    """
    _, counts = np.unique(values[np.r_[True, values[1:] != values[:-1]]], return_counts=True)
    shares = levels = counts / counts.sum()
    for _ in range(ROUNDS):
        levels = shares * (1 - levels @ levels) / (1 - levels)
    return float(levels @ levels - 1 / counts.sum())


def _alike(values: np.ndarray) -> np.ndarray:
    """Return the mask of the samples, shape (n,), in parts of the log with the usual rate of repeats."""
    parts = np.array_split(_steps(values), max(len(values) // PART, 1))
    counts = np.array([_counts(part) for part in parts])
    told = counts[:, 0] >= FEWEST
    if np.count_nonzero(told) < 2:
        return np.ones(len(values), bool)
    one, two = np.maximum(counts[told], 0.5).T
    moving = np.array([np.count_nonzero(part) for part in parts])[told]
    ratio = np.log(_expected(one, two) / moving)
    error = _uncertainty(one, two)
    far = np.zeros(len(parts), bool)
    far[told] = np.abs(ratio - np.median(ratio)) > FAR * error
    return np.r_[True, ~np.repeat(far, [len(part) for part in parts])]


def _steps(values: np.ndarray) -> np.ndarray:
    """Return the differences of neighbours in steps of the lattice, shape (n - 1,)."""
    step, _ = spacing(values)
    fine = np.maximum(grain(values), step)
    return np.diff(values) / np.maximum(fine[1:], fine[:-1])


def _counts(steps: np.ndarray) -> tuple[int, int]:
    """Return the numbers of one-step and two-step differences."""
    return tuple(np.count_nonzero(np.abs(np.abs(steps) - k) < 0.5) for k in (1, 2))


def _uncertainty(one: np.ndarray | int, two: np.ndarray | int) -> np.ndarray | float:
    """Return the uncertainty of the logarithm of :func:`_expected`."""
    return np.sqrt(16 / 9 / one + 1 / 9 / two + SHAPE**2)


def _expected(one: np.ndarray | int, two: np.ndarray | int) -> np.ndarray | float:
    """Return the expected number of random repeats from the numbers of one-step and two-step differences."""
    return one / 2 * np.maximum(one / two, 1.0) ** (1 / 3)


def _step(own, x, now):
    y = own.last if own.inside > 0.0 else x
    own.last = y
    if own.draw.uniform() < (own.end if own.inside > 0.0 else own.begin):
        own.inside = 1.0 - own.inside
    return y
