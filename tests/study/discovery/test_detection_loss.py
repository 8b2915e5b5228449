"""Loss of a search against the test that knows the effect: closed forms, and the estimate of the half size."""

import numpy as np
import pytest
from scipy.stats import norm

from imugap.study.discovery.detection_loss import ALPHA, Z, bonferroni_half_size, half_size, oracle_power

SIZES = np.repeat(np.geomspace(1, 4.64, 5), 6)


def test_the_test_that_knows_the_effect_finds_one_half_at_the_detection_limit():
    assert oracle_power(1.0) == pytest.approx(0.5)
    assert oracle_power(0.0) == pytest.approx(ALPHA)


def test_a_matched_filter_has_the_power_of_the_closed_form():
    rng, size = np.random.default_rng(1), 1.4
    scores = rng.normal(size * Z, 1.0, 200_000)
    share, error = np.mean(scores > Z), np.sqrt(0.25 / 200_000)
    assert abs(share - oracle_power(size)) < 4 * error


@pytest.mark.parametrize("choices", [1, 20, 180])
def test_independent_alternatives_cost_what_the_union_bound_says(choices):
    """One half is found at the half size, and at most the false-alarm probability is reached without a signal."""
    rng, trials = np.random.default_rng(choices), 20_000
    threshold = norm.isf(ALPHA / choices)
    quiet = rng.normal(size=(trials, choices)).max(axis=1) > threshold
    heard = rng.normal(bonferroni_half_size(choices) * Z, 1.0, trials) > threshold
    assert abs(heard.mean() - 0.5) < 4 * np.sqrt(0.25 / trials)
    expected = 1 - (1 - ALPHA / choices) ** choices
    assert abs(quiet.mean() - expected) < 4 * np.sqrt(expected / trials)


def test_intervals_of_the_half_size_hold_the_truth_as_often_as_they_say():
    rng, true, held = np.random.default_rng(3), 2.0, []
    for _ in range(300):
        found = rng.random(len(SIZES)) < norm.cdf(Z * (SIZES - true))
        one = half_size(SIZES, found)
        held.append(one.low <= true <= one.high)
    assert 0.90 <= np.mean(held) <= 0.99


def test_an_effect_that_is_never_found_has_no_finite_half_size():
    one = half_size(SIZES, np.zeros(len(SIZES), bool))
    assert one.value == np.inf
    assert one.high == np.inf
    assert one.low > SIZES.max()


def test_an_effect_that_is_always_found_has_a_half_size_below_all_sizes():
    one = half_size(SIZES, np.ones(len(SIZES), bool))
    assert one.high < SIZES.min() * 1.3
    assert one.low == 0.0
