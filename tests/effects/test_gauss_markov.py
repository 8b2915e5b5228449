import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from tests.chance import mean_is
from tests.effects.simulated import PUBLISHED, draws, published, sharp_std

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.gauss_markov import FLAT_TOP


def test_gauss_markov_starts_stationary_and_stays_so():
    sequences = draws(GaussMarkov(0.7, 0.2), 3000, 60, "stationary")
    for k in (0, 1, 20, 59):
        assert sharp_std(sequences[:, k], 0.7), k


@pytest.mark.parametrize("lag", [1, 5, 20, 40])
def test_gauss_markov_correlation_decays_over_the_correlation_time(lag):
    sequences = draws(GaussMarkov(1.0, 0.2), 4000, 41, "lag")
    assert mean_is(sequences[:, 0] * sequences[:, lag], np.exp(-lag * 0.01 / 0.2))


@pytest.mark.parametrize("x", [1e-3, 0.1, 1.0, 1.89, 8.0])
def test_gauss_markov_allan_variance_is_the_quadratic_form_of_the_autocovariance(x):
    half = 800
    covariance = toeplitz(0.49 * np.exp(-x / half * np.arange(2 * half)))
    weights = np.repeat([-1.0, 1.0], half) / half
    found = weights @ covariance @ weights / 2
    assert GaussMarkov(0.7, 1.0).allan_variance(x) == pytest.approx(found, rel=1e-4)


@pytest.mark.parametrize("x", [1e-9, 1e-6, 1e-3, 9.99e-3, 1.001e-2, 2e-2])
def test_gauss_markov_allan_variance_survives_cancellation(x):
    scaled = GaussMarkov(1.0, 1.0).allan_variance(x) / (2 * x / 3)
    assert scaled == pytest.approx(1 - 0.75 * x, abs=0.36 * x**2 + 1e-12)
    assert scaled > 1 - 0.75 * x or x < 1e-6


def test_gauss_markov_allan_variance_has_no_step_where_its_series_takes_over():
    x = 1e-2 * (1 + 1e-6 * np.arange(-3, 4))
    ratio = GaussMarkov(1.0, 1.0).allan_variance(x) / x
    np.testing.assert_allclose(ratio, np.polyval(np.polyfit(x, ratio, 1), x), rtol=2e-9)


def test_gauss_markov_slopes_are_those_of_a_walk_below_and_of_white_noise_above():
    process = GaussMarkov(0.7, 10.0)
    driving = process.driving_psd
    assert process.allan_variance(1e-4) == pytest.approx(RandomWalk(np.sqrt(driving)).allan_variance(1e-4), rel=1e-4)
    assert process.allan_variance(1e6) == pytest.approx(WhiteNoise(10 * np.sqrt(driving)).allan_variance(1e6), rel=1e-4)


def test_gauss_markov_flat_top_is_the_published_one():
    process = GaussMarkov(1.0, 1.0)
    top = minimize_scalar(lambda x: -process.allan_variance(x), bounds=(0.5, 5), method="bounded")
    assert top.x == published("flat_top_tau_over_T")
    assert np.sqrt(-top.fun / process.driving_psd) == published("flat_top_deviation_over_sqrt_SB_TB")
    assert published("flat_top_tau_over_T") == FLAT_TOP


def test_accelerometer_of_the_tutorial_has_its_published_gauss_markov_process():
    value = PUBLISHED["value"]
    time = value["accel_floor_tau"] / FLAT_TOP
    process = GaussMarkov(np.sqrt(value["accel_S_B"] * time / 2), time)
    assert time == published("accel_T_B")
    assert process.driving_psd == pytest.approx(value["accel_S_B"], rel=1e-12)
    assert np.sqrt(process.allan_variance(value["accel_floor_tau"])) == published("accel_floor")


@pytest.mark.parametrize("n", [1, 3, 1000])
@pytest.mark.parametrize("ratio", [1e-12, 1e-9, 1e-5])
def test_sampled_gauss_markov_survives_cancellation_where_it_is_a_random_walk(n, ratio):
    process = GaussMarkov(1.0, 0.01 / ratio)
    walk = RandomWalk(np.sqrt(process.driving_psd))
    expected = pytest.approx(walk.sampled_allan_variance(n, 0.01), rel=2 * n * ratio + 1e-12)
    assert process.sampled_allan_variance(n, 0.01) == expected


def test_sampled_gauss_markov_has_no_step_where_its_series_take_over():
    shorter, longer = (GaussMarkov(1.0, 0.02 * (1 + k * 1e-13)) for k in (-1, 1))
    for averaging in (np.array([1]), np.array([2, 7])):
        found = [process.sampled_allan_variance(averaging, 0.01) for process in (shorter, longer)]
        np.testing.assert_allclose(*found, rtol=2e-12)
