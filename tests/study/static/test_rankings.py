import numpy as np
import pandas as pd
import pytest
from scipy.stats import binomtest

from imugap.study.static.rankings import CASE, DRAWS, first_places, interval, share_interval

LEVELS = {"start": ["raw", "calibrated"], "horizon": [10, 60, 300], "quantity": ["east", "north"]}


def tables(advantage, runs=4, trials=3):
    """Errors and scores of two models; the second is better by ``advantage(run)``."""
    index = pd.MultiIndex.from_product([*LEVELS.values(), ["a", "b"], range(runs), range(trials)],
                                       names=[*LEVELS, "contender", "run", "trial"])  # fmt: skip
    errors = index.to_frame(index=False)
    better = np.array([advantage(run) for run in errors["run"]]) * (errors["contender"] == "b")
    errors["e_abs"] = 5 + 0.01 * errors["trial"] - better
    proper = errors[errors["trial"] == 0].drop(columns="trial").rename(columns={"e_abs": "crps"})
    return errors.sample(frac=1, random_state=1), proper


def count(found, score, name, start=None):
    some = found[(found["score"] == score) & (found["contender"] == name)]
    return interval(some if start is None else some[some["start"] == start])


@pytest.mark.parametrize("score", ["e_abs", "crps"])
def test_a_model_that_is_better_in_every_run_has_all_first_places_for_certain(score):
    found = first_places(*tables(lambda run: 1.0), np.random.default_rng(1))
    assert count(found, score, "b") == (12, 12, 12)
    assert count(found, score, "b", "raw") == (6, 6, 6)
    assert count(found, score, "a") == (0, 0, 0)


@pytest.mark.parametrize("score", ["e_abs", "crps"])
def test_a_lead_by_one_run_is_uncertain_in_all_nested_cases_at_once(score):
    """All cases share the runs, so that all of them change sides together."""
    advantage = {0: 6.0, 1: -1.0, 2: -1.0, 3: -1.0}
    found = first_places(*tables(advantage.get), np.random.default_rng(2))
    assert count(found, "crps", "b") == (12, 0, 12)
    assert count(found, "e_abs", "b")[0] == 0
    totals = found[(found["score"] == score) & (found["contender"] == "b")].groupby("draw")["count"].sum()
    assert set(totals) <= {0, 12}


def test_each_case_has_one_first_place_in_every_draw():
    found = first_places(*tables(lambda run: run - 1.5), np.random.default_rng(3))
    totals = found.groupby(["score", "draw", "start"])["count"].sum()
    assert (totals == 6).all()
    assert len(totals) == 2 * 2 * (DRAWS + 1)
    assert set(CASE) == set(LEVELS)


@pytest.mark.parametrize("hits", [0, 1, 17, 40])
def test_the_share_of_whole_tables_has_the_exact_binomial_interval(hits):
    assert share_interval(hits / 40, 40) == pytest.approx(tuple(binomtest(hits, 40).proportion_ci(0.95, "exact")))


def test_the_interval_of_a_share_between_two_counts_lies_between_theirs():
    (lower, upper), middle = (share_interval(hits / 40, 40) for hits in (20, 21)), share_interval(20.5 / 40, 40)
    assert all(low < one < high for low, one, high in zip(lower, middle, upper, strict=True))
