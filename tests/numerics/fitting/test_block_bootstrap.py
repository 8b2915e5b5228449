import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

from imugap.numerics.fitting.block_bootstrap import FEWEST, decorrelation, mean
from imugap.stream import stream

SERIES = 150


def autoregressive(phi, count, run):
    noise = stream(4, "autoregressive", phi, run).standard_normal(count + 500)
    return lfilter([1.0], [1.0, -phi], noise)[500:]


def coverage(block):
    """Share of intervals of 95 % that hold the true mean, zero, of strongly correlated series."""
    found = [mean(autoregressive(0.9, 1000, run), stream(5, "draw", run), block) for run in range(SERIES)]
    return np.mean([one.low <= 0 <= one.high for one in found])


def test_intervals_hold_the_mean_of_a_correlated_series_and_samples_drawn_one_by_one_do_not():
    """Blocks of finite length leave some correlation out: of 1500 such series 88 % were held, not 95 %."""
    low, high = binom.ppf([0.001, 0.999], SERIES, [0.88, 0.95]) / SERIES
    assert low <= coverage(None) <= high
    assert coverage(1) < 0.5


def test_intervals_of_independent_values_have_their_level():
    held = []
    for run in range(SERIES):
        one = mean(stream(6, run).standard_normal(100), stream(7, run), block=1)
        held.append(one.low <= 0 <= one.high)
    low, high = binom.ppf([0.0005, 0.9995], SERIES, 0.945) / SERIES
    assert low <= np.mean(held) <= high


def test_the_decorrelation_grows_with_the_correlation_and_is_one_for_none():
    lags = [np.median([decorrelation(autoregressive(phi, 4000, run)) for run in range(20)]) for phi in (0.5, 0.9, 0.98)]
    assert lags == sorted(lags)
    assert decorrelation(np.tile([1.0, -1.0], 50)) == 1
    assert decorrelation(np.zeros(50)) == 1


def test_a_drift_over_the_whole_series_leaves_no_blocks_and_no_statement():
    one = mean(np.linspace(0, 1, 500), stream(8))
    assert one.blocks < FEWEST
    assert np.isinf([one.low, one.high]).all()
    assert not one.differs


def test_a_constant_difference_is_significant():
    one = mean(np.full(100, 2.5), stream(9))
    assert (one.value, one.low, one.high) == pytest.approx((2.5, 2.5, 2.5))
    assert one.differs
