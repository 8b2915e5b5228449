"""Generalised method of wavelet moments (GMWM): estimates from wavelet variances, with intervals.

The estimate is the model whose implied wavelet variances nu are nearest to the observed ones, nuhat, in the distance
(nuhat - nu)' W (nuhat - nu) (Liu, Ren, Li 2016; Guerrier, Skaloud, Stebler, Victoria-Feser 2013, Journal of
the American Statistical Association 108, 1021-1030). Where W depends on the model, it is that of the estimate.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.effects import Conditions, RateRamp
from imugap.estimation.gmwm.implied import Family
from imugap.estimation.gmwm.moments import MomentMatching, SandwichCovariance, Weighting
from imugap.estimation.gmwm.quasi_likelihood import (
    Constraint,
    ConstraintKind,
    DevianceProfile,
    QuasiScoreSolver,
    Weights,
)
from imugap.estimation.gmwm.start import Point
from imugap.estimation.likelihood import Composition, Quantity
from imugap.estimation.result import Fit, ParameterEstimate, identifiability
from imugap.estimation.variances import wavelet_variance
from imugap.model import ErrorModel
from imugap.numerics.fitting.damped_steps import Damping, optimise

REFINEMENTS = 2
"""Number of updates of a limit of an interval with the weights of the model there."""
NARROW = 0.2
"""Half width of an interval, and change of its limits, in logarithms, below which no update is needed."""
STEPS = 30
"""Gauss-Newton steps on simulated wavelet variances."""
DAMPING = Damping(first=1e-3, floor=1e-2)
SHIFT = 1e-3
"""Change of a log parameter in a difference quotient of simulated wavelet variances."""
STILL = 1e-6
"""Squared change of the implied wavelet variances, in standard deviations, at which these steps end."""


@dataclass(frozen=True)
class GmwmFit(Fit):
    """Model fitted to wavelet variances.

    The objective is the weighted sum of squared deviations; with FULL weights it has, for a model that is right, a
    chi-square distribution on levels - parameters degrees of freedom, approximately for the deep levels.

    The limits of an interval are where the profile quasi-deviance (:mod:`imugap.estimation.gmwm.quasi_likelihood`)
    equals the quantile of chi-square times the ratio of the sandwich variance to the inverse
    curvature, which is 1 with FULL weights.

    Attributes
    ----------
    history
        Iterations: index ``iteration``; columns ``objective`` and each parameter. The weights vary.
    covariance
        Sandwich covariance of the logarithms of the parameters; missing for those of a process with density zero.
    curve
        Index ``level``; columns ``tau`` [s], ``observed``, ``low``, ``high``, ``implied`` [unit^2].
    """

    history: pd.DataFrame
    covariance: pd.DataFrame
    curve: pd.DataFrame


@dataclass(frozen=True)
class GmwmOptions:
    """Options of a fit to wavelet variances.

    Attributes
    ----------
    ramp
        Whether the mean may have a ramp. Its sign is not seen; only Haar (width 2) sees its size.
    weighting, width
        Weights of the levels; width of Daubechies' filter.
    efficiency
        Below 1, the robust wavelet variance of that efficiency; the covariance is divided by it.
    level
        Confidence level of the intervals.
    """

    ramp: bool = False
    weighting: Weighting = Weighting.FULL
    width: int = 2
    efficiency: float = 1.0
    level: float = 0.95

    def curve(self, sequence: np.ndarray, interval: float) -> pd.DataFrame:
        """Return the wavelet variances to fit, columns ``variance``, ``low``, ``high`` [unit^2]."""
        return wavelet_variance.curve(np.asarray(sequence, float), interval, self.width, self.efficiency)


DEFAULT = GmwmOptions()


def fit(sequence: np.ndarray, interval: float, kinds: Sequence[type], options: GmwmOptions = DEFAULT) -> GmwmFit:
    """Fit a sum of processes to an error sequence of unknown mean.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), and sampling interval [s].
    kinds
        Types of the processes, e.g. ``(WhiteNoise, GaussMarkov, RandomWalk)``; any number of Gauss-Markov processes.
    """
    return fit_curve(options.curve(sequence, interval), len(sequence), interval, kinds, options)


def point_estimate(
    sequence: np.ndarray, interval: float, kinds: Sequence[type], options: GmwmOptions = DEFAULT
) -> tuple[ErrorModel, float]:
    """Return the model of :func:`fit` and its objective alone; most of the time of a fit goes into its intervals."""
    problem = _problem(options.curve(sequence, interval), len(sequence), interval, kinds, options)
    best = problem.estimate()[0][-1]
    best = best.reordered(np.argsort(best.times))
    return problem.family.composition.model(problem.theta(best)), best.distance


def fit_curve(
    curve: pd.DataFrame, count: int, interval: float, kinds: Sequence[type], options: GmwmOptions = DEFAULT
) -> GmwmFit:
    """Fit a sum of processes to the wavelet variances of ``count`` samples (the rest as in :func:`fit`).

    Parameters
    ----------
    curve
        Columns ``variance``, ``low``, ``high`` [unit^2]; a row for each level from 1 (:meth:`GmwmOptions.curve`).
    """
    problem = _problem(curve, count, interval, kinds, options)
    path, weights, converged = problem.estimate()
    return _result(problem, path, path[-1], weights, converged, options.level)


def fit_by_simulation(
    sequence: np.ndarray,
    interval: float,
    kinds: Sequence[type],
    seed: int,
    replicates: int = 20,
    options: GmwmOptions = DEFAULT,
) -> GmwmFit:
    """Fit by indirect inference, literally as in the source: by simulation (the rest as in :func:`fit`).

    The auxiliary parameters are the mean wavelet variances of ``replicates`` simulated sequences as long as the
    observed one; their random numbers stay the same (Gourieroux, Monfort, Renault 1993). Gauss-Newton steps in the log
    parameters, with difference quotients for slopes, start from a coarse grid; the weights are those of the analytic
    estimate, and processes whose density is zero there are left out. The covariance is multiplied by
    1 + 1/replicates. Intervals are those of the analytic problem, its wavelet variances multiplied by the ratio of
    simulated to analytic ones at the estimate.
    """
    curve = options.curve(sequence, interval)
    analytic = _problem(curve, len(sequence), interval, kinds, options)
    path, *_ = analytic.estimate()
    present, coarse = path[-1].squares > 0, path[0].squares
    start = replace(path[0], squares=np.where(present, np.where(coarse > 0, coarse, path[-1].squares), 0.0))
    problem = replace(analytic, efficiency=options.efficiency / (1 + 1 / replicates))
    weights = problem.weights(path[-1])
    auxiliary = SimulatedMoments(problem, weights.white(path[-1].implied), seed, replicates, options.efficiency)
    path, converged = auxiliary.descend(problem.theta(start))
    _, point, implied = path[-1]
    scaled = replace(problem, curve=curve.assign(variance=curve["variance"] * point.implied / implied))
    centre = QuasiScoreSolver(scaled.family, scaled.observed, weights).solve(point)[0][-1]
    result = _result(scaled, [one.point for one in path], centre, weights, converged, options.level)
    return replace(result, curve=result.curve.assign(observed=curve["variance"], implied=implied))


class SimulatedPoint(NamedTuple):
    """Log parameters, their model at its simulated distance, and its simulated wavelet variances, shape (levels,)."""

    theta: np.ndarray
    point: Point
    implied: np.ndarray


@dataclass(frozen=True, eq=False)
class SimulatedMoments:
    """Wavelet variances by simulation, and Gauss-Newton steps towards the observed ones.

    Attributes
    ----------
    problem, white
        Observed wavelet variances and family; whitening matrix of the deviations, shape (levels, levels).
    seed, replicates, efficiency
        Seed and number of the simulated sequences, and efficiency of their wavelet variances.
    """

    problem: MomentMatching
    white: np.ndarray
    seed: int
    replicates: int
    efficiency: float

    def descend(self, theta: np.ndarray) -> tuple[list[SimulatedPoint], bool]:
        """Return the points of damped Gauss-Newton steps from log parameters ``theta``, and the convergence."""
        return optimise(
            self._at(theta), self._propose, lambda one, other: one.point.distance < other.point.distance, DAMPING, STEPS
        )

    def _propose(self, path: list[SimulatedPoint], damping: float) -> SimulatedPoint | None:
        """Return the point of the next step, or None where it is negligible."""
        theta, implied = path[-1].theta, path[-1].implied
        slopes = self.white @ self._slopes(theta, implied)
        curvature, pull = slopes.T @ slopes, slopes.T @ (self.white @ (self.problem.observed - implied))
        step = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), pull)
        if np.sum((slopes @ step) ** 2) < STILL:
            return None
        ahead = theta.copy()
        ahead[np.isfinite(theta)] += step * min(1.0, 1 / np.abs(step).max())
        return self._at(ahead)

    def _at(self, theta: np.ndarray) -> SimulatedPoint:
        """Return the point with log parameters ``theta``, at its simulated distance."""
        implied = self._simulate(theta)
        distance = np.sum((self.white @ (self.problem.observed - implied)) ** 2)
        return SimulatedPoint(theta, replace(self.problem.at(theta), distance=float(distance)), implied)

    def _slopes(self, theta: np.ndarray, implied: np.ndarray) -> np.ndarray:
        """Return the slopes of the simulated wavelet variances in the finite log parameters."""
        steps = SHIFT * np.eye(len(theta))[np.isfinite(theta)]
        return np.transpose([self._simulate(theta + step) - implied for step in steps]) / SHIFT

    def _simulate(self, theta: np.ndarray) -> np.ndarray:
        """Return the mean wavelet variances of the simulated sequences, shape (levels,)."""
        family, total = self.problem.family, 0.0
        model, still = family.composition.model(theta), np.zeros(family.count)
        conditions = Conditions(family.interval * np.arange(family.count), family.interval)
        for replicate in range(self.replicates):
            sequence = model.simulate(still, conditions, self.seed, "auxiliary", replicate)
            total = total + wavelet_variance.estimated(sequence, family.levels, family.width, self.efficiency)
        return total / self.replicates


def _problem(
    curve: pd.DataFrame, count: int, interval: float, kinds: Sequence[type], options: GmwmOptions
) -> MomentMatching:
    if options.ramp and options.width != 2:
        raise ValueError(
            f"wavelet moments: expected width 2 with a ramp, which wider wavelets do not see; found {options.width}"
        )
    if not (curve["variance"] > 0).all():
        raise ValueError("wavelet moments: expected positive wavelet variances; found zero, negative or missing ones")
    composition = Composition.of(*kinds, *[RateRamp] * options.ramp)
    needed = len(composition.densities) + 2 * composition.markov
    if needed > len(curve):
        raise ValueError(
            f"wavelet moments: expected at least as many levels as parameters, {needed}; found {len(curve)}"
        )
    family = Family(composition, interval, count, len(curve), options.width)
    return MomentMatching(family, curve, Weighting(options.weighting), options.efficiency)


def _result(
    problem: MomentMatching, path: list[Point], centre: Point, weights: Weights, converged: bool, level: float
) -> GmwmFit:
    """Return the fit at the end of ``path``; intervals are about ``centre``, the root of the quasi-score."""
    order = np.argsort(path[-1].times)
    path, centre = [step.reordered(order) for step in path], centre.reordered(order)
    point, composition = path[-1], problem.family.composition
    spread = SandwichCovariance.of(problem, centre, weights)
    estimates = []
    for quantity, constraint in zip(composition.quantities(), _constraints(composition), strict=True):
        ends = [_end(problem, centre, weights, quantity, constraint, side, chdtri(1, 1 - level)) for side in (-1, 1)]
        power = 2 if constraint.kind is ConstraintKind.SQUARE else 1
        value, low, high = (float(end ** (1 / power)) for end in (constraint.of(point), *ends))
        error = spread.of_quantity(quantity, constraint)[1]
        estimates.append(ParameterEstimate(*quantity.key, value, low, high, error, identifiability(low, high)))
    names = [" ".join(map(str, row.key)) for row in composition.quantities() if np.sum(row.direction != 0) == 1]
    rows = [[step.distance, *np.exp(problem.theta(step))] for step in path]
    return GmwmFit(
        model=composition.model(problem.theta(point)),
        estimates=tuple(estimates),
        objective=point.distance,
        converged=converged,
        history=pd.DataFrame(rows, columns=["objective", *names]).rename_axis("iteration"),
        covariance=pd.DataFrame(spread.covariance(), index=names, columns=names),
        curve=_curve(problem, point),
    )


def _end(
    problem: MomentMatching,
    centre: Point,
    weights: Weights,
    quantity: Quantity,
    constraint: Constraint,
    side: int,
    target: float,
) -> float:
    """Return a limit of the interval of a quantity.

    The weights and the covariance are those of the model at the limit; for a narrow interval, of the estimate.
    """
    where, best, found = centre, centre, np.nan
    for _ in range(REFINEMENTS + 1):
        inflation, error = SandwichCovariance.of(problem, where, weights).of_quantity(quantity, constraint)
        power = 2 if constraint.kind is ConstraintKind.SQUARE else 1
        solver = QuasiScoreSolver(problem.family, problem.observed, weights)
        last, (found, where) = (
            found,
            DevianceProfile(solver, best).end(constraint, side, inflation * target, power * error),
        )
        near = constraint.of(centre) if np.isnan(last) else last
        if not 0 < found < np.inf or (near > 0 and abs(np.log(found / near)) < power * NARROW):
            break
        weights = problem.weights(where)
        best = replace(solver, weights=weights).solve(best)[0][-1]
    return found


def _constraints(composition: Composition) -> Iterator[Constraint]:
    """Yield the constraint that fixes each quantity of a composition."""
    first = len(composition.densities)
    yield from (Constraint(ConstraintKind.SQUARE, column) for column in range(first))
    for i in range(composition.markov):
        yield from (
            Constraint(kind, first + i, i)
            for kind in (ConstraintKind.SQUARE, ConstraintKind.TIME, ConstraintKind.DRIVING)
        )


def _curve(problem: MomentMatching, point: Point) -> pd.DataFrame:
    index = pd.RangeIndex(1, problem.family.levels + 1, name="level")
    columns = {
        "tau": 2.0 ** (index - 1) * problem.family.interval,
        "observed": problem.observed,
        "low": problem.curve["low"].to_numpy(float),
        "high": problem.curve["high"].to_numpy(float),
        "implied": point.implied,
    }
    return pd.DataFrame(columns, index=index)
