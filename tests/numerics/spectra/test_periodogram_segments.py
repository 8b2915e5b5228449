from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import binom

from imugap.numerics.spectra.periodogram_segments import segments
from imugap.stream import stream

COUNT = 6000


def drawn(run, *bands):
    """Squared normal values whose mean is changed in bands (first, stop, factor)."""
    power = stream(5, "segments", run).standard_normal(COUNT) ** 2
    for first, stop, factor in bands:
        power[first:stop] *= factor
    return power


def test_bands_cover_everything_in_order():
    found = segments(drawn(0, (500, 700, 9.0), (3000, 3003, 80.0), (4000, 6000, 0.3)), 20)
    assert found[0][0] == 0
    assert found[-1][1] == COUNT
    assert all(one[1] == other[0] for one, other in pairwise(found))


@pytest.mark.parametrize("band", [(500, 700, 4.0), (3000, 3003, 80.0), (4000, COUNT, 0.3), (0, 40, 20.0)], ids=str)
def test_a_band_of_another_power_is_found_where_it_is(band):
    first, stop, factor = band
    a, b = min(segments(drawn(1, band), 20), key=lambda one: abs(one[0] - first) + abs(one[1] - stop))
    assert abs(a - first) <= 12
    assert abs(b - stop) <= 12
    assert abs(np.log(drawn(1, band)[a:b].mean() / factor)) < 4 * np.sqrt(2 / (b - a))


def test_noise_of_one_power_is_rarely_divided():
    divided = sum(len(segments(drawn(run), 20)) > 1 for run in range(100))
    assert binom.sf(divided - 1, 100, 0.01) > 1e-3


def test_there_are_no_more_bands_than_asked_for():
    steep = drawn(2) * np.linspace(0.01, 1, COUNT) ** 4
    assert 5 <= len(segments(steep, 7)) <= 9
    assert len(segments(steep, 1)) == 1
