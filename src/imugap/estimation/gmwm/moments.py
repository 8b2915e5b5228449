"""Matching of wavelet moments: observed wavelet variances, a family of models, and the weights of the levels."""

from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache

import numpy as np
import pandas as pd

from imugap.estimation.gmwm.implied import Family
from imugap.estimation.gmwm.quasi_likelihood import Constraint, ConstraintKind, QuasiScoreSolver, Weights
from imugap.estimation.gmwm.start import DistanceSearch, Point
from imugap.estimation.likelihood import Quantity
from imugap.estimation.variances import wavelet_variance

ROUNDS = 12
"""Largest number of updates of the weights."""
SETTLED = 1e-3
"""Squared change of the implied wavelet variances, in standard deviations, at which the updates of the weights end.

The next would change them by about a thousandth of that.
"""
COARSE, FINE = 1e-3, 1e-13
"""Relative accuracy of minima under provisional and under final weights."""
NEAR = 0.01
"""Difference of log correlation times below which two minima are the same."""
BETTER = 1e-3
"""Decrease of the quasi-deviance at which another minimum is preferred."""

_covariance = lru_cache(maxsize=8)(wavelet_variance.covariance)
"""Weights and the intervals of all quantities are those of the same few models."""


class Weighting(StrEnum):
    """Weights of the deviations of the wavelet variances."""

    INTERVAL = "interval"
    """1/(high - low)^2 of their intervals, as in gmwm."""
    DIAGONAL = "diagonal"
    """The inverse of their variances under the estimated model."""
    FULL = "full"
    """The inverse of their covariance under the estimated model."""


@dataclass(frozen=True, eq=False)
class MomentMatching:
    """Observed wavelet variances and the family of models to match to them.

    Attributes
    ----------
    family, curve
        Family; wavelet variances: columns ``variance``, ``low``, ``high`` [unit^2], a row for each level.
    weighting, efficiency
        Weights of the levels; efficiency of the wavelet variances relative to the plain ones.
    """

    family: Family
    curve: pd.DataFrame
    weighting: Weighting
    efficiency: float

    @property
    def observed(self) -> np.ndarray:
        """Return the observed wavelet variances, shape (levels,)."""
        return self.curve["variance"].to_numpy(float)

    def estimate(self) -> tuple[list[Point], Weights, bool]:
        """Return the path to the estimate, its weights, and whether the quasi-score is zero there."""
        weights = self._first_weights()
        nearest = DistanceSearch(self.family, self.observed, weights.white(self.observed))
        path, converged = nearest.descend_from_grid(COARSE if weights.relative else FINE)[0]
        if self.weighting is Weighting.INTERVAL:
            return path, weights, converged
        path, weights, converged = self._iterate(path)
        other = self._other_minimum(path[-1], weights)
        return (path, weights, converged) if other is None else self._iterate([*path, other])

    def _other_minimum(self, point: Point, weights: Weights) -> Point | None:
        """Return the best other minimum under the weights of ``point`` if its quasi-deviance is lower, else None."""
        solver = QuasiScoreSolver(self.family, self.observed, weights)
        ways = DistanceSearch(self.family, self.observed, weights.white(point.implied)).descend_from_grid(COARSE)
        ends = [way[-1] for way, _ in ways if not np.allclose(way[-1].times, point.times, atol=NEAR)]
        others = [solver.solve(end)[0][-1] for end in ends]
        lead = [weights.deviance(self.observed, point.implied, other.implied) for other in others]
        return others[int(np.argmin(lead))] if min(lead, default=0.0) < -BETTER else None

    def _first_weights(self) -> Weights:
        """Return weights that do not depend on a model."""
        if self.weighting is Weighting.INTERVAL:
            return Weights(np.diag(1 / (self.curve["high"] - self.curve["low"]).to_numpy(float)), relative=False)
        edf = wavelet_variance.edf_octave(self.family.count, self.family.levels, self.family.width)
        return Weights(np.diag(np.sqrt(edf * self.efficiency / 2)), relative=True)

    def _iterate(self, path: list[Point]) -> tuple[list[Point], Weights, bool]:
        """Continue the path until the weights are those of the estimate."""
        for _ in range(ROUNDS):
            point = path[-1]
            weights = self.weights(point)
            further, converged = QuasiScoreSolver(self.family, self.observed, weights).solve(point)
            path = path + further[1:]
            change = weights.white(point.implied) @ (path[-1].implied - point.implied)
            if not converged or change @ change < SETTLED:
                return path, weights, converged
        return path, weights, False

    def weights(self, point: Point) -> Weights:
        """Return the weights of the model at ``point``."""
        if self.weighting is Weighting.INTERVAL:
            return self._first_weights()
        relative = self.covariance(point) / np.outer(point.implied, point.implied)
        if self.weighting is Weighting.DIAGONAL:
            return Weights(np.diag(np.diag(relative) ** -0.5), relative=True)
        return Weights(np.linalg.inv(np.linalg.cholesky(relative)), relative=True)

    def covariance(self, point: Point) -> np.ndarray:
        """Return the covariance of the wavelet variances, shape (levels, levels), under the model at ``point``."""
        model, family = self.family.composition.model(self.theta(point)), self.family
        plain = _covariance(model, family.interval, family.count, family.levels, family.width)
        return plain / self.efficiency

    def at(self, theta: np.ndarray) -> Point:
        """Return the point with log parameters ``theta``; a density is absent at minus infinity."""
        first = len(self.family.composition.densities)
        stds, times = theta[first:].reshape(-1, 2).T
        columns = np.hstack([self.family.densities, self.family.markov(times)])
        return Point(times, columns, np.exp(2 * np.r_[theta[:first], stds]), np.nan)

    def theta(self, point: Point) -> np.ndarray:
        """Return the log parameters, in the order of the composition."""
        first = len(self.family.composition.densities)
        with np.errstate(divide="ignore"):
            densities = np.log(point.squares) / 2
        return np.r_[densities[:first], np.c_[densities[first:], point.times].ravel()]


