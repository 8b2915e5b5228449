from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.estimation.gmwm.families import family_of

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.gmwm.quasi_likelihood import (
    FREE,
    Constraint,
    ConstraintKind,
    DevianceProfile,
    QuasiScoreSolver,
    Weights,
)
from imugap.estimation.gmwm.start import DistanceSearch
from imugap.stream import stream

LEVELS = 12
TRUTH = np.array([1.0, 3e-3, 1.0])
FAMILY = family_of(WhiteNoise, RandomWalk, GaussMarkov)
EDF = 4000 / 2.0 ** np.arange(LEVELS)


def correlated():
    """Relative weights of neighbouring levels that are correlated by a third."""
    near = np.eye(LEVELS) + (np.eye(LEVELS, k=1) + np.eye(LEVELS, k=-1)) / 3
    scatter = near * np.sqrt(2 / EDF)[:, None] * np.sqrt(2 / EDF)
    return Weights(np.linalg.inv(np.linalg.cholesky(scatter)), relative=True)


DIAGONAL = Weights(np.diag(np.sqrt(EDF / 2)), relative=True)
FIXED = Weights(np.diag(1 / np.arange(1.0, LEVELS + 1)), relative=False)
ALL = pytest.mark.parametrize("weights", [DIAGONAL, correlated(), FIXED], ids=["diagonal", "full", "fixed"])


def observed(*labels):
    columns = np.hstack([FAMILY.densities, FAMILY.markov(np.log([20.0]))])
    return columns @ TRUTH * stream(3, *labels).chisquare(EDF) / EDF


def best(weights, seen, constraint=FREE):
    start = DistanceSearch(FAMILY, seen, weights.white(seen)).descend_from_grid(1e-3)[0][0][-1]
    return QuasiScoreSolver(FAMILY, seen, weights).solve(start, constraint)[0][-1]


def ends(profile, constraint, target, error):
    return tuple(profile.end(constraint, side, target, error)[0] for side in (-1, 1))


@ALL
def test_score_is_the_slope_of_the_deviance(weights):
    seen, here = observed(), 1.1 * observed("here")
    step = 1e-5 * here * stream(3, "direction").standard_normal(LEVELS)
    rise = weights.deviance(seen, here, here + step) - weights.deviance(seen, here, here - step)
    pull, stiffness = weights.score(seen, here)
    assert rise == pytest.approx(-4 * pull @ step, rel=1e-6)
    ends = [weights.score(seen, here + sign * step)[0] for sign in (-1, 1)]
    np.testing.assert_allclose(ends[0] - ends[1], 2 * stiffness @ step, rtol=1e-4, atol=1e-8 * np.abs(pull).max())


def test_deviance_of_independent_levels_is_that_of_chi_square_variances():
    seen, one, other = observed(), 1.2 * observed("one"), 0.7 * observed("other")

    def twice_minus_log_likelihood(implied):
        return np.sum(EDF * (seen / implied + np.log(implied)))

    expected = twice_minus_log_likelihood(other) - twice_minus_log_likelihood(one)
    assert DIAGONAL.deviance(seen, one, other) == pytest.approx(expected)


@ALL
def test_score_vanishes_where_the_steps_end(weights):
    seen = observed("settled")
    start = DistanceSearch(FAMILY, seen, weights.white(seen)).descend_from_grid(1e-3)[0][0][-1]
    path, converged = QuasiScoreSolver(FAMILY, seen, weights).solve(start, accuracy=1e-16)
    point = path[-1]
    assert converged
    slopes = np.hstack([point.columns, FAMILY.slopes(point.times)[1] * point.squares[2:]])
    white = weights.white(point.implied)
    score, scale = slopes.T @ weights.score(seen, point.implied)[0], np.linalg.norm(white @ slopes, axis=0)
    present = np.r_[point.squares > 0, True]
    np.testing.assert_allclose(score[present] / scale[present], 0, atol=1e-6)
    assert (score[~present] < 0).all()
    assert point.distance == pytest.approx(np.sum((white @ (seen - point.implied)) ** 2))


