import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm
from tests.chance import as_often_as, mean_is
from tests.effects.simulated import conditions, inputs

from imugap.effects import (
    Resolution,
    Saturation,
    ScaleFactor,
    StabilityRestoration,
    StuckSamples,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.numerics.samples.bias_stability import bias_stability
from imugap.stream import stream


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=20), st.floats(1e-3, 10))
def test_resolution_goes_to_the_nearest_point_of_the_lattice_and_stays_there(values, step):
    values = np.array(values)
    rounded = Resolution(step).apply(values, conditions(len(values)), stream(1))
    assert np.all(np.abs(rounded - values) <= step / 2 * (1 + 1e-9))
    np.testing.assert_allclose(rounded / step, np.rint(rounded / step), atol=1e-9)
    np.testing.assert_array_equal(Resolution(step).apply(rounded, conditions(len(values)), stream(1)), rounded)


def test_resolution_adds_the_variance_of_a_uniform_law():
    values = stream(3, "resolution").uniform(-50, 50, 20_000)
    errors = Resolution(0.4).apply(values, conditions(len(values)), stream(1)) - values
    assert mean_is(errors**2, 0.4**2 / 12, share=0.03)


@given(st.integers(30, 400), st.floats(1e-6, 1e3), st.floats(-10, 10))
def test_restoration_gives_the_sequence_its_stability_and_keeps_its_mean(count, stability, offset):
    sequence = offset + stream(5, count).standard_normal(count)
    restored = StabilityRestoration(stability, 0.1).apply(sequence, conditions(count), stream(1))
    assert bias_stability(restored, 0.01, 0.1) == pytest.approx(stability, rel=1e-9)
    assert restored.mean() == pytest.approx(sequence.mean(), abs=1e-9 * max(stability * 100, 10))


def test_restoration_of_a_constant_sequence_is_refused():
    with pytest.raises(ValueError, match="stability"):
        StabilityRestoration(1e-5, 1.0).apply(np.zeros(1000), conditions(1000), stream(1))


def test_saturation_puts_the_tails_on_its_limits_and_leaves_the_rest():
    values = stream(11, "saturation").standard_normal(50_000)
    clipped = Saturation(1.5).apply(values, conditions(len(values)), stream(1))
    assert as_often_as(clipped == 1.5, norm.sf(1.5))
    assert as_often_as(clipped == -1.5, norm.sf(1.5))
    within = np.abs(values) < 1.5
    np.testing.assert_array_equal(clipped[within], values[within])
    variance = 1 - 2 * (1.5 * norm.pdf(1.5) + norm.sf(1.5)) + 2 * 1.5**2 * norm.sf(1.5)
    assert mean_is(clipped**2, variance, share=0.03)


def test_stuck_samples_repeat_the_last_value_for_their_length():
    values = stream(11, "stuck").standard_normal(100_000)
    stuck = StuckSamples(0.02, 5.0).apply(values, conditions(len(values)), stream(12, "stuck"))
    repeated = np.r_[False, np.diff(stuck) == 0]
    np.testing.assert_array_equal(stuck[~repeated], values[~repeated])
    begins = repeated[1:] & ~repeated[:-1]
    assert as_often_as(begins[~repeated[:-1]], 0.02)
    assert as_often_as(~repeated[1:][repeated[:-1]], 1 / 5.0)


def test_certainly_stuck_samples_repeat_every_other_value():
    stuck = StuckSamples(1.0, 1.0).apply(np.arange(5.0), conditions(5), stream(1))
    np.testing.assert_array_equal(stuck, [0, 0, 2, 2, 4])


def test_two_samples_of_no_lattice_at_one_extreme_are_a_full_scale():
    """Equal to the last digit at two times; rounded to a lattice, two of many tell nothing."""
    noise, at = stream(8, "noise").standard_normal(5000), conditions(5000)
    clipped = np.minimum(noise, np.sort(noise)[-2])
    assert Saturation.found(clipped, at).effect.limit == clipped.max()
    assert Saturation.found(np.round(clipped, 2), at) is None


