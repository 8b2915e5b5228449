import numpy as np
import pytest
from tests.chance import as_often_as, mean_is
from tests.effects.simulated import conditions, sharp_std

from imugap.effects import Bias, CommonMode, Conditions, GaussMarkov, Outliers, VarianceChange, WhiteNoise
from imugap.stream import stream


def test_outliers_come_with_their_probability_and_deviation():
    sequence = Outliers(0.05, 2.0).sample(conditions(100_000), stream(11, "outliers"))
    hit = sequence != 0
    assert as_often_as(hit, 0.05)
    assert sharp_std(sequence[hit], 2.0)
    assert mean_is(np.square(sequence), 0.05 * 2.0**2, share=0.03)


@pytest.mark.parametrize("probability", [0.0, 1.0])
def test_outliers_at_the_limits_of_their_probability(probability):
    hit = Outliers(probability, 1.0).sample(conditions(100), stream(1)) != 0
    assert np.all(hit == (probability == 1))


def test_variance_change_scales_the_white_noise_and_nothing_else():
    at = conditions(12_000)
    slow = GaussMarkov(7.0, 0.2) + Bias(4.0)
    model = slow + WhiteNoise(0.3) + VarianceChange(40.0, 80.0, 4.0)
    noise = model.simulate(np.zeros(12_000), at, 1) - slow.simulate(np.zeros(12_000), at, 1)
    assert sharp_std(noise[4000:8000], 2 * 0.3 / np.sqrt(0.01))
    assert sharp_std(np.r_[noise[:4000], noise[8000:]], 0.3 / np.sqrt(0.01))


def test_variance_change_includes_its_begin_and_not_its_end():
    at = Conditions(np.array([0.0, 1.0, 2.0, 3.0]), 1.0)
    np.testing.assert_array_equal(VarianceChange(1.0, 3.0, 4.0).apply(np.ones(4), at, stream(1)), [1, 2, 2, 1])


def test_a_change_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValueError, match=r"variance_change\.stop: expected a time >= start = 2\.0; found 1\.0"):
        VarianceChange(2.0, 1.0, 4.0)


def test_common_mode_takes_its_loading_with_the_sign():
    one, other = (CommonMode(0.3, loading).sample(conditions(50), stream(1)) for loading in (1.0, -2.0))
    np.testing.assert_allclose(other, -2 * one, rtol=1e-14)


def test_common_mode_is_white_noise_to_a_filter_of_one_axis():
    assert CommonMode(0.3, -0.5).state_space().output_psd == pytest.approx(0.15**2)
