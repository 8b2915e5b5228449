import numpy as np
import pytest
from tests.estimation.gmwm.families import INTERVAL

from imugap.effects import Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.gmwm.implied import Family
from imugap.estimation.gmwm.moments import MomentMatching, SandwichCovariance, Weighting
from imugap.estimation.gmwm.quasi_likelihood import Constraint, ConstraintKind
from imugap.estimation.likelihood import Composition
from imugap.estimation.variances import wavelet_variance

COUNT = 4000
MODEL = WhiteNoise(5e-2) + GaussMarkov(0.1, 5.0)


def problem(weighting, model=MODEL, label=0, kinds=None, efficiency=1.0):
    at = Conditions(INTERVAL * np.arange(COUNT), INTERVAL)
    curve = wavelet_variance.curve(model.simulate(np.zeros(COUNT), at, 17, "moments", label), INTERVAL)
    composition = Composition.of(*(kinds or map(type, model)))
    return MomentMatching(Family(composition, INTERVAL, COUNT, len(curve), 2), curve, weighting, efficiency)


def expected_weights(found, covariance):
    """The weights of a problem by their definition, from the covariance of its wavelet variances."""
    width = (found.curve["high"] - found.curve["low"]).to_numpy()
    return {
        Weighting.INTERVAL: np.diag(width**-2.0),
        Weighting.DIAGONAL: np.diag(1 / np.diag(covariance)),
        Weighting.FULL: np.linalg.inv(covariance),
    }[found.weighting]


@pytest.mark.parametrize("weighting", Weighting)
def test_weights_are_those_of_the_definition(weighting):
    found = problem(weighting, efficiency=0.5)
    path, weights, converged = found.estimate()
    assert converged
    implied = path[-1].implied
    model = found.family.composition.model(found.theta(path[-1]))
    covariance = 2 * wavelet_variance.covariance(model, INTERVAL, COUNT, len(implied))
    expected = expected_weights(found, covariance)
    white, scale = weights.white(implied), np.sqrt(np.diag(expected))
    np.testing.assert_allclose(white.T @ white / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.01)


@pytest.mark.parametrize("weighting", Weighting)
def test_weighted_slopes_of_the_wavelet_variances_are_orthogonal_to_the_deviations(weighting):
    """First-order conditions, with slopes by differences of :func:`wavelet.implied` and an independent covariance."""
    found = problem(weighting, label=1)
    point = found.estimate()[0][-1]
    theta, composition = found.theta(point), found.family.composition
    levels, step = found.family.levels, 1e-5
    shifts = step * np.eye(len(theta))
    slopes = np.array(
        [
            np.subtract(
                *(wavelet_variance.implied(composition.model(theta + s), INTERVAL, levels) for s in (shift, -shift))
            )
            for shift in shifts
        ]
    ) / (2 * step)
    covariance = wavelet_variance.covariance(composition.model(theta), INTERVAL, COUNT, levels)
    weights = expected_weights(found, covariance)
    score = slopes @ weights @ (found.observed - wavelet_variance.implied(composition.model(theta), INTERVAL, levels))
    assert np.all(np.abs(score) < 0.01 * np.sqrt(np.diag(slopes @ weights @ slopes.T)))


def test_parameters_and_points_are_two_ways_to_say_the_same():
    found = problem(Weighting.FULL, kinds=(WhiteNoise, GaussMarkov, RandomWalk))
    theta = np.array([np.log(0.3), -np.inf, np.log(2.0), np.log(7.0)])
    point = found.at(theta)
    np.testing.assert_allclose(found.theta(point), theta)
    model = found.family.composition.model(theta)
    np.testing.assert_allclose(point.implied, wavelet_variance.implied(model, INTERVAL, found.family.levels), rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("weighting", Weighting)
def test_sandwich_covariance_is_that_of_the_estimates(weighting):
    """Within 4.5 standard errors of 150 runs."""
    runs = 150
    fits = [problem(weighting, label=run) for run in range(runs)]
    points = [fit.estimate()[0][-1] for fit in fits]
    found = np.array([fit.theta(point) for fit, point in zip(fits, points, strict=True)])
    truth = fits[0].at(np.log([5e-2, 0.1, 5.0]))
    expected = np.diag(SandwichCovariance.of(fits[0], truth, fits[0].weights(truth)).covariance())
    ratio = found.var(axis=0, ddof=1) / expected
    assert np.all(np.abs(ratio - 1) < 4.5 * np.sqrt(2 / runs))


def test_full_weights_need_no_inflation_and_others_do():
    for weighting in Weighting:
        found = problem(weighting)
        path, weights, _ = found.estimate()
        spread = SandwichCovariance.of(found, path[-1], weights)
        quantity = found.family.composition.quantities()[2]
        inflation, error = spread.of_quantity(quantity, Constraint(ConstraintKind.TIME, 1, 0))
        assert error == pytest.approx(np.sqrt(spread.covariance()[2, 2]))
        if weighting is Weighting.FULL:
            assert inflation == pytest.approx(1.0, abs=0.01)
        else:
            assert abs(inflation - 1) > 0.01
