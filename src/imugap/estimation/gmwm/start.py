"""Global search for the model of a family whose wavelet variances are nearest to the observed ones.

Given the correlation times, the wavelet variances are linear in the squared densities, which cannot be negative: the
weighted distance is a non-negative least-squares problem (Lawson & Hanson 1974), in which a density that is not needed
becomes exactly zero. The remaining search is over the logarithms of the correlation times (variable projection: Golub
& Pereyra 1973, SIAM J. Numer. Anal. 10, 413-432): on a grid, and by damped Gauss-Newton steps from its best points.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.optimize import nnls

from imugap.estimation.gmwm.implied import Family
from imugap.numerics.fitting.damped_steps import Damping, optimise

GRID = {0: 1, 1: 36, 2: 24, 3: 14}
"""Points of the grid of correlation times, by number of Gauss-Markov processes."""
STARTS = 4
"""Best points of the grid from which steps start."""
ITERATIONS = 60
DAMPING = Damping(first=1e-6, floor=1e-3, least=1e-12)
PLAIN = 5
"""Gauss-Newton steps before the curvature includes the residuals, which only poor fits need."""
LONGEST_STEP = 1.0
"""Largest change of the logarithm of a correlation time in one step."""
DIFFERENCE = 1e-4
"""Step of the logarithm of a correlation time in a difference quotient."""


@dataclass(frozen=True, eq=False)
class Point:
    """Model of a family, with its distance from the observed wavelet variances.

    Attributes
    ----------
    times
        Logarithms of the correlation times, shape (markov,).
    columns
        Wavelet variances of each process at unit density or std, shape (levels, processes).
    squares
        Squared densities, then squared stds, shape (processes,).
    distance
        Weighted sum of the squared deviations.
    """

    times: np.ndarray
    columns: np.ndarray
    squares: np.ndarray
    distance: float

    @property
    def implied(self) -> np.ndarray:
        """Return the wavelet variances, shape (levels,)."""
        return self.columns @ self.squares

    def reordered(self, order: np.ndarray) -> "Point":
        """Return the same with the Gauss-Markov processes in another order."""
        index = np.arange(len(self.squares))
        first = len(index) - len(order)
        index[first:] = first + order
        return Point(self.times[order], self.columns[:, index], self.squares[index], self.distance)


@dataclass(frozen=True, eq=False)
class DistanceSearch:
    """Search for the model of a family that minimises the norm of ``white`` times the deviations.

    Attributes
    ----------
    family, observed
        Family and observed wavelet variances, shape (levels,).
    white
        Whitening matrix of the deviations, shape (levels, levels).
    """

    family: Family
    observed: np.ndarray
    white: np.ndarray

    def descend_from_grid(self, accuracy: float) -> list[tuple[list[Point], bool]]:
        """Return the results of :meth:`descend` from the best separate points of the grid, best first."""
        ways = [self.descend(start, accuracy) for start in self._starts()]
        return sorted(ways, key=lambda way: way[0][-1].distance)

    def descend(self, start: Point, accuracy: float) -> tuple[list[Point], bool]:
        """Return the points of damped Gauss-Newton steps from ``start``, and whether the last is stationary.

        The steps end where the predicted decrease is below ``accuracy`` times the distance (or times one).
        """

        def propose(path: list[Point], damping: float) -> Point | None:
            point = path[-1]
            step, gain = self._step(point, damping, len(path) > PLAIN)
            if gain <= accuracy * max(point.distance, 1.0):
                return None
            return self.at(np.clip(point.times + step, *self.family.limits))

        return optimise(start, propose, lambda one, other: one.distance < other.distance, DAMPING, ITERATIONS)

    def _starts(self) -> list[Point]:
        ranked, best = sorted(self._grid(), key=lambda row: row[1].distance), []
        while ranked and len(best) < STARTS:
            centre, point = ranked[0]
            best.append(point)
            ranked = [row for row in ranked if np.abs(row[0] - centre).max(initial=0) > 1]
        return best

    def _grid(self) -> Iterator[tuple[np.ndarray, Point]]:
        markov = self.family.composition.markov
        times = np.linspace(*self.family.limits, GRID.get(markov, 11))
        fixed, columns = self.family.densities, self.family.markov(times)
        for chosen in combinations(range(len(times)), markov):
            index = np.array(chosen, int)
            yield index, self._solve(times[index], np.hstack([fixed, columns[:, index]]))

    def at(self, times: np.ndarray) -> Point:
        """Return the best non-negative squares at these correlation times, with their distance."""
        return self._solve(times, np.hstack([self.family.densities, self.family.markov(times)]))

    def _solve(self, times: np.ndarray, columns: np.ndarray) -> Point:
        basis = self.white @ columns
        scale = np.sqrt(np.einsum("ij,ij->j", basis, basis))
        squares, distance = nnls(basis / scale, self.white @ self.observed)
        return Point(times, columns, squares / scale, float(distance) ** 2)

    def _step(self, point: Point, damping: float, exact: bool) -> tuple[np.ndarray, float]:
        """Return the damped step of the log correlation times and the predicted decrease of the distance."""
        low, high = self.family.limits
        step = np.zeros(len(point.times))
        pull, curvature = self._pull(point)
        moves = (np.diag(curvature) > 0) & ((point.times > low) | (pull > 0)) & ((point.times < high) | (pull < 0))
        if not moves.any():
            return step, 0.0
        inner = curvature[np.ix_(moves, moves)]
        if exact:
            full = self._curvature(point, moves)
            inner = full if np.linalg.eigvalsh(full).min() > 0 else inner
        step[moves] = np.linalg.solve(inner + damping * np.diag(np.diag(inner)), pull[moves])
        step *= min(1.0, LONGEST_STEP / max(np.abs(step).max(), 1e-300))
        return step, float(pull @ step)

    def _pull(self, point: Point) -> tuple[np.ndarray, np.ndarray]:
        """Return minus half the gradient of the distance in the log correlation times, and its Gauss-Newton matrix."""
        markov = point.squares[len(point.squares) - len(point.times) :]
        onto, _ = np.linalg.qr(self.white @ point.columns[:, point.squares > 0])
        jacobian = self.white @ (self.family.slopes(point.times)[1] * markov)
        jacobian -= onto @ (onto.T @ jacobian)
        return jacobian.T @ (self.white @ (self.observed - point.implied)), jacobian.T @ jacobian

    def _curvature(self, point: Point, moves: np.ndarray) -> np.ndarray:
        """Return half the Hessian of the distance by difference quotients, residual terms included."""
        rows = []
        for shift in DIFFERENCE * np.eye(len(moves))[moves]:
            below, above = (self._pull(self.at(point.times + sign * shift))[0][moves] for sign in (-1, 1))
            rows.append((below - above) / (2 * DIFFERENCE))
        return (np.array(rows) + np.transpose(rows)) / 2
