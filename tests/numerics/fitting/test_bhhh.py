"""The top of a likelihood: closed forms, from near and far, and what does nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from imugap.numerics.fitting.bhhh import maximise
from imugap.stream import stream

VALUES = 3.0 + 0.2 * stream(1, "ascent").standard_normal(500)


def normal(theta):
    """Mean, and logarithm of the standard deviation."""
    return norm.logpdf(VALUES, theta[0], np.exp(np.clip(theta[1], -20, 20)))


@given(st.floats(-20, 20), st.floats(-3, 5))
def test_mean_and_deviation_of_a_normal_sample_are_its_own(mean, log_std):
    top = maximise(normal, [[mean, log_std]])
    assert top.theta == pytest.approx([VALUES.mean(), np.log(VALUES.std())], abs=2e-3)
    assert top.log_likelihood == pytest.approx(normal([VALUES.mean(), np.log(VALUES.std())]).sum(), abs=1e-3)


def test_a_parameter_that_does_nothing_stays():
    top = maximise(lambda theta: normal(theta[:2]), [[2.5, -1.0, 7.0]])
    assert top.theta[:2] == pytest.approx([VALUES.mean(), np.log(VALUES.std())], abs=2e-3)
    assert top.theta[2] == pytest.approx(7.0, abs=1e-9)


def test_the_highest_of_several_tops_is_returned():
    def two(theta):
        return np.logaddexp(norm.logpdf(theta, 0.0, 0.1), np.log(3) + norm.logpdf(theta, 5.0, 0.1))

    assert maximise(two, [[-0.2]]).theta == pytest.approx([0.0], abs=1e-2)
    assert maximise(two, [[-0.2], [5.3]]).theta == pytest.approx([5.0], abs=1e-2)


def test_a_start_without_a_density_is_no_top():
    def broken(theta):
        return np.full(3, np.nan) if theta[0] > 5 else norm.logpdf([theta[0]] * 3)

    assert maximise(broken, [[4.9]]).theta == pytest.approx([0.0], abs=1e-2)
