from math import pi, radians, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.units import FACTORS, STANDARD_GRAVITY, factor, from_si, to_si, with_unit

units = st.sampled_from(sorted(FACTORS))


@given(units, st.floats(-1e12, 1e12))
def test_out_undoes_in(unit, value):
    assert from_si(to_si(value, unit), unit) == pytest.approx(value, rel=1e-15, abs=1e-300)


@given(units, st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_conversion_is_linear(unit, first, second):
    together = to_si(first, unit) + to_si(second, unit)
    assert to_si(first + second, unit) == pytest.approx(together, abs=1e-9 * abs(to_si(1e6, unit)))


@pytest.mark.parametrize(
    ("value", "unit", "si"),
    [
        (180.0, "deg", pi),
        (360.0, "deg/s", 2 * pi),
        (15.041067, "deg/h", 7.292115e-5),  # the Earth: NIMA TR8350.2 in rad/s, IERS in deg/h
        (1.0, "g", 9.80665),
        (1.0, "%", 0.01),
        (1.0, "m/s/sqrt(h)", 1 / 60),
        (1.0, "rad/s", 1.0),
    ],
)
def test_known_values(value, unit, si):
    assert to_si(value, unit) == pytest.approx(si, rel=1e-7)


@pytest.mark.parametrize(("small", "large", "ratio"), [("ug", "mg", 1e3), ("mg", "g", 1e3), ("deg/h", "deg/s", 3600)])
def test_a_larger_unit_is_its_multiple_of_the_smaller(small, large, ratio):
    assert from_si(to_si(1.0, large), small) == pytest.approx(ratio, rel=1e-14)


@pytest.mark.parametrize(("rate", "white"), [("deg/h", "deg/sqrt(h)")])
def test_white_noise_averaged_over_an_hour_has_its_value_per_hour(rate, white):
    assert to_si(1.0, white) / sqrt(3600) == pytest.approx(to_si(1.0, rate), rel=1e-14)


@pytest.mark.parametrize(("rate", "walk"), [(radians(1) / 3600, "deg/h/sqrt(h)"), (1 / 3600, "m/s/h/sqrt(h)")])
def test_a_random_walk_of_an_hour_has_its_value(rate, walk):
    assert to_si(1.0, walk) * sqrt(3600) == pytest.approx(rate, rel=1e-14)


def test_arrays_convert_element_by_element():
    np.testing.assert_allclose(to_si(np.array([0.0, 1.0, -2.0]), "g"), STANDARD_GRAVITY * np.array([0.0, 1.0, -2.0]))


@pytest.mark.parametrize("unit", ["", "deg/hr", "mG", "M/S"])
def test_an_unknown_unit_meets_the_known(unit):
    with pytest.raises(ValueError, match=f"unit: expected one of 1, s, .*; found '{unit}'"):
        factor(unit)


@given(units, st.floats(-1e12, 1e12).map(str))
def test_a_number_without_dimension_stands_alone_and_every_other_has_its_unit(unit, number):
    assert with_unit(number, unit).split() == ([number] if unit == "1" else [number, unit])
