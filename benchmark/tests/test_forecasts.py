import numpy as np
import pandas as pd
import pytest

from imu_benchmark import forecasts as probabilities
from imu_benchmark.answers import parse
from imu_benchmark.scores import NONE, UNKNOWN
from imu_benchmark.stream import stream

NAMES = ("white_noise", "sinusoid", "rate_ramp", NONE, UNKNOWN)


def key(case, kind="single", *names):
    effects = [{"name": name, "axes": ["gyro_x"], "parameters": {}, "size": 10.0} for name in names]
    log = {"motion": False, "base": "white", "rate_hz": 50.0, "duration_s": 600}
    return {"case": case, "kind": kind, "effects": effects} | log


def report(name=None, weights=None, place=None, case=None):
    effects = [{"name": name, "axes": ["gyro_x"], "parameters": {}}] if name else []
    if name and weights:
        effects[0]["probabilities"] = weights
    made = {"schema": "imugap/discovery/1", "effects": effects, "unexplained": [place] if place else []}
    return parse(made | ({"probabilities": case} if case else {}), "a")


def of(one, other):
    table = probabilities.forecasts([one], [other])
    return dict(zip(table["name"], table["probability"], strict=True)), table["truth"].iloc[0]


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        (key("a", "single", "sinusoid"), report("sinusoid"), ({"sinusoid": 1.0}, "sinusoid")),
        (key("a", "single", "sinusoid"), report(), ({NONE: 1.0}, "sinusoid")),
        (key("a", "single", "sinusoid"), report(place={"view": "mean"}), ({UNKNOWN: 1.0}, "sinusoid")),
        (key("a", "nothing"), report(), ({NONE: 1.0}, NONE)),
        (key("a", "nothing"), report(case={NONE: 0.9, "rate_ramp": 0.1}), ({NONE: 0.9, "rate_ramp": 0.1}, NONE)),
        (key("a", "nothing"), report("rate_ramp"), ({"rate_ramp": 1.0}, NONE)),
        (key("a", "unknown", "sweep"), report(place={"probabilities": {UNKNOWN: 1}}, case={NONE: 1}),
         ({UNKNOWN: 1.0}, UNKNOWN)),
        (key("a", "single", "sinusoid"), report("rate_ramp", {"rate_ramp": 0.6, "sinusoid": 0.4}),
         ({"rate_ramp": 0.6, "sinusoid": 0.4}, "sinusoid")),
    ],
)  # fmt: skip
def test_a_question_has_the_probabilities_of_its_answer_or_its_certainty(one, other, expected):
    assert of(one, other) == expected


def test_another_name_stands_for_every_name_that_is_not_listed():
    weights = {NONE: 0.5, probabilities.OTHER: 0.4, UNKNOWN: 0.1}
    assert of(key("a", "single", "sinusoid"), report(case=weights)) == (weights, probabilities.OTHER)
    assert of(key("a", "nothing"), report(case=weights)) == (weights, NONE)
    listed = {"sinusoid": 0.9, probabilities.OTHER: 0.1}
    assert of(key("a", "single", "sinusoid"), report(case=listed)) == (listed, "sinusoid")


def test_a_place_on_the_axis_of_the_effect_goes_ahead_of_others():
    places = [{"axis": axis, "probabilities": {name: 1.0}} for axis, name in (("gyro_y", "a"), ("gyro_x", "b"))]
    other = report() | {"withheld": places}
    assert of(key("a", "single", "sinusoid"), other) == ({"b": 1.0}, "sinusoid")
    assert of(key("a", "nothing"), other) == ({"a": 1.0}, NONE)


def test_a_pair_is_two_questions():
    table = probabilities.forecasts([key("a", "pair", "sinusoid", "rate_ramp")], [report("rate_ramp")])
    assert table["truth"].tolist() == ["sinusoid", "rate_ramp"]
    assert table["name"].tolist() == [NONE, "rate_ramp"]


def drawn(questions, sharpness, exponent=1.0):
    """Forecasts whose truth is drawn from them; what is said is their power, of one again."""
    rng = stream(3, "forecaster", sharpness)
    weights = rng.dirichlet(np.full(len(NAMES), sharpness), questions)
    truth = [NAMES[rng.choice(len(NAMES), p=one)] for one in weights]
    said = weights**exponent
    said /= said.sum(axis=1, keepdims=True)
    rows = [
        (str(number), 0, truth[number], name, said[number, place])
        for number in range(questions)
        for place, name in enumerate(NAMES)
    ]
    return pd.DataFrame(rows, columns=list(probabilities.COLUMNS)), weights


@pytest.mark.parametrize("sharpness", [0.1, 1.0, 5.0])
def test_a_calibrated_forecaster_has_the_scores_that_its_distributions_give(sharpness):
    table, weights = drawn(4000, sharpness)
    assert probabilities.calibration_error(table) < 0.03
    expected = np.mean(1 - np.sum(weights**2, axis=1))
    assert probabilities.brier_score(table) == pytest.approx(expected, abs=4 * 0.6 / np.sqrt(4000))
    entropy = -np.sum(weights * np.log(np.maximum(weights, 1e-300)), axis=1)
    assert probabilities.log_score(table) == pytest.approx(entropy.mean(), abs=4 * 1.2 / np.sqrt(4000))
    sets = probabilities.ambiguity_sets(table)
    assert sets["holds"].mean() > 0.95 - 4 * np.sqrt(0.05 * 0.95 / 4000)
    assert 1 <= sets["size"].mean() <= len(NAMES)


def test_a_forecaster_that_is_too_sure_is_told_from_a_calibrated_one():
    sure, _ = drawn(4000, 1.0, exponent=3.0)
    honest, _ = drawn(4000, 1.0)
    assert probabilities.calibration_error(sure) > 0.15
    assert probabilities.brier_score(sure) > probabilities.brier_score(honest)
    assert probabilities.log_score(sure) > probabilities.log_score(honest)
    assert probabilities.ambiguity_sets(sure)["holds"].mean() < 0.9


def test_certainties_have_the_ends_of_the_scales():
    right = probabilities.forecasts([key("a", "single", "sinusoid")], [report("sinusoid")])
    wrong = probabilities.forecasts([key("a", "single", "sinusoid")], [report("rate_ramp")])
    assert (probabilities.brier_score(right), probabilities.brier_score(wrong)) == (0.0, 2.0)
    assert probabilities.log_score(right) == 0
    assert probabilities.log_score(wrong) == pytest.approx(-np.log(probabilities.LEAST))
    assert (probabilities.calibration_error(right), probabilities.calibration_error(wrong)) == (0.0, 1.0)


def test_an_ambiguity_set_is_the_shortest_list_of_the_likeliest_that_reaches_its_probability():
    weights = {"sinusoid": 0.6, "rate_ramp": 0.35, "white_noise": 0.05}
    sets = {
        truth: probabilities.ambiguity_sets(
            probabilities.forecasts([key("a", "single", truth)], [report("sinusoid", weights)])
        ).iloc[0]
        for truth in weights
    }
    assert {one["size"] for one in sets.values()} == {2}
    assert {truth: bool(one["holds"]) for truth, one in sets.items()} == {
        "sinusoid": True, "rate_ramp": True, "white_noise": False,
    }  # fmt: skip


def test_probabilities_are_scored_only_where_some_are_stated():
    assert not probabilities.stated([report(), report("sinusoid")])
    assert probabilities.stated([report(), report("sinusoid", {"sinusoid": 1.0})])
    assert probabilities.stated([report(case={NONE: 1.0})])
    assert probabilities.stated([report(place={"probabilities": {NONE: 1.0}})])
