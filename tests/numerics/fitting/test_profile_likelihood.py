import numpy as np
import pytest

from imugap.numerics.fitting.profile_likelihood import end


@pytest.mark.parametrize("scale", [1e-4, 0.1, 3.0])
@pytest.mark.parametrize("bend", [-0.3, 0.0, 0.5])
def test_end_is_where_the_deviance_reaches_the_target(scale, bend):
    found = end(lambda x: (x / scale) ** 2 * (1 + bend * np.tanh(x / scale)), 3.84, scale)
    assert (found / scale) ** 2 * (1 + bend * np.tanh(found / scale)) == pytest.approx(3.84, rel=3e-3)


def test_a_poor_first_distance_does_not_matter():
    for first in (1e-3, 0.1, 2.0, 50.0):
        assert end(lambda x: x**2, 4.0, first) == pytest.approx(2.0, rel=2e-3)


def test_a_deviance_that_levels_off_below_the_target_has_no_end():
    assert end(lambda x: 3 * np.tanh(x), 3.84, 0.5, 10.0) == np.inf
    assert end(lambda x: 3 * np.tanh(x), 2.0, 0.5, 10.0) == pytest.approx(np.arctanh(2 / 3), rel=3e-3)
    assert end(lambda x: x**2, 4.0, 0.5, 1.9) == np.inf
