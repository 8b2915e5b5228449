"""What the samples of a log hold from outside of it."""

import numpy as np
import pytest

from imugap.discovery.fit.boundary import Outside, over_time
from imugap.discovery.fit.whittle import Noise
from imugap.discovery.preparation.cosine_bins import cosine_coefficients
from imugap.effects import OutputFilter, Quantization, WhiteNoise
from imugap.stream import stream

COUNT, INTERVAL = 501, 0.02
ROUNDED = Quantization(2e-4)


def columns_and_outside(noise, root):
    """Return what is from outside, over time and as a posterior of it."""
    return over_time(noise, COUNT, INTERVAL), Outside.of(noise, COUNT, INTERVAL, root)


@pytest.mark.parametrize(
    "noise",
    [
        Noise((WhiteNoise(1e-3), ROUNDED)),
        Noise((ROUNDED,), OutputFilter(6.0, 2)),
        Noise((WhiteNoise(1e-3),), OutputFilter(6.0, 1)),
    ],
)
def test_it_is_the_same_over_time_and_in_the_basis_of_the_cosines(noise):
    over, outside = columns_and_outside(noise, np.ones(COUNT - 1))
    assert outside.columns == pytest.approx(cosine_coefficients(over), abs=1e-12)


def test_noise_that_is_nowhere_else_has_nothing_from_outside():
    assert Outside.of(Noise((WhiteNoise(1e-3),)), COUNT, INTERVAL, np.ones(COUNT - 1)) is None


def test_rounding_errors_at_the_ends_are_taken_out_as_far_as_they_are_known():
    """Their means given the samples: the errors of them are as large as their posterior says, and none is biased."""
    step, spread, rng = ROUNDED.q / INTERVAL, 4e-3, stream(3, "outside")
    over, outside = columns_and_outside(Noise((ROUNDED,)), np.full(COUNT - 1, spread))
    true = step * rng.standard_normal((4000, 2))
    seen = (true @ outside.columns.T) + spread * rng.standard_normal((4000, COUNT - 1))
    found = np.array([outside.sizes(one) for one in seen])
    left = 1 / (1 / step**2 + (1 - 1 / COUNT) / spread**2)
    assert np.mean((found - true) ** 2) / left == pytest.approx(1.0, abs=0.05)
    assert outside.without(seen[0]) == pytest.approx(cosine_coefficients(-over @ found[0]) + seen[0])


def test_what_a_filter_lets_go_of_is_taken_out_whatever_it_was():
    noise = Noise((WhiteNoise(1e-3),), OutputFilter(2.0, 2))
    outside = Outside.of(noise, COUNT, INTERVAL, np.full(COUNT - 1, 1e-3))
    noisy = 1e-3 * stream(3, "filter").standard_normal(COUNT - 1)
    for before in (0.1, -30.0):
        assert outside.sizes(before * outside.columns[:, 0] + noisy)[0] == pytest.approx(before, abs=3e-3)
