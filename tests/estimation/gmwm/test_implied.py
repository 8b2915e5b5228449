import numpy as np
import pytest
from tests.estimation.gmwm.families import INTERVAL, family_of

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.estimation.variances import wavelet_variance


@pytest.mark.parametrize("width", [2, 4])
@pytest.mark.parametrize("time", [0.006, 0.07, 1.0, 33.0, 2e4])
def test_columns_of_gauss_markov_processes_are_their_wavelet_variances(width, time):
    found = family_of(GaussMarkov, width=width).markov(np.log([time, 2 * time]))
    for column, correlation_time in zip(found.T, (time, 2 * time), strict=True):
        expected = wavelet_variance.implied(GaussMarkov(1.0, correlation_time), INTERVAL, 12, width)
        np.testing.assert_allclose(column, expected, rtol=1e-9)


def test_slopes_are_those_of_the_columns():
    family, times, step = family_of(GaussMarkov), np.log([0.05, 0.4, 30.0, 900.0]), 1e-3
    below, here, above = (family.markov(times + shift) for shift in (-step, 0, step))
    values, first, second = family.slopes(times)
    np.testing.assert_array_equal(values, here)
    np.testing.assert_allclose(first, (above - below) / (2 * step), rtol=1e-5, atol=1e-9 * here.max())
    np.testing.assert_allclose(second, (above - 2 * here + below) / step**2, rtol=1e-3, atol=1e-5 * here.max())


def test_columns_of_densities_follow_the_composition():
    kinds = (WhiteNoise, Quantization, BiasInstability, RandomWalk, RateRamp)
    found = family_of(*kinds).densities
    for column, kind in zip(found.T, kinds, strict=True):
        np.testing.assert_array_equal(column, wavelet_variance.implied(kind(1.0), INTERVAL, 12))
    assert family_of(GaussMarkov).densities.shape == (12, 0)


def test_limits_of_the_correlation_time_reach_white_noise_and_a_random_walk():
    family = family_of(GaussMarkov)
    shortest, longest = family.markov(np.array(family.limits)).T
    white, walk = (wavelet_variance.implied(kind(1.0), INTERVAL, 12) for kind in (WhiteNoise, RandomWalk))
    np.testing.assert_allclose(shortest / white, shortest[0] / white[0], rtol=1e-8)
    np.testing.assert_allclose(longest / walk, longest[0] / walk[0], rtol=0.01)
