import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_normal
from tests.estimation.simulated import INTERVAL, MODELS, contrasts, covariance, models, ramps, simulate

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.likelihood import (
    Composition,
    Cosines,
    Grid,
    innovations,
    log_likelihood,
    parameters,
    slope,
    slope_density,
    value_and_gradient,
)
from imugap.stream import stream


def dense(model, sequence, ramp):
    basis = contrasts(len(sequence), ramp)
    return multivariate_normal(None, basis.T @ covariance(model, len(sequence)) @ basis).logpdf(basis.T @ sequence)


@models
@ramps
@pytest.mark.parametrize("count", [7, 60, 101])
def test_cosine_form_is_the_dense_gaussian_density(model, ramp, count):
    sequence = simulate(model, count, count) + 4.0 + 0.3 * np.arange(count)
    assert log_likelihood(model, sequence, INTERVAL, ramp) == pytest.approx(dense(model, sequence, ramp), rel=1e-9)


@models
@pytest.mark.parametrize("count", [7, 60, 101])
def test_innovations_form_is_the_dense_gaussian_density(model, count):
    sequence = simulate(model, count, count) + 4.0
    assert innovations(model, sequence, INTERVAL) == pytest.approx(dense(model, sequence, False), rel=1e-9)


@models
def test_binning_keeps_likelihood_ratios(model):
    """Both forms on a long log, binned and with a steady gain: the ratio to a model 5 % off agrees to a few percent."""
    composition, theta = parameters(model)
    other = composition.model(theta + 0.05 * (-1.0) ** np.arange(len(theta)))
    sequence = simulate(model, 30_000, "long")
    exact = innovations(model, sequence, INTERVAL) - innovations(other, sequence, INTERVAL)
    binned = log_likelihood(model, sequence, INTERVAL) - log_likelihood(other, sequence, INTERVAL)
    assert binned == pytest.approx(exact, rel=0.03, abs=0.1)


def test_steady_gain_changes_nothing_that_matters():
    model = WhiteNoise(5e-3) + GaussMarkov(5e-3, 20.0) + RandomWalk(3e-4)
    sequence = simulate(model, 50_000, "steady")
    composition, theta = parameters(model)
    cosines = whole(sequence)
    exact = value_and_gradient(theta, composition.shapes(cosines.grid), cosines)[0]
    assert innovations(model, sequence, INTERVAL) == pytest.approx(exact, abs=1e-3)


