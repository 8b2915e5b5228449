import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.estimation.gmwm.families import family_of

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.gmwm.start import DistanceSearch, Point

LEVELS = 12


def mixture(family, squares, times=()):
    times = np.log(times)
    columns = np.hstack([family.densities, family.markov(times)]) if len(times) else family.densities
    return columns @ np.array(squares)


def nearest(family, observed):
    return DistanceSearch(family, observed, np.diag(1 / observed))


densities, times = st.floats(-2, 2), st.floats(-1.0, 2.0)


@settings(max_examples=15)
@given(st.lists(densities, min_size=4, max_size=4), times, st.floats(0.5, 2.0))
def test_wavelet_variances_of_a_member_are_reached_from_any_of_its_parameters(powers, time, apart):
    family = family_of(WhiteNoise, RandomWalk, GaussMarkov, GaussMarkov)
    observed = mixture(family, 10.0 ** np.array(powers), 10.0 ** np.array([time, time + apart]))
    path, _ = nearest(family, observed).descend_from_grid(1e-13)[0]
    assert path[-1].distance < 1e-6  # a relative 3e-4 at each level: what a million samples cannot tell


def test_density_that_is_not_needed_is_exactly_zero():
    family = family_of(WhiteNoise, RandomWalk)
    observed = mixture(family, [1.0, 0.0]) * 0.99 ** np.arange(LEVELS)  # falls faster than white noise
    (path, converged), *_ = nearest(family, observed).descend_from_grid(1e-13)
    assert converged
    assert path[-1].squares[1] == 0.0
    assert path[-1].squares[0] > 0


def test_steps_never_increase_the_distance_and_end_at_a_minimum():
    family = family_of(WhiteNoise, GaussMarkov, RandomWalk)
    wobble = 1 + 0.2 * np.sin(np.arange(LEVELS))
    problem = nearest(family, mixture(family, [1.0, 0.02, 1.0], [20.0]) * wobble)
    for path, converged in problem.descend_from_grid(1e-13):
        distances = [point.distance for point in path]
        assert converged
        assert distances == sorted(distances, reverse=True)
        around = [problem.at(path[-1].times + shift).distance for shift in (-1e-3, 1e-3)]
        assert min(around) >= distances[-1]


def test_poor_fits_converge_as_well():
    family = family_of(WhiteNoise, GaussMarkov, GaussMarkov)
    wobble = np.where(np.arange(LEVELS) % 3, 4.0, 0.3)
    problem = nearest(family, mixture(family, [1.0, 1.0, 10.0], [1.0, 50.0]) * wobble)
    path, converged = problem.descend_from_grid(1e-13)[0]
    assert converged
    assert path[-1].distance > 1
    assert len(path) < 30


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_reordering_keeps_what_is_implied(order):
    family = family_of(WhiteNoise, GaussMarkov, GaussMarkov)
    times = np.log([3.0, 1.0])
    point = Point(times, np.hstack([family.densities, family.markov(times)]), np.array([1.0, 2.0, 3.0]), 0.5)
    found = point.reordered(np.array(order))
    np.testing.assert_allclose(found.implied, point.implied)
    np.testing.assert_array_equal(found.times, times[order])
