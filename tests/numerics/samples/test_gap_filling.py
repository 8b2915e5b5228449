"""Lost samples drawn given all others: closed forms, and noise that does not show where they were."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import toeplitz
from scipy.signal import butter, lfilter

from imugap.numerics.samples.gap_filling import Autoregression
from imugap.stream import stream

COUNT = 20_000
WALK = Autoregression(0.0, np.array([-1.0, 1.0]), 1.0)


def noises():
    rng = stream(1, "noises")
    white = rng.standard_normal(COUNT)
    return {
        "white": white,
        "filtered": lfilter(*butter(3, 0.17), white),
        "walk": np.cumsum(white) + 3 * rng.standard_normal(COUNT),
        "line": 1e3 * np.sin(0.3 * np.arange(COUNT)) + white,
        "ramp": 0.01 * np.arange(COUNT) + white,
    }


def gaps(count=COUNT, seed=2):
    """Forty gaps of 1 to 12 samples, one of 300, and both ends."""
    rng, flawed = stream(seed, "gaps"), np.zeros(count, bool)
    for first in rng.integers(0, count, 40):
        flawed[first : first + rng.integers(1, 13)] = True
    flawed[count // 2 : count // 2 + 300] = flawed[:3] = flawed[-3:] = True
    return flawed


@pytest.mark.slow
def test_a_gap_of_a_walk_is_a_bridge_and_its_ends_are_walks():
    """Brownian bridge from 1 to 3 in 6 steps, variance k (6 - k) / 6; before and after it, the variance of a walk."""
    values = np.r_[np.zeros(3), 1.0, np.zeros(5), 3.0, np.zeros(2)]
    flawed, count = values == 0, 20_000
    rng = stream(3, "bridge")
    drawn = np.array([WALK.fill(values, flawed, rng) for _ in range(count)])
    inside = np.arange(1, 6)
    means = np.r_[np.ones(4), 1 + inside / 3, 3 * np.ones(3)]
    variances = np.r_[3, 2, 1, 0, inside * (6 - inside) / 6, 0, 1, 2]
    np.testing.assert_array_less(np.abs(drawn.mean(axis=0) - means), 4.5 * np.sqrt(variances / count) + 1e-9)
    np.testing.assert_allclose(drawn.var(axis=0), variances, rtol=4.5 * np.sqrt(2 / count))


@pytest.mark.parametrize("kind", noises())
def test_what_is_drawn_does_not_stand_out(kind):
    """What tells a sample from 32 others before it has one variance, in gaps and where none is near."""
    values, flawed = noises()[kind], gaps()
    filled = Autoregression.of(values, ~flawed).fill(values, flawed, stream(4, "fill"))
    np.testing.assert_array_equal(filled[~flawed], values[~flawed])
    whole = Autoregression.of(filled, np.ones(COUNT, bool))
    news = np.correlate(filled - whole.level, whole.whitening, "valid") / whole.std
    near = np.convolve(flawed, np.ones(len(whole.whitening)), "valid") > 0
    for part in (news[near], news[~near]):
        assert np.var(part) == pytest.approx(1.0, abs=0.05 + 4.5 * np.sqrt(2 / len(part)))
    assert np.abs(news[near]).max() < 5


@pytest.mark.slow
def test_scattered_samples_have_the_law_that_all_others_leave_them():
    """Every third sample of an autoregression of order 3, to its middle, where none tells the others, too."""
    whitening, count = np.array([0.3, -0.2, -0.5, 1.0]), 31
    response = lfilter([1.0], whitening[::-1], np.eye(1, 400)[0])
    covariance = toeplitz([response[lag:] @ response[: 400 - lag] for lag in range(count)])
    flawed = np.arange(count) % 3 == 0
    values = np.where(flawed, 0.0, np.random.default_rng(6).standard_normal(count))
    weights = covariance[np.ix_(flawed, ~flawed)] @ np.linalg.inv(covariance[np.ix_(~flawed, ~flawed)])
    means = weights @ values[~flawed]
    variances = np.diag(covariance[np.ix_(flawed, flawed)] - weights @ covariance[np.ix_(~flawed, flawed)])
    process, rng, runs = Autoregression(0.0, whitening, 1.0), stream(6, "scattered"), 20_000
    drawn = np.array([process.fill(values, flawed, rng)[flawed] for _ in range(runs)])
    np.testing.assert_array_less(np.abs(drawn.mean(axis=0) - means), 4.5 * np.sqrt(variances / runs))
    np.testing.assert_allclose(drawn.var(axis=0), variances, rtol=4.5 * np.sqrt(2 / runs))


def test_the_middle_of_a_log_with_many_flawed_samples_does_not_stand_out():
    values, flawed = noises()["white"], stream(7, "many").random(COUNT) < 0.2
    process = Autoregression.of(values, ~flawed)
    middle, rng = slice(COUNT // 2 - 50, COUNT // 2 + 50), stream(8, "many")
    drawn = np.array([process.fill(values, flawed, rng)[middle][flawed[middle]] for _ in range(40)])
    assert np.var(drawn) == pytest.approx(1.0, abs=4.5 * np.sqrt(2 / drawn.size) + 0.05)


@given(st.integers(1, 60), st.integers(0, 2**32 - 1), st.floats(0.01, 0.99))
def test_any_sequence_can_be_filled(count, seed, share):
    rng = np.random.default_rng(seed)
    values, flawed = rng.standard_normal(count), rng.random(count) < share
    flawed[rng.integers(count)] = False
    filled = Autoregression.of(values, ~flawed).fill(values, flawed, rng)
    assert np.all(np.isfinite(filled))
    np.testing.assert_array_equal(filled[~flawed], values[~flawed])


def test_equal_samples_stay_equal():
    flawed = gaps()
    filled = Autoregression.of(np.full(COUNT, 2.0), ~flawed).fill(np.full(COUNT, 2.0), flawed, stream(5, "equal"))
    np.testing.assert_allclose(filled, 2.0)


def test_innovations_are_the_noise_that_drives_an_autoregression():
    noise = stream(9, "driving").standard_normal(COUNT)
    model = Autoregression(3.0, np.array([0.5, -0.8, 1.0]), 1.0)
    values = 3.0 + lfilter([1.0], model.whitening[::-1], noise)
    innovations = model.innovations(values)
    np.testing.assert_allclose(innovations[2:], noise[2:], atol=1e-9)
    assert np.abs(innovations[:2]).max() < 5
