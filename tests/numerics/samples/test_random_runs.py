import numpy as np
import pytest
from scipy.stats import binom, norm

from imugap.numerics.samples.random_runs import simulate_runs
from imugap.stream import stream

CASES = [(0.02, 5.0), (0.3, 1.0), (0.5, 20.0), (1.0, 2.0)]


def lengths(inside):
    """Lengths of the stretches that begin and end within the samples."""
    edges = np.flatnonzero(np.diff(inside.astype(int)))
    edges = edges[: len(edges) // 2 * 2]  # the first sample is free, so stretches begin at even edges
    return edges[1::2] - edges[::2]


def within(values, mean, std, alpha=1e-4):
    """Whether the mean of independent values agrees with the truth, two-sided."""
    return abs(values.mean() - mean) < norm.isf(alpha / 2) * std / np.sqrt(len(values))


@pytest.mark.parametrize(("probability", "length"), CASES)
def test_lengths_are_geometric(probability, length):
    found = lengths(simulate_runs(200_000, probability, length, stream(1, "length", probability)))
    assert len(found) > 1000
    assert within(found, length, np.sqrt(length * (length - 1)) + 1e-9)
    assert within((found == 1).astype(float), 1 / length, np.sqrt((1 - 1 / length) / length) + 1e-9)


@pytest.mark.parametrize(("probability", "length"), CASES)
def test_a_stretch_begins_with_its_probability_after_a_free_sample(probability, length):
    inside = simulate_runs(200_000, probability, length, stream(1, "begin", probability))
    free = ~inside[:-1]
    low, high = binom.ppf([5e-5, 1 - 5e-5], free.sum(), probability)
    assert low <= np.sum(free & inside[1:]) <= high


def test_the_share_of_samples_inside_is_that_of_the_chain():
    shares = np.array([simulate_runs(5000, 0.02, 5.0, stream(1, "share", run)).mean() for run in range(400)])
    expected = 0.02 / (0.02 + 1 / 5.0)
    assert abs(shares.mean() - expected) < 4 * shares.std(ddof=1) / np.sqrt(len(shares)) + 5 / 5000  # of the start
    assert shares.std(ddof=1) / np.sqrt(len(shares)) < 0.02 * expected


def test_certain_stretches_of_one_sample_alternate():
    np.testing.assert_array_equal(simulate_runs(7, 1.0, 1.0, stream(1)), [0, 1, 0, 1, 0, 1, 0])


@pytest.mark.parametrize(("probability", "length"), [(0.0, 3.0), (1e-300, 1e300), (1.0, 1e300), (1.0, 1.0)])
@pytest.mark.parametrize("count", [1, 2, 1000])
def test_the_first_sample_is_free_at_the_limits_too(probability, length, count):
    inside = simulate_runs(count, probability, length, stream(1))
    assert inside.shape == (count,)
    assert not inside[0]
    assert inside[1:].any() == (probability == 1 and count > 1)
