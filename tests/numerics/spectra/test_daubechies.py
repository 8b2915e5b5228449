import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.wavelet_coefficients import by_definition

from imugap.numerics.spectra.daubechies import WIDTHS, depth, filters, free, length, squared_gain, transfer

PUBLISHED = {
    width: np.array(digits.split(), float)
    for width, digits in {
        2: "0.7071067811865475 0.7071067811865475",
        4: "0.4829629131445341 0.8365163037378077 0.2241438680420134 -0.1294095225512603",
        6: """0.3326705529500827 0.8068915093110928 0.4598775021184915 -0.1350110200102546
              -0.0854412738820267 0.0352262918857096""",
        8: """0.2303778133074431 0.7148465705484058 0.6308807679358788 -0.0279837694166834
              -0.1870348117179132 0.0308413818353661 0.0328830116666678 -0.0105974017850021""",
    }.items()
}
"""Scaling filters of extremal phase (Daubechies 1992, table 6.1; Percival & Walden 2000, table 109)."""


@pytest.mark.parametrize("width", WIDTHS)
def test_scaling_filters_are_the_published_ones(width):
    np.testing.assert_allclose(filters(width)[1] * np.sqrt(2), PUBLISHED[width], atol=2e-13)


@pytest.mark.parametrize("width", WIDTHS)
def test_filters_are_orthonormal_and_see_no_polynomial(width):
    high, low = filters(width)
    for shift in range(0, width, 2):
        for a, b, expected in ((low, low, 1), (high, high, 1), (high, low, 0), (low, high, 0)):
            assert 2 * np.dot(a[shift:], b[: width - shift]) == pytest.approx(expected * (shift == 0), abs=1e-13)
    for power in range(width // 2):
        assert np.dot(high, np.arange(width) ** power) == pytest.approx(0, abs=1e-13 * 8**power)
    assert abs(np.dot(high, np.arange(width) ** (width // 2))) > 0.1


@given(st.integers(20, 3000), st.sampled_from(WIDTHS))
def test_the_deepest_possible_level_leaves_a_coefficient_and_the_next_none(count, width):
    deepest = depth(count, width)
    assert length(deepest, width) <= count < length(deepest + 1, width)
    assert free(count, deepest, width)[-1] >= 1


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("level", [1, 2, 5])
def test_gain_and_transfer_function_are_those_of_the_filter(width, level):
    impulse = np.zeros(2 * length(level, width) - 1)
    impulse[length(level, width) - 1] = 1
    taps = by_definition(impulse, level, width)
    cycles = np.linspace(-0.5, 1.2, 23)
    response = np.exp(-2j * np.pi * np.outer(cycles, np.arange(len(taps)))) @ taps
    np.testing.assert_allclose(squared_gain(cycles, level, width), np.abs(response) ** 2, atol=1e-13)
    np.testing.assert_allclose(transfer(cycles, level, width)[-1], response, atol=1e-13)


@pytest.mark.parametrize("width", WIDTHS)
def test_gains_of_all_levels_share_out_the_power(width):
    cycles = np.linspace(0.01, 0.5, 50)
    total = sum(squared_gain(cycles, level, width) for level in range(1, 14))
    np.testing.assert_allclose(total, 1, atol=1e-5)