def whole(sequence):
    """The statistics of a sequence without binning."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("imugap.estimation.likelihood.SINGLE", len(sequence))
        return Cosines.of(sequence, INTERVAL)


@settings(deadline=None, max_examples=30)
@given(st.floats(-1e3, 1e3), st.floats(-1, 1))
def test_a_constant_and_an_unknown_ramp_change_nothing(constant, slope):
    model, sequence = MODELS["all"], simulate(MODELS["all"], 300, "constant")
    moved = sequence + constant
    assert log_likelihood(model, moved, INTERVAL) == pytest.approx(log_likelihood(model, sequence, INTERVAL), abs=1e-6)
    assert innovations(model, moved, INTERVAL) == pytest.approx(innovations(model, sequence, INTERVAL), abs=1e-6)
    tilted = moved + slope * np.arange(300)
    still = log_likelihood(model, sequence, INTERVAL, ramp=True)
    assert log_likelihood(model, tilted, INTERVAL, ramp=True) == pytest.approx(still, abs=1e-6)


@settings(deadline=None, max_examples=30)
@given(st.floats(1e-9, 1e6))
def test_units_change_the_density_by_their_jacobian(scale):
    model, sequence = MODELS["all"], simulate(MODELS["all"], 300, "scale")
    composition, theta = parameters(model)
    shift = np.array([0.0 if row.key[2] == "correlation_time" else np.log(scale) for row in composition.quantities()])
    keep = [row.key[2] != "driving_psd" for row in composition.quantities()]
    scaled = composition.model(theta + shift[keep])
    for form in (log_likelihood, innovations):
        expected = form(model, sequence, INTERVAL) - 299 * np.log(scale)
        assert form(scaled, scale * sequence, INTERVAL) == pytest.approx(expected, abs=1e-6)


@models
@ramps
@pytest.mark.parametrize("count", [60, 3000])
def test_gradient_is_that_of_the_value(model, ramp, count):
    composition, theta = parameters(model)
    theta = theta + 0.3 * stream(1, "off").standard_normal(len(theta))
    cosines = Cosines.of(simulate(model, count, "gradient"), INTERVAL, ramp=ramp)
    shapes = composition.shapes(cosines.grid)

    def value(point):
        return value_and_gradient(point, shapes, cosines)[0]

    step = 1e-5 * np.eye(len(theta))
    differences = [(value(theta + h) - value(theta - h)) / 2e-5 for h in step]
    gradient = value_and_gradient(theta, shapes, cosines)[1]
    np.testing.assert_allclose(gradient, differences, rtol=1e-5, atol=1e-5)


@models
@ramps
def test_independent_logs_add_up(model, ramp):
    composition, theta = parameters(model)
    logs = [Cosines.of(simulate(model, 300, "log", run), INTERVAL, ramp=ramp) for run in range(3)]
    shapes = composition.shapes(logs[0].grid)
    apart = zip(*(value_and_gradient(theta, shapes, log) for log in logs), strict=True)
    for whole, parts in zip(value_and_gradient(theta, shapes, *logs), apart, strict=True):
        np.testing.assert_allclose(whole, sum(parts), rtol=1e-9, atol=1e-9)


@models
@pytest.mark.parametrize("count", [7, 60, 101])
def test_slope_is_that_of_generalised_least_squares(model, count):
    time = INTERVAL * (np.arange(count) - (count - 1) / 2)
    sequence = simulate(model, count, "slope") + 0.7 * time
    basis = contrasts(count, False)
    inverse = np.linalg.inv(basis.T @ covariance(model, count) @ basis)
    along = basis.T @ time
    precision = along @ inverse @ along
    cosines = Cosines.of(sequence, INTERVAL, ramp=True)
    composition, theta = parameters(model)
    value, variance = slope(theta, composition.shapes(cosines.grid), cosines)
    assert value == pytest.approx(along @ inverse @ (basis.T @ sequence) / precision, rel=1e-8)
    assert variance == pytest.approx(1 / precision, rel=1e-8)


@models
@pytest.mark.parametrize("tilt", [0.0, 3.0])
def test_slope_density_makes_likelihoods_with_and_without_a_ramp_comparable(model, tilt):
    """Their sum is the dense density of the contrasts of the mean, the variance of a random slope at its best."""
    count = 60
    time = INTERVAL * (np.arange(count) - (count - 1) / 2)
    sequence = simulate(model, count, "density") + tilt * time
    basis = contrasts(count, False)
    along, plain = basis.T @ time, basis.T @ covariance(model, count) @ basis

    def density(variance):
        return multivariate_normal(None, plain + variance * np.outer(along, along)).logpdf(basis.T @ sequence)

    best = minimize_scalar(lambda power: -density(10.0**power), bounds=(-6, 3), method="bounded")  # it has one top
    cosines = Cosines.of(sequence, INTERVAL, ramp=True)
    composition, theta = parameters(model)
    shapes = composition.shapes(cosines.grid)
    added = slope_density(*slope(theta, shapes, cosines), cosines.grid)
    found = value_and_gradient(theta, shapes, cosines)[0] + added
    assert found == pytest.approx(max(density(0.0), -best.fun), abs=1e-4)
    assert found > density(0.0) - 1e-9


@settings(deadline=None, max_examples=30)
@given(st.floats(-10, 10), st.floats(-10, 10))
def test_less_a_ramp_is_without_it(tilt, taken):
    count = 5000
    time = INTERVAL * (np.arange(count) - (count - 1) / 2)
    sequence = simulate(MODELS["white"], count, "less") + tilt * time
    found = Cosines.of(sequence, INTERVAL, ramp=True).less(taken)
    expected = Cosines.of(sequence - taken * time, INTERVAL)
    assert not found.ramp
    for name in ("power", "cross"):
        scale = np.abs(getattr(expected, name)).max()
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-6 * scale)


def test_every_coefficient_is_counted_once():
    for count in (4, 129, 5000):
        grid = Grid.of(count, INTERVAL)
        assert grid.number.sum() == count - 1
        assert grid.number @ grid.index == pytest.approx(count * (count - 1) / 2)
        assert grid.leverage.sum() == pytest.approx(1 - 1 / count)  # the first sample, less its mean


def test_highest_frequency_bounds_the_grid():
    grid = Grid.of(5000, INTERVAL, 0.5)
    assert grid.frequency.max() <= 0.5
    assert grid.number.sum() == 500


def test_flicker_enters_through_its_spectrum():
    cosines = Cosines.of(simulate(WhiteNoise(0.1) + BiasInstability(1.0), 1000, "flicker"), INTERVAL)
    shapes = Composition.of(BiasInstability).shapes(cosines.grid)
    assert shapes[0] == pytest.approx(1 / (2 * np.pi * cosines.grid.frequency * INTERVAL))


@pytest.mark.parametrize("kinds", [(), (WhiteNoise, WhiteNoise)])
def test_composition_that_cannot_be_told_apart_is_refused(kinds):
    with pytest.raises(ValueError, match="likelihood: expected"):
        Composition.of(*kinds)


@pytest.mark.parametrize("sequence", [np.ones(50), np.r_[np.nan, np.arange(50.0)], np.arange(3.0)])
def test_log_without_information_is_refused(sequence):
    with pytest.raises(ValueError, match="likelihood: expected"):
        Cosines.of(sequence, INTERVAL)


def test_samples_whose_squares_are_no_numbers_count_as_constant():
    with pytest.raises(ValueError, match="expected finite samples that vary"):
        Cosines.of(1e-303 * stream(1, "small").standard_normal(300), 1.0)
