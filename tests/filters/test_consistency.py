import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.chance import as_often_as

from imugap.filters.consistency import nees_band, root_mean_square
from imugap.stream import stream

TRIALS = 2000


def test_mean_nees_of_a_consistent_filter_is_in_the_band_as_often_as_it_says():
    low, high = nees_band(5, 30)
    nees = np.square(stream(1, "nees").standard_normal((TRIALS, 30, 5))).sum(axis=-1).mean(axis=-1)
    assert as_often_as((low <= nees) & (nees <= high), 0.95)


@given(st.integers(1, 20), st.integers(1, 1000))
def test_band_holds_the_number_of_states_and_shrinks_with_the_runs(states, runs):
    low, high = nees_band(states, runs)
    closer = nees_band(states, 4 * runs)
    assert low < states < high
    assert closer[1] - closer[0] < high - low


def test_band_refuses_both_sides():
    low, high = nees_band(8, 100)
    assert low > 0.8 * 8
    assert high < 1.2 * 8


@pytest.mark.parametrize("shared", [0.0, 0.7])
def test_interval_holds_the_truth_as_often_as_it_says_even_if_members_of_a_run_go_together(shared):
    rng = stream(2, "interval", shared)
    common = rng.standard_normal((60, TRIALS, 1))
    errors = 3.0 * (np.sqrt(shared) * common + np.sqrt(1 - shared) * rng.standard_normal((60, TRIALS, 4)))
    value, low, high = root_mean_square(errors)
    assert value.shape == (TRIALS,)
    share = np.mean((low < 3.0) & (high > 3.0))
    assert 0.92 < share < 0.97  # the degrees of freedom are themselves estimated, from 60 runs


@given(st.floats(1e-6, 1e6))
def test_scale_of_the_errors_is_the_scale_of_the_result(scale):
    errors = stream(3, "scale").standard_normal((20, 3, 2))
    for one, scaled in zip(root_mean_square(errors), root_mean_square(scale * errors), strict=True):
        np.testing.assert_allclose(scaled, scale * one, rtol=1e-12)
