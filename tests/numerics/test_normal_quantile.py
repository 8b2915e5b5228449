import pytest
from scipy.special import ndtr, ndtri

from imugap.numerics.normal_quantile import NORMAL_QUANTILE


def test_an_interval_of_this_half_width_holds_95_percent():
    assert ndtr(NORMAL_QUANTILE) - ndtr(-NORMAL_QUANTILE) == pytest.approx(0.95, abs=1e-15)
    assert ndtri(0.975) == NORMAL_QUANTILE
