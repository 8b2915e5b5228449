"""Quasi-likelihood of wavelet variances: estimates and deviances when their covariance depends on the model.

The quasi-score J' W (nuhat - nu), with the weights W = W(nu) of the same model (McCullagh 1983, Annals of Statistics
11, 59-67), has expectation zero at the true parameters; the gradient of a distance with such weights has not.
Weights relative to the implied variances, W = P_ij/(nu_i nu_j), are those of a scale family: for a diagonal P the
quasi-likelihood is the likelihood of chi-square variances.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from imugap.estimation.gmwm.implied import Family
from imugap.estimation.gmwm.start import Point
from imugap.numerics.fitting.profile_likelihood import end

ITERATIONS = 60
LONGEST_STEP = 1.0
"""Largest change of the logarithm of a correlation time in one step."""
COARSE = 1e-4
"""Accuracy of the points of a profile."""
WIDE = 1.0
"""Half width of an interval, in logarithms, above which zero is tested first."""
LONGEST_FIRST = 2.0
"""Largest first trial distance."""
REACH = 14.0
"""Largest distance, in logarithms of squares, at which a limit of an interval is searched."""
SHORTEST = 1e-6
"""Smallest fraction of a step."""


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of the deviations.

    Attributes
    ----------
    root
        Whitening matrix of the deviations, shape (levels, levels).
    relative
        Whether it whitens the deviations divided by the implied wavelet variances.
    """

    root: np.ndarray
    relative: bool

    def white(self, implied: np.ndarray) -> np.ndarray:
        """Return the whitening matrix of deviations from ``implied``, shape (levels,)."""
        return self.root / implied if self.relative else self.root

    def distance(self, observed: np.ndarray, implied: np.ndarray) -> float:
        """Return the weighted sum of squared deviations."""
        return float(np.sum((self.white(implied) @ (observed - implied)) ** 2))

    def score(self, observed: np.ndarray, implied: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return W (nuhat - nu), shape (levels,), and minus its derivative in nu, shape (levels, levels)."""
        white = self.white(implied)
        pull, weights = white.T @ (white @ (observed - implied)), white.T @ white
        if self.relative:
            weights = weights * (observed / implied) + np.diag(pull / implied)
        return pull, weights

    def deviance(self, observed: np.ndarray, best: np.ndarray, implied: np.ndarray) -> float:
        """Return the quasi-deviance of ``implied`` relative to ``best``.

        -2 int (nuhat - mu)' W(mu) dmu from the latter to the former, along a straight line in logarithms.
        """
        if not self.relative:
            return self.distance(observed, implied) - self.distance(observed, best)
        way = np.log(implied / best)
        safe = np.where(np.abs(way) < 1e-8, 1e-8, way)
        excess = observed / best * -np.expm1(-safe) / safe - 1  # mean of nuhat/mu - 1 along the line
        return float(-2 * (self.root @ way) @ (self.root @ excess))


class ConstraintKind(Enum):
    """Kind of quantity that is kept fixed while the others are fitted."""

    NONE = auto()
    SQUARE = auto()
    """A squared density or std."""
    DRIVING = auto()
    """The driving PSD 2 std^2/T of a Gauss-Markov process."""
    TIME = auto()
    """A correlation time."""


@dataclass(frozen=True)
class Constraint:
    """Quantity that is kept fixed while the others are fitted.

    Attributes
    ----------
    what, value
        Kind of quantity, and its fixed value; a correlation time keeps the value of the point.
    column, markov
        Index of the process among all, and among the Gauss-Markov ones if it is one.
    """

    kind: ConstraintKind = ConstraintKind.NONE
    column: int = 0
    markov: int | None = None
    value: float = 0.0

    def of(self, point: Point) -> float:
        """Return the value of the quantity at ``point``."""
        if self.kind is ConstraintKind.TIME:
            return float(np.exp(point.times[self.markov]))
        return float(point.squares[self.column]) / self._squares(point.times)

    def square(self, times: np.ndarray) -> float:
        """Return the squared density that follows from the value at these log correlation times."""
        return self.value * self._squares(times)

    def applied(self, squares: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return squared densities at log correlation times, that which follows from the value in its place."""
        if self.kind not in (ConstraintKind.SQUARE, ConstraintKind.DRIVING):
            return squares
        return np.where(np.arange(len(squares)) == self.column, self.square(times), squares)

    def _squares(self, times: np.ndarray) -> float:
        return 0.5 * float(np.exp(times[self.markov])) if self.kind is ConstraintKind.DRIVING else 1.0


FREE = Constraint()


@dataclass(frozen=True, eq=False)
class QuasiScoreSolver:
    """Newton's method for the root of the quasi-score of a family.

    Attributes
    ----------
    family, observed, weights
        Family, observed wavelet variances, shape (levels,), and weights of the deviations.
    """

    family: Family
    observed: np.ndarray
    weights: Weights

    def solve(self, start: Point, constraint: Constraint = FREE, accuracy: float = 1e-9) -> tuple[list[Point], bool]:
        """Return the points of Newton steps from ``start``, and whether the last is shorter than ``accuracy``.

        The length is the squared change of the implied wavelet variances in standard deviations. A squared density that
        would become negative is kept at zero, and released once its score is positive.
        """
        path = [self.at(start.times, start.squares, constraint)]
        step, length = self._newton(path[-1], constraint)
        for _ in range(ITERATIONS):
            if length <= accuracy:
                return path, True
            point, step, length = self._advance(path[-1], step, length, constraint)
            path.append(point)
        return path, False

    def _advance(
        self, point: Point, step: np.ndarray, length: float, constraint: Constraint
    ) -> tuple[Point, np.ndarray, float]:
        """Return the next point with its Newton step: the first that is better or has a shorter one, going back."""
        squares, times = np.split(step, [len(point.squares)])
        share = LONGEST_STEP / max(np.abs(times).max(initial=0.0), LONGEST_STEP)
        while True:
            moved = constraint.applied(point.squares + share * squares, point.times)
            if not (moved > 0).any():  # no process is left
                share /= 2
                continue
            trial = self.at(point.times + share * times, point.squares + share * squares, constraint)
            following, remaining = self._newton(trial, constraint)
            better = self.weights.deviance(self.observed, point.implied, trial.implied) <= 0
            inside = (point.squares + share * squares >= 0).all()
            if better or (inside and remaining < length) or share < SHORTEST:
                return trial, following, remaining
            share /= 2

    def at(self, times: np.ndarray, squares: np.ndarray, constraint: Constraint = FREE) -> Point:
        """Return the point with these parameters, within the limits and subject to the constraint."""
        times = np.clip(times, *self.family.limits)
        squares = constraint.applied(np.maximum(squares, 0.0), times)
        columns = np.hstack([self.family.densities, self.family.markov(times)])
        return Point(times, columns, squares, self.weights.distance(self.observed, columns @ squares))

    def each_alone(self, times: np.ndarray) -> np.ndarray:
        """Return the squared density or std with which each process alone lies beneath the observed variances."""
        columns = np.hstack([self.family.densities, self.family.markov(times)])
        return np.min(self.observed[:, None] / columns, axis=0)

    def _newton(self, point: Point, constraint: Constraint) -> tuple[np.ndarray, float]:
        """Return Newton's step of the squared densities, then of the log times, and its squared length."""
        jacobian, bend = self._derivatives(point, constraint)
        pull, stiffness = self.weights.score(self.observed, point.implied)
        score = pull @ jacobian
        free = np.flatnonzero(self._free(point, constraint, score))
        white = self.weights.white(point.implied) @ jacobian[:, free]
        scale = np.maximum(np.sqrt(np.einsum("ij,ij->j", white, white)), 1e-300)
        slope = (jacobian.T @ stiffness @ jacobian - np.einsum("l,lij->ij", pull, bend))[np.ix_(free, free)]
        step = np.zeros(len(score))
        for matrix in (slope, white.T @ white):  # a scoring step where Newton's step is not an ascent
            step[free] = np.linalg.lstsq(matrix / np.outer(scale, scale), score[free] / scale, rcond=1e-10)[0] / scale
            if score @ step > 0:
                break
        return step, float(np.sum((white @ step[free]) ** 2))

    def _derivatives(self, point: Point, constraint: Constraint) -> tuple[np.ndarray, np.ndarray]:
        """Return first and second derivatives of the wavelet variances in the squared densities and the log times."""
        size, markov = len(point.squares), len(point.times)
        _, slopes, curvatures = self.family.slopes(point.times)
        squares = point.squares[size - markov :]
        once, twice = slopes * squares, curvatures * squares
        if constraint.kind is ConstraintKind.DRIVING:  # the square grows with the time
            i, part = constraint.markov, point.columns[:, constraint.column] * point.squares[constraint.column]
            once[:, i], twice[:, i] = once[:, i] + part, twice[:, i] + 2 * once[:, i] + part
        bend = np.zeros((len(slopes), size + markov, size + markov))
        by_square, by_time = np.arange(size - markov, size), np.arange(size, size + markov)
        bend[:, by_time, by_time] = twice
        bend[:, by_square, by_time] = bend[:, by_time, by_square] = slopes
        return np.hstack([point.columns, once]), bend

    def _free(self, point: Point, constraint: Constraint, score: np.ndarray) -> np.ndarray:
        """Return which parameters are free: neither fixed, nor at a limit towards which the score points."""
        size, (low, high) = len(point.squares), self.family.limits
        by_square, by_time = score[:size], score[size:]
        squares = (point.squares > 0) | (by_square > 0)
        times = point.squares[size - len(by_time) :] > 0
        times &= ((point.times > low) | (by_time > 0)) & ((point.times < high) | (by_time < 0))
        if constraint.kind is ConstraintKind.TIME:
            times[constraint.markov] = False
        elif constraint.kind is not ConstraintKind.NONE:
            squares[constraint.column] = False
        return np.r_[squares, times]


@dataclass(frozen=True, eq=False)
class DevianceProfile:
    """Profile quasi-deviance about an estimate: one quantity fixed, all other parameters optimal.

    Attributes
    ----------
    settling, best
        Solver of the family, and estimate.
    """

    solver: QuasiScoreSolver
    best: Point

    def end(self, constraint: Constraint, side: int, target: float, error: float) -> tuple[float, Point]:
        """Return a limit of the interval of a quantity (a squared density, a driving PSD, a time), and its point.

        The lower (upper) limit is zero (infinite) where the quasi-deviance stays below ``target``. The upper one is
        also infinite where the correlation time reaches its limit along the profile.

        Parameters
        ----------
        side
            -1 for the lower limit, 1 for the upper one.
        target
            Quasi-deviance at the limits.
        error
            Standard deviation of the logarithm, for the first trial.
        """
        first = min(np.sqrt(target) * error, LONGEST_FIRST)
        if not self.best.squares[constraint.column] > 0:
            return self._end_of_absent(constraint, side, target)
        value = constraint.of(self.best)
        if constraint.kind is ConstraintKind.TIME:
            limit = abs(self.solver.family.limits[side > 0] - np.log(value))
            walk = _ProfilePath(self, constraint, lambda distance: np.log(value) + side * distance)
            return float(value * np.exp(side * end(walk, target, first, limit))), walk.point
        walk = _ProfilePath(self, constraint, lambda distance: value * np.exp(side * distance))
        if side < 0 and first > WIDE and walk(np.inf) < target:
            return 0.0, walk.point
        found = float(value * np.exp(side * end(walk, target, first, REACH)))
        return np.inf if side > 0 and self._open(walk) else found, walk.point

    def _end_of_absent(self, constraint: Constraint, side: int, target: float) -> tuple[float, Point]:
        """Return the limit for a process of density zero, starting where it alone raises the deviance by ``target``."""
        if side < 0:
            return 0.0, self.best
        if constraint.kind is ConstraintKind.TIME:
            return np.inf, self.best
        white = self.solver.weights.white(self.best.implied)
        column, deviation = self.best.columns[:, constraint.column], self.solver.observed - self.best.implied
        pull, norm = max(-(white @ column) @ (white @ deviation), 0.0), np.sum((white @ column) ** 2)
        scale = (
            (np.sqrt(pull**2 + norm * target) - pull) / norm / replace(constraint, value=1.0).square(self.best.times)
        )
        walk = _ProfilePath(self, constraint, lambda distance: scale * np.expm1(distance))
        distance = end(walk, target, np.log(2.0), REACH)
        return np.inf if self._open(walk) else float(scale * np.expm1(distance)), walk.point

    def _open(self, walk: "_ProfilePath") -> bool:
        """Return whether the correlation time reached its limit: the upper with the std, the lower with the PSD."""
        if walk.constraint.markov is None:
            return False
        (low, high), time = self.solver.family.limits, walk.point.times[walk.constraint.markov]
        return bool(time <= low if walk.constraint.kind is ConstraintKind.DRIVING else time >= high)


class _ProfilePath:
    """Quasi-deviance as a function of the distance from the estimate; each solution starts from the previous one."""

    def __init__(self, profile: DevianceProfile, constraint: Constraint, value: Callable[[float], float]) -> None:
        self.profile, self.constraint, self.value, self.point = profile, constraint, value, profile.best

    def __call__(self, distance: float) -> float:
        solver, constraint, times = self.profile.solver, self.constraint, self.point.times.copy()
        if constraint.kind is ConstraintKind.TIME:
            times[constraint.markov] = self.value(distance)
        else:
            constraint = replace(constraint, value=float(self.value(distance)))
        squares = self.point.squares
        if constraint.value == 0 and not np.delete(squares, constraint.column).any():
            if len(squares) == 1:
                return np.inf
            squares = solver.each_alone(times)
        self.point = solver.solve(solver.at(times, squares, constraint), constraint, COARSE)[0][-1]
        return solver.weights.deviance(solver.observed, self.profile.best.implied, self.point.implied)
