import numpy as np
import pytest

from imugap.numerics.samples.contaminated_normal import tails
from imugap.stream import stream


def test_tails_of_a_mixture():
    rng = stream(5, "tails")
    hit = rng.random(50_000) < 0.004
    found = tails(rng.standard_normal(50_000) * np.where(hit, np.sqrt(1 + 6.0**2), 1.0))
    (low, high), (least, most) = found.intervals
    assert low < 0.004 < high
    assert least < 6.0 < most
    assert found.gain > 50


def test_tails_of_samples_that_others_tell_count_for_nothing():
    values = stream(5, "tails").standard_t(5, 4000)
    once, held = tails(values), tails(np.repeat(values, 8), 1 / 8)
    assert held.gain == pytest.approx(once.gain, rel=0.01)
    assert held.intervals[0] == pytest.approx(once.intervals[0], rel=0.05)
