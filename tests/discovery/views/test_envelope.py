"""Global envelope: calibrated in the bulk and far out in the tail; places are read off as they should."""

import numpy as np
import pytest
from scipy.stats import binomtest

from imugap.discovery.views.curve import Curve, windows
from imugap.discovery.views.envelope import Envelope
from imugap.stream import stream

LAWS = {
    "normal": (lambda rng, shape: rng.standard_normal(shape), True),
    "skew": (lambda rng, shape: np.sqrt(2 * rng.chisquare(20, shape)) - np.sqrt(39), True),
    "gain": (lambda rng, shape: rng.gumbel(size=shape), False),
}


def p_values(name, sets=300, each=40, replicates=99, locations=60):
    draw, signed = LAWS[name]
    rng = stream(1, "envelope", name)
    found = []
    for _ in range(sets):
        envelope = Envelope(draw(rng, (replicates, locations)), signed)
        found.append(envelope.p_value(envelope.deviation(draw(rng, (each, locations))).max(axis=1)))
    return np.array(found)


@pytest.mark.parametrize("name", LAWS)
def test_p_values_are_uniform_and_so_is_their_tail(name):
    found = p_values(name)
    for level in (0.5, 0.1, 0.02):
        # curves that share replicates are dependent: the sets are the independent draws
        shares = np.mean(found <= level, axis=1)
        assert abs(shares.mean() - level) < 4 * shares.std(ddof=1) / np.sqrt(len(shares))
    interval = binomtest(int(np.sum(found <= 0.002)), found.size).proportion_ci(0.9999)
    assert interval.low < 0.002 * 1.3
    assert interval.high > 0.002 * 0.6


def test_far_deviations_get_small_probabilities():
    rng = stream(1, "envelope")
    envelope = Envelope(rng.standard_normal((99, 60)), True)
    far = np.zeros((3, 60))
    far[:, 7] = 6, 8, 12
    p = envelope.p_value(envelope.deviation(far).max(axis=1))
    assert np.all(np.diff(p) < 0)
    assert 1e-8 < p[0] < 1e-3
    assert p[2] < 1e-8


@pytest.mark.parametrize("signed", [True, False])
def test_locations_without_scatter_change_no_probability(signed):
    rng = stream(3, "envelope")
    replicates, curves = rng.standard_normal((99, 60)), 2 * rng.standard_normal((50, 60))
    alone = Envelope(replicates, signed)
    constant = np.broadcast_to(0.1 * np.arange(1, 141), (99, 140))
    beside = Envelope(np.hstack([constant, replicates]), signed)
    found = [alone.p_value(alone.deviation(curves).max(axis=1))]
    found.append(beside.p_value(beside.deviation(np.hstack([constant[:50], curves])).max(axis=1)))
    np.testing.assert_allclose(*found, rtol=1e-9)


def test_a_curve_of_which_nothing_varies_is_compared_exactly():
    envelope = Envelope(np.full((99, 8), 0.1), True)
    largest = [envelope.deviation(np.full(8, value)).max() for value in (0.1, 0.2)]
    same, other = envelope.p_value(np.array(largest))
    assert other < 1e-12 < 0.1 < same


@pytest.mark.parametrize("probability", [1e-6, 1e-3, 0.01, 0.2])
@pytest.mark.parametrize("signed", [True, False])
def test_critical_deviation_is_the_inverse_of_the_p_value(probability, signed):
    envelope = Envelope(stream(2, "envelope").standard_normal((99, 60)), signed)
    critical = envelope.critical(probability)
    assert envelope.p_value(critical) == pytest.approx(probability, rel=1e-9)


@pytest.mark.parametrize("probability", [0.3, 0.5, 0.9])
def test_critical_deviation_among_the_replicates(probability):
    envelope = Envelope(stream(2, "envelope").standard_normal((99, 60)), True)
    critical = envelope.critical(probability)
    assert envelope.p_value(critical) <= probability + 1e-12
    assert envelope.p_value(critical * (1 - 1e-9)) >= probability - 0.0101


def curve(statistic, **kwargs):
    low = np.arange(len(statistic), dtype=float)
    return Curve("view", "gyro_x", low, low + 1, "s", statistic, **kwargs)


def test_places_of_neighbours_and_of_points():
    envelope = Envelope(stream(3, "envelope").standard_normal((99, 60)), True)
    statistic = np.zeros(60)
    statistic[10:14] = 10, 20, 15, 10
    statistic[40] = -12
    assert [place[:2] for place in envelope.places(curve(statistic), 1e-3)] == [(10, 14), (40, 41)]
    assert [place[:2] for place in envelope.places(curve(statistic, point=True), 1e-3)] == [(11, 12), (40, 41)]
    assert envelope.places(curve(np.zeros(60)), 1e-3) == []


def test_small_values_of_gains_are_no_places():
    envelope = Envelope(stream(3, "envelope").gumbel(size=(99, 60)), False)
    statistic = np.zeros(60)
    statistic[5] = -50
    assert envelope.places(curve(statistic), 1e-3) == []


def test_windows_that_deviate_most_do_not_overlap():
    first, last = windows(32)
    rng = stream(4, "envelope")
    cells = rng.standard_normal((99, 32))
    total = np.concatenate([np.zeros((99, 1)), np.cumsum(cells, axis=1)], axis=1)
    envelope = Envelope((total[:, last] - total[:, first]) / np.sqrt(last - first), True)
    hidden = np.zeros(32)
    hidden[8:16], hidden[26:28] = 4.0, -6.0
    total = np.r_[0.0, np.cumsum(hidden)]
    statistic = (total[last] - total[first]) / np.sqrt(last - first)
    nested = Curve("view", "gyro_x", first.astype(float), last.astype(float), "s", statistic, windows=(first, last))
    assert [place[:2] for place in envelope.places(nested, 1e-3)] == [(8, 16), (26, 28)]


@pytest.mark.parametrize("signed", [True, False])
def test_where_no_replicate_differs_a_curve_that_does_not_either_deviates_by_nothing(signed):
    replicates = stream(1, "still").standard_normal((20, 5)) * (np.arange(5) > 3)
    envelope = Envelope(replicates, signed)
    assert not envelope.deviation(replicates[0])[:4].any()
    assert np.isfinite(envelope.maxima).all() or not signed
