"""Repeated values."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.special import bdtrc, pdtrc

from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Evidence, Role, Stage, parameter
from imugap.integrity.precision import grain, spacing
from imugap.integrity.report import IMPROBABLE
from imugap.numerics.random_runs import RunEstimate, estimate_from_repeats, estimate_from_runs, simulate_runs

STEEP = 1.27
"""Log ratio of differences of one and of two steps above which the lattice is too coarse for the noise."""
SHAPE = 0.05
"""Relative uncertainty of the chance of a repeat because noise is not normal."""
FEW = 30
"""Steps between neighbours of a lattice below which the nearest neighbours, whatever their step, tell more."""
SPARSE = 0.3
"""Relative uncertainty of the chance of a repeat then."""
PART, FEWEST = 250, 8
"""Samples of a part of the log, and steps between neighbours of a lattice that it needs to tell of its noise."""
FAR = 4.0
"""Standard deviations by which repeats by chance differ in a part of other noise."""
RARE = 0.01
"""Share of repeats by chance below which each is taken for a flaw."""
SAFE = 2.0
"""Factor that the repeats of several axes at once may be more than is expected by chance."""
TURNS = 3.0
"""Mean number of repeats that a smooth signal, whose steps go on as they were, may make wherever it turns."""
ROUNDS = 20
"""Of the shares of levels, which come nearer by the share itself each time."""
SLOW, FAST = 0.4, 4.0
"""Standard deviations of the noise of a difference by which a motion that does not matter moves on in a sample (root
mean square), and one that noise does not undo."""


@dataclass(frozen=True)
class StuckSamples(Effect):
    """Output that repeats its last value for a run of samples (:func:`imugap.numerics.random_runs.simulate_runs`)."""

    name: ClassVar[str] = "stuck_samples"
    stage: ClassVar[Stage] = Stage.TRANSFER
    role: ClassVar[Role] = Role.OUTPUT
    replaced: ClassVar[bool] = True
    probability: float = parameter("1", "probability that a stretch begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of repeats of a value", low=1.0)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Put the last value that was not in a stretch in place of those that are."""
        stuck = simulate_runs(len(sequence), self.probability, self.length, rng)
        return sequence[np.maximum.accumulate(np.where(stuck, 0, np.arange(len(sequence))))]

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the stretches of repeats in the output ``values``, NaN where lost, or None.

        ``values`` has shape (n,), or (n, axes) for repeats of all axes at once. How often noise repeats itself on a
        lattice follows from how often it goes one step and two: the logarithm of a normal density is a parabola. Parts
        of the log in which the noise is louder or softer than in most of it are left out. An axis whose lattice is too
        coarse for that is asked whether it repeats itself where the others are stuck. In motion a step of nothing is
        held against steps of one, up or down, where the motion is fast.
        """
        columns = values.reshape(len(values), -1)
        known = np.flatnonzero(np.isfinite(columns).all(axis=1))
        if not _repeats(columns[known]).any():
            return None
        known = known[np.all([_alike(column) for column in columns[known].T], axis=0)]
        told = [_chance(column[known]) for column in columns.T]
        telling = np.array([one is not None for one in told])
        if not telling.any():
            return None
        ideal, chances = np.broadcast_to(conditions.error_free, len(values))[known], list(filter(None, told))
        judged = _judged(columns[np.ix_(known, telling)], ideal, chances)
        if judged is None or judged[0].log_p > np.log(IMPROBABLE) or not judged[1].any():
            return None
        estimate, stuck = judged
        if not all(_along(column[known], stuck) for column in columns.T[~telling]):
            return None
        flawed = np.zeros(len(values), bool)
        flawed[known[stuck]] = True
        probability, length = estimate.probability, estimate.length
        intervals = {"probability": probability[1:], "length": (max(length[1], 1.0), length[2])}
        return Evidence(cls(probability[0], max(length[0], 1.0)), intervals, estimate.log_p, flawed)


def _judged(
    columns: np.ndarray, ideal: np.ndarray, chances: list[tuple[float, float]]
) -> tuple[RunEstimate, np.ndarray] | None:
    """Return the stretches among the rows of ``columns``, shape (n, axes), and which rows are in one, shape (n,)."""
    repeats = _repeats(columns)
    first = np.flatnonzero(np.r_[True, ~repeats])
    runs = np.diff(np.r_[first, len(columns)]) - 1
    chance, spread = float(np.prod([c for c, _ in chances])), float(np.hypot.reduce([s for _, s in chances]))
    begun = np.count_nonzero(runs)
    if not begun:
        return None
    steps = np.column_stack([_steps(column) for column in columns.T])
    expected = max(max(chance, 1e-12) * len(columns), _at_once(steps))
    if expected < RARE * begun:
        estimate = estimate_from_runs(runs[runs > 0], max(len(first) - 1, begun))
        log_p = float(np.log(max(pdtrc(begun - 1, expected), TINY)))
        return replace(estimate, log_p=log_p), _within(runs > 0, runs, first)
    fast = _fast(columns[:, 0], ideal)
    if fast is None or (len(chances) > 1 and pdtrc(begun - 1, SAFE * expected) < IMPROBABLE):
        lengths = np.unique(runs, return_counts=True)
        estimate = estimate_from_repeats(*lengths, expected / len(columns), spread, np.log(IMPROBABLE))
        if estimate is None or (len(chances) == 1 and estimate.length[1] < TURNS and _smooth(steps[:, 0])):
            return None
        return estimate, _within(runs >= estimate.least, runs, first)
    open_to = fast[first[:-1]]
    held = open_to & (runs[:-1] > 0)
    if not held.any():
        return None
    near = open_to & np.all(np.abs(steps[first[:-1]]) < 1.5, axis=1)
    log_p = np.log(max(bdtrc(held.sum() - 1, near.sum(), 1 / 3 ** len(chances)), TINY))
    through = np.logical_or.reduceat(np.r_[repeats & fast, False], first)
    return replace(estimate_from_runs(runs[:-1][held], int(open_to.sum())), log_p=float(log_p)), _within(
        through, runs, first
    )


def _smooth(steps: np.ndarray) -> bool:
    """Return whether each of the ``steps``, shape (n,), is rather like the one before it than the opposite."""
    return bool(steps[1:] @ steps[:-1] > 0)


def _at_once(steps: np.ndarray) -> float:
    """Return how many repeats noise makes of several axes at once, by their ``steps``, shape (n, axes); 0 of one axis.

    Axes that rest at the same times do so more often than each by itself tells: each is looked at where the others
    move by a step at most, and all where they do not stay.
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
    """Return which rows repeat the one before in the runs that are ``held``, shape (runs,)."""
    rows = np.repeat(held, runs + 1)
    rows[first] = False
    return rows