def test_a_single_flat_top_is_a_full_scale_and_a_flat_slope_is_stuck():
    """A smooth motion that is clipped once, and one whose output sticks on its way up."""
    time = np.arange(20_000) * 0.01
    motion = np.sin(0.2 * time) + 0.3 * np.sin(1.3 * time) + 1e-3 * stream(12, "flat").standard_normal(len(time))
    clipped = np.minimum(motion, np.sort(motion)[-6])
    stuck = motion.copy()
    stuck[5001:5006] = stuck[5000]
    place = conditions(len(time))
    assert Saturation.found(clipped, place).effect.limit == clipped.max()
    assert Saturation.found(stuck, place) is None
    assert StuckSamples.found(stuck, place) is not None


@pytest.mark.parametrize("sign", [1, -1])
def test_a_full_scale_that_one_side_shows_holds_where_the_other_reaches_it_once(sign):
    """A smooth motion with several peaks above the full scale, and a single one below it, which could be stuck."""
    time = np.arange(20_000) * 0.01
    noise = 1e-3 * stream(12, "flat").standard_normal(len(time))
    motion = 0.35 + np.sin(0.35 * time) - 0.8 * np.exp(-(((time - 100.0) / 3) ** 2)) + noise
    clipped = sign * np.clip(motion, -0.7, 0.7)
    found = Saturation.found(clipped, conditions(len(time)))
    np.testing.assert_array_equal(found.flawed, np.abs(clipped) == 0.7)
    below = np.flatnonzero(sign * clipped == -0.7)
    assert len(below) > 5
    assert np.ptp(below) == len(below) - 1


def test_equal_ends_on_both_sides_are_a_full_scale():
    """One stay at either end, each of which alone could be stuck; at two places one magnitude to the last digit."""
    time = np.arange(20_000) * 0.01
    noise = 1e-3 * stream(12, "flat").standard_normal(len(time))
    swing = np.sin(0.11 * time) * np.where(np.abs(time - 100) < 55, 1.0, 0.5) + noise
    found = Saturation.found(np.clip(swing, -0.999, 0.999), conditions(len(time)))
    assert found.effect.limit == 0.999
    assert {-0.999, 0.999} == set(np.clip(swing, -0.999, 0.999)[found.flawed])


@pytest.mark.parametrize("effects", [(), (ScaleFactor(0.02, -0.01, 0.01),)])
def test_one_sample_that_falls_short_of_a_known_motion_is_clipped_and_a_lone_outlier_is_not(effects):
    """A motion so rough that a single sample is beyond the full scale, by a sixth of the input."""
    count = 6000
    rough = stream(13, "rough").standard_normal(count)
    largest = int(np.argmax(np.abs(rough)))
    rough[largest] *= 1.2
    place = inputs("gyro_z", gyro_z=rough)
    values = AxisModel((WhiteNoise(1e-4), *effects)).simulate(rough, place, 1, "short")
    assert Saturation.found(values, place) is None
    clipped = np.clip(values, *(side * 0.85 * abs(values[largest]) for side in (-1, 1)))
    found = Saturation.found(clipped, place)
    assert np.flatnonzero(found.flawed) == [largest]
    assert found.effect.limit == np.abs(clipped).max()
    assert found.log_p < np.log(1e-4)
    for where in (largest - 1, int(np.argsort(np.abs(rough))[-2])):
        outlier = values.copy()
        outlier[where] -= 0.1 * np.sign(rough[where])
        assert Saturation.found(outlier, place) is None


@pytest.mark.parametrize("place", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("step", [0.3, 1.0, 2.0, 3.0])
def test_rounded_normal_values_tell_mean_and_deviation_of_those_ahead(step, place):
    lattice, mean, std, count = Resolution(step), (7 + place) * step, 1.0, 200_000
    rounded = step * np.rint((mean + std * stream(9, "rounded", step, place).standard_normal(count)) / step)
    expected = lattice.moments(mean, std)
    assert rounded.mean() == pytest.approx(expected[0], abs=5 * np.sqrt(expected[1] / count))
    assert rounded.var() == pytest.approx(expected[1], rel=0.02)
    assert lattice.mean_ahead(expected[0], std) == pytest.approx(mean, abs=1e-6 * step)
    assert lattice.std_ahead(*expected) == pytest.approx(std, rel=0.02)


def test_a_mean_far_beyond_the_step_is_that_ahead_of_the_rounding():
    assert Resolution(1e-3).mean_ahead(1e15, 3e-4) == 1e15