@ALL
@pytest.mark.parametrize("factor", [0.8, 1.3])
@pytest.mark.parametrize(
    "constraint",
    [
        Constraint(ConstraintKind.SQUARE, 0),
        Constraint(ConstraintKind.SQUARE, 2, 0),
        Constraint(ConstraintKind.DRIVING, 2, 0),
        Constraint(ConstraintKind.TIME, 2, 0),
    ],
    ids=["density", "std", "driving", "time"],
)
def test_what_is_held_stays_and_the_rest_is_at_its_best(weights, constraint, factor):
    seen = observed("held")
    free = best(weights, seen)
    value = factor * constraint.of(free)
    held = replace(constraint, value=value)
    times = free.times + np.log(factor) * (constraint.kind is ConstraintKind.TIME)
    solver = QuasiScoreSolver(FAMILY, seen, weights)
    path, converged = solver.solve(solver.at(times, free.squares, held), held)
    point = path[-1]
    assert converged
    assert constraint.of(point) == pytest.approx(value)
    rise = weights.deviance(seen, free.implied, point.implied)
    assert rise > 0
    for k in range(4):  # no neighbour that keeps what is held is better
        for side in (-1e-3, 1e-3):
            squares, times = point.squares.copy(), point.times.copy()
            if k < 3:
                squares[k] *= 1 + side
            elif constraint.kind is not ConstraintKind.TIME:
                times += side
            other = solver.at(times, squares, held)
            assert weights.deviance(seen, point.implied, other.implied) > -1e-6


def test_interval_of_one_white_noise_is_that_of_its_chi_square_variance():
    family, edf = family_of(WhiteNoise, levels=1), 7.0
    weights, seen = Weights(np.diag([np.sqrt(edf / 2)]), relative=True), np.array([2.0])
    point = DistanceSearch(family, seen, weights.white(seen)).descend_from_grid(1e-3)[0][0][-1]
    found = ends(
        DevianceProfile(QuasiScoreSolver(family, seen, weights), point), Constraint(ConstraintKind.SQUARE, 0), 3.84, 0.5
    )

    def deviance(square):
        ratio = 2.0 / (square * family.densities[0, 0])
        return edf * (ratio - 1 - np.log(ratio)) - 3.84

    square = 2.0 / family.densities[0, 0]
    expected = brentq(deviance, square / 50, square), brentq(deviance, square, 50 * square)
    np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_a_process_that_is_not_there_has_an_upper_bound_and_no_lower():
    columns = np.hstack([FAMILY.densities, FAMILY.markov(np.log([20.0]))])
    seen = columns @ [1.0, 0.0, 1.0] * 0.97 ** np.arange(LEVELS)
    weights = correlated()
    point = best(weights, seen)
    assert point.squares[1] == 0
    profile = DevianceProfile(QuasiScoreSolver(FAMILY, seen, weights), point)
    low, high = ends(profile, Constraint(ConstraintKind.SQUARE, 1), 3.84, np.inf)
    assert low == 0
    held = Constraint(ConstraintKind.SQUARE, 1, value=high)
    solver = profile.solver
    at_end = solver.solve(solver.at(point.times, point.squares, held), held)[0][-1]
    assert weights.deviance(seen, point.implied, at_end.implied) == pytest.approx(3.84, rel=0.01)


def test_times_and_stds_beyond_the_log_have_no_upper_end():
    family = family_of(WhiteNoise, GaussMarkov)
    walk = family.markov(np.array([family.limits[1] - 2.0]))
    seen, weights = np.hstack([family.densities, walk / walk[-1]]) @ [1.0, 1.0], DIAGONAL
    start = DistanceSearch(family, seen, weights.white(seen)).descend_from_grid(1e-6)[0][0][-1]
    solver = QuasiScoreSolver(family, seen, weights)
    profile = DevianceProfile(solver, solver.solve(start)[0][-1])
    low, high = ends(profile, Constraint(ConstraintKind.TIME, 1, 0), 3.84, 2.0)
    assert 0 < low < np.inf
    assert high == np.inf
    assert ends(profile, Constraint(ConstraintKind.SQUARE, 1, 0), 3.84, 2.0)[1] == np.inf
    low, high = ends(profile, Constraint(ConstraintKind.DRIVING, 1, 0), 3.84, 0.1)
    assert 0 < low < high < np.inf


def test_a_process_may_be_absent_where_another_can_stand_for_it():
    """The estimate has white noise alone; without it the Gauss-Markov process takes its place, at some deviance."""
    family = family_of(WhiteNoise, GaussMarkov)
    seen = family.densities[:, 0] * stream(3, "alone").chisquare(EDF) / EDF
    solver = QuasiScoreSolver(family, seen, DIAGONAL)
    white = solver.at(np.log([20.0]), np.array([1.0, 0.0]))
    without = Constraint(ConstraintKind.SQUARE, 0)
    low, point = DevianceProfile(solver, white).end(without, -1, 1e6, 1e9)
    assert low == 0
    assert point.squares[0] == 0
    assert (point.implied > 0).all()


def test_the_only_process_is_not_absent():
    family = family_of(WhiteNoise)
    solver = QuasiScoreSolver(family, family.densities[:, 0].copy(), DIAGONAL)
    only = solver.at(np.empty(0), np.array([1.0]))
    low, _ = DevianceProfile(solver, only).end(Constraint(ConstraintKind.SQUARE, 0), -1, 4.0, 1e9)
    assert 0 < low < 1