def _fast(values: np.ndarray, ideal: np.ndarray) -> np.ndarray | None:
    """Return to which samples after the first, shape (n - 1,), the error-free signal moves farther than noise goes.

    None where the motion is slow against the noise, as for a device at rest: it does not change how often noise repeats
    itself. Where it is slow for a while only, noise repeats itself time and again then.
    """
    moved = np.diff(ideal)
    noise = np.median(np.abs(np.diff(values) - moved)) / 0.6745
    return None if np.sqrt(np.mean(moved**2)) <= SLOW * noise else np.abs(moved) > FAST * noise


def _repeats(columns: np.ndarray) -> np.ndarray:
    """Return which rows after the first, shape (n - 1,), are the same as the one before."""
    return np.all(columns[1:] == columns[:-1], axis=1)


def _chance(values: np.ndarray) -> tuple[float, float] | None:
    """Return how often noise repeats a value, and the uncertainty of its logarithm; None on too coarse a lattice."""
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
    """Return whether values repeat themselves in stuck rows, shape (n,), more often than in all of them."""
    same = np.r_[False, values[1:] == values[:-1]]
    return bdtrc(np.count_nonzero(same & stuck) - 1, np.count_nonzero(stuck), same.mean()) < IMPROBABLE


def _coincidence(values: np.ndarray) -> float:
    """Return how often two draws of the values are the same: where codes are missing more than their steps tell.

    Of samples that differ from the one before a level of share p has the share ``p (1 - p)``, but for a factor.
    """
    _, counts = np.unique(values[np.r_[True, values[1:] != values[:-1]]], return_counts=True)
    shares = levels = counts / counts.sum()
    for _ in range(ROUNDS):
        levels = shares * (1 - levels @ levels) / (1 - levels)
    return float(levels @ levels - 1 / counts.sum())


def _alike(values: np.ndarray) -> np.ndarray:
    """Return which samples, shape (n,), are in parts of the log in which noise repeats itself as in most of it."""
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
    """Return how many steps are of one and of two."""
    return tuple(np.count_nonzero(np.abs(np.abs(steps) - k) < 0.5) for k in (1, 2))


def _uncertainty(one: np.ndarray | int, two: np.ndarray | int) -> np.ndarray | float:
    """Return the uncertainty of the logarithm of :func:`_expected`."""
    return np.sqrt(16 / 9 / one + 1 / 9 / two + SHAPE**2)


def _expected(one: np.ndarray | int, two: np.ndarray | int) -> np.ndarray | float:
    """Return how many repeats noise makes where so many steps are of one and of two."""
    return one / 2 * np.maximum(one / two, 1.0) ** (1 / 3)
