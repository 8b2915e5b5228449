import numpy as np
import pytest

from imugap.numerics.spectra.band_limited import interpolate

TIME = 0.04 * np.arange(5000)


@pytest.mark.parametrize(("frequency", "least"), [(2.0, 0.99999), (6.0, 0.9999), (9.0, 0.997)])
def test_slope_of_a_line_is_whole(frequency, least):
    """Far below half the rate, and at 0.36 of the rate, where a cubic spline has three quarters of it."""
    angle = 2 * np.pi * frequency * TIME + 0.3
    inside = slice(100, -100)
    slope, true = (
        part[inside] for part in (interpolate(TIME, np.sin(angle))(TIME, 1), 2 * np.pi * frequency * np.cos(angle))
    )
    assert least < slope @ true / (true @ true) < 1.0001


def test_a_line_at_a_quarter_of_the_rate_is_itself_earlier_but_for_a_thousandth():
    line = interpolate(TIME, np.column_stack([np.sin(40 * TIME), np.cos(7 * TIME)]))
    inside = TIME[100:-100]
    expected = np.column_stack([np.sin(40 * (inside - 0.013)), np.cos(7 * (inside - 0.013))])
    np.testing.assert_allclose(line(inside - 0.013), expected, atol=1e-3)


def test_a_smooth_signal_is_met_to_its_ends():
    line, between = interpolate(TIME, np.sin(TIME)), np.linspace(0, TIME[-1], 9999)
    np.testing.assert_allclose(line(between), np.sin(between), atol=1e-6)
    np.testing.assert_allclose(line(between, 1), np.cos(between), atol=1e-4)


def test_samples_are_met_and_ends_do_not_swing():
    values = np.random.default_rng(1).standard_normal(400)
    line = interpolate(TIME[:400], values)
    np.testing.assert_allclose(line(TIME[:400]), values, atol=1e-9)
    fine = np.linspace(0, TIME[399], 4000)
    assert np.abs(line(fine)).max() < 2.5 * np.abs(values).max()


@pytest.mark.parametrize("count", [2, 3, 7])
def test_a_straight_course_of_few_samples_stays_straight(count):
    line = interpolate(TIME[:count], 3 * TIME[:count] + 1)
    np.testing.assert_allclose(line(TIME[:count], 1), 3.0)
