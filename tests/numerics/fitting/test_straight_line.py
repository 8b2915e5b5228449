import numpy as np
import pytest

from imugap.numerics.fitting.straight_line import slope
from imugap.stream import stream


def test_the_slope_is_that_of_least_squares_also_far_from_the_origin():
    places = np.cumsum(stream(1, "places").integers(1, 3, 5000))
    values = 0.005 * places + 1.7e5 + 1e-4 * stream(2, "values").standard_normal(5000)
    assert slope(places, values) == pytest.approx(np.polyfit(places, values - values[0], 1)[0], rel=1e-10)
    assert slope(places, 0.25 * places) == pytest.approx(0.25, rel=1e-14)
