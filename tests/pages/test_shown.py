"""Numbers as text: as many digits as an interval needs."""

import pytest

from imugap.pages.shown import interval_text, with_interval


@pytest.mark.parametrize(
    ("ends", "text"),
    [
        ((1.1965e-4, 1.2034e-4), "0.00011965 .. 0.00012034"),
        ((4.58e-6, 8.19e-6), "4.58e-06 .. 8.19e-06"),
        ((2.9e-5, 4e-5), "2.90e-05 .. 4.00e-05"),
        ((0.0, 3e-6), "0 .. 3.00e-06"),
        ((1.0, float("inf")), "1.00 .. inf"),
        ((5.0, 5.0), "5.00 .. 5.00"),
    ],
)
def test_an_interval_has_two_digits_of_its_half_width(ends, text):
    assert interval_text(*ends) == text


def test_a_value_has_the_digits_of_its_interval():
    assert with_interval(1.2e-4, 1.1965e-4, 1.2034e-4)[0] == "0.00012000"
