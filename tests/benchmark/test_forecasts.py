"""Test the scores of the probabilities of answers."""

import numpy as np
import pandas as pd
import pytest

from imu_benchmark.forecasts import calibration_error, calibration_errors, reliability


def answers(probabilities, right):
    """Return answers of two names to one question a case; the first name has the given probability."""
    cases = range(len(probabilities))
    first = pd.DataFrame({"case": cases, "name": "bias", "probability": probabilities})
    second = first.assign(name="sinusoid", probability=1 - first["probability"])
    truth = np.where(right, "bias", "other")
    return pd.concat([first.assign(truth=truth), second.assign(truth=truth)], ignore_index=True).assign(question=0)


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(1)
    probabilities = rng.uniform(0.55, 0.99, 200)
    return answers(probabilities, rng.uniform(size=200) < probabilities)


def test_the_calibration_error_is_the_mean_distance_of_confidence_and_rate_by_bin(table):
    bins = reliability(table)
    expected = np.average((bins["confidence"] - bins["rate"]).abs(), weights=bins["count"])
    assert calibration_error(table) == pytest.approx(expected)


def test_a_name_of_60_percent_that_is_always_right_has_a_calibration_error_of_40_percent():
    table = answers(np.full(20, 0.6), np.full(20, True))
    assert calibration_error(table) == pytest.approx(0.4)
    assert calibration_errors(table, 10, np.random.default_rng(1)) == pytest.approx(np.full(10, 0.4))


def test_resamples_spread_as_tables_do_that_are_drawn_anew(table):
    groups, rng = dict(list(table.groupby("case"))), np.random.default_rng(2)
    again = [
        calibration_error(
            pd.concat([groups[case].assign(case=place) for place, case in enumerate(drawn)], ignore_index=True)
        )
        for drawn in rng.choice(len(groups), (80, len(groups)))
    ]
    errors = calibration_errors(table, 2000, np.random.default_rng(3))
    assert np.mean(again) == pytest.approx(errors.mean(), abs=4 * errors.std() / 80**0.5)
    assert 0.75 < np.std(again) / errors.std() < 1.33
