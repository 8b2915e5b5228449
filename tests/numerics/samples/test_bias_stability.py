import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.chance import mean_is

from imugap.effects import Conditions, WhiteNoise
from imugap.numerics.samples.bias_stability import bias_stability, period_means
from imugap.stream import stream

SEQUENCE = np.array([1.0, 3.0, 5.0, 7.0, 2.0, 0.0])


def test_known_sequence():
    assert bias_stability(SEQUENCE[:4], 0.5, 1.0) == pytest.approx(np.sqrt(8), rel=1e-15)  # means 2, 6 about 4
    assert bias_stability(SEQUENCE, 0.5, 1.0) == pytest.approx(np.sqrt(7), rel=1e-15)  # means 2, 6, 1 about 3


def test_the_mean_is_that_of_the_run_even_where_the_last_period_is_incomplete():
    assert bias_stability(SEQUENCE[:5], 0.5, 1.0) == pytest.approx(np.sqrt(1.6**2 + 2.4**2), rel=1e-14)  # about 3.6


def test_incomplete_last_period_is_left_out():
    np.testing.assert_array_equal(period_means(SEQUENCE[:5], 0.5, 1.0), [2.0, 6.0])


@given(st.integers(20, 200), st.floats(-100, 100), st.floats(1e-6, 1e6), st.integers(1, 9))
def test_blind_to_the_offset_and_linear_in_the_scale(count, offset, scale, length):
    sequence = stream(31, count).standard_normal(count)
    period = length * 0.01
    changed = bias_stability(scale * (offset + sequence), 0.01, period)
    assert changed == pytest.approx(scale * bias_stability(sequence, 0.01, period), rel=1e-9)


@pytest.mark.parametrize("period", [0.05, 0.2, 1.0])
def test_stability_of_white_noise_is_its_floor(period):
    at, density = Conditions(0.01 * np.arange(4000), 0.01), 0.3
    runs = [WhiteNoise(density).sample(at, stream(32, period, run)) for run in range(300)]
    squares = [bias_stability(run, 0.01, period) ** 2 for run in runs]
    assert mean_is(squares, density**2 / period, share=0.02)


@pytest.mark.parametrize("period", [0.001, 0.004, 3.1, 100.0])
def test_fewer_than_two_periods_or_less_than_an_interval_is_refused(period):
    with pytest.raises(ValueError, match=r"expected at least two periods .* found a sequence of 6\.0+"):
        period_means(np.zeros(600), 0.01, period)


@pytest.mark.parametrize("interval", [0.00999, 0.01, 0.01001])
def test_the_period_is_the_nearest_whole_number_of_intervals(interval):
    assert len(period_means(np.zeros(1000), interval, 1.0)) == 10