@dataclass(frozen=True, eq=False)
class SandwichCovariance:
    """Sandwich covariance of the parameters, from the derivatives and the covariance of whitened wavelet variances.

    Attributes
    ----------
    slopes
        Derivatives in the log parameters, shape (levels, parameters); of an absent process in its squared density.
    scatter
        Covariance of the whitened observed variances, shape (levels, levels).
    present
        Whether the density of the process of a parameter is above zero, shape (parameters,).
    """

    slopes: np.ndarray
    scatter: np.ndarray
    present: np.ndarray

    @classmethod
    def of(cls, problem: MomentMatching, point: Point, weights: Weights) -> "SandwichCovariance":
        """Compute it for the model at ``point``."""
        first = len(problem.family.composition.densities)
        there = point.squares > 0
        by_square = point.columns * np.where(there, 2 * point.squares, 1.0)
        by_time = problem.family.slopes(point.times)[1] * point.squares[first:]
        pairs = np.stack([by_square[:, first:], by_time], axis=2).reshape(len(by_square), -1)
        white = weights.white(point.implied)
        present = np.r_[there[:first], np.repeat(there[first:], 2)]
        slopes = white @ np.hstack([by_square[:, :first], pairs])
        return cls(slopes, white @ problem.covariance(point) @ white.T, present)

    def covariance(self) -> np.ndarray:
        """Return the sandwich covariance of the log parameters; missing for an absent process."""
        result = np.full((len(self.present), len(self.present)), np.nan)
        result[np.ix_(self.present, self.present)] = self._pair(self.present)[1]
        return result

    def of_quantity(self, quantity: Quantity, constraint: Constraint) -> tuple[float, float]:
        """Return the ratio of sandwich variance to inverse curvature, and the relative standard deviation."""
        chosen = self.present.copy()
        own = np.flatnonzero(quantity.direction)[0]
        there = chosen[own]
        if not there and constraint.kind is ConstraintKind.TIME:
            return 1.0, np.inf
        chosen[own] = True
        naive, sandwich = (quantity.direction[chosen] @ m @ quantity.direction[chosen] for m in self._pair(chosen))
        return float(sandwich / naive), float(np.sqrt(sandwich)) if there else np.inf

    def _pair(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return inverse curvature and sandwich covariance of some parameters."""
        slopes = self.slopes[:, chosen]
        scale = np.linalg.norm(slopes, axis=0)
        inverse = np.linalg.pinv(slopes / scale, rcond=1e-10) / scale[:, None]
        return inverse @ inverse.T, inverse @ self.scatter @ inverse.T
