import numpy as np
import pytest
from scipy.stats import norm
from tests.chance import mean_is

from imugap.study.proper_scores import central_rank, energy_score


def closed_form(mean, std, came):
    """CRPS of a normal law (Gneiting and Raftery 2007, eq. 21 with the sign of a loss)."""
    z = (came - mean) / std
    return std * (z * (2 * norm.cdf(z) - 1) + 2 * norm.pdf(z) - 1 / np.sqrt(np.pi))


@pytest.mark.parametrize("came", [-1.5, 0.0, 0.4, 3.0])
def test_the_score_of_one_number_is_that_of_the_law(came):
    rng = np.random.default_rng(3)
    scores = [energy_score(0.3 + 1.2 * rng.standard_normal((20, 1)), np.array([came])) for _ in range(2000)]
    assert mean_is(scores, closed_form(0.3, 1.2, came))


def test_the_score_is_fair_and_proper():
    """Whatever the number of draws, the true law scores best in the mean."""
    rng = np.random.default_rng(4)
    scores = {shift: [] for shift in (0.0, 0.7)}
    for _ in range(3000):
        came, draws = rng.standard_normal(2), rng.standard_normal((5, 2))
        for shift, own in scores.items():
            own.append(energy_score(draws + shift, came))
    difference = np.subtract(scores[0.7], scores[0.0])
    assert difference.mean() > 4 * difference.std() / np.sqrt(len(difference))


@pytest.mark.parametrize("size", [1, 2])
def test_places_are_even_where_the_prediction_is_right(size):
    rng, count = np.random.default_rng(5), 19
    places = np.array([
        central_rank(*np.split(rng.standard_normal((count + 1, size)), [count])[:1], rng.standard_normal(size))
        for _ in range(4000)
    ])  # fmt: skip
    ranks = np.rint(places * (count + 1) - 0.5).astype(int)
    counts = np.bincount(ranks, minlength=count + 1)
    expected = len(places) / (count + 1)
    assert abs(np.sum((counts - expected) ** 2 / expected) - count) < 4 * np.sqrt(2 * count)


def test_what_is_far_off_lies_beyond_all():
    draws = np.random.default_rng(6).standard_normal((30, 2))
    assert central_rank(draws, np.array([50.0, 0.0])) > 0.9
    assert central_rank(draws, draws.mean(axis=0)) < 0.1
