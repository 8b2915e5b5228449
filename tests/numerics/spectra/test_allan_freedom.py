"""Degrees of freedom of the Allan variance against the implementation of allantools, and their limits."""

import pytest
from allantools.ci import edf_greenhall

from imugap.numerics.spectra.allan_freedom import degrees_of_freedom


@pytest.mark.parametrize("exponent", [0, -1, -2])
@pytest.mark.parametrize(
    ("averaging", "count"),
    [(1, 9), (1, 10**6), (2, 50), (10, 41), (33, 10**5), (34, 120), (40, 100), (100, 1000), (1000, 2500), (999, 10**6)],
)
def test_they_are_those_of_allantools(exponent, averaging, count):
    expected = edf_greenhall(alpha=exponent, d=2, m=averaging, N=count + 1, overlapping=True)
    assert degrees_of_freedom(exponent, averaging, count) == pytest.approx(float(expected), rel=1e-9)


def test_of_one_difference_there_is_one():
    for exponent in (0, -1, -2):
        assert degrees_of_freedom(exponent, 50, 100) == pytest.approx(1.0, abs=0.02)
