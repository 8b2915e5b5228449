import json

import numpy as np
import pandas as pd
import pytest
from scipy.stats import beta, binom

from imu_benchmark import scores as blind
from imu_benchmark.schema import FormatError
from imu_benchmark.stream import stream


def key(case, kind="single", effects=(), motion=False):
    log = {"motion": motion, "base": "white", "rate_hz": 50.0, "duration_s": 600}
    return {"case": case, "kind": kind, "effects": list(effects)} | log


def hidden(name, axes=("gyro_x",), size=10.0, **parameters):
    return {"name": name, "axes": list(axes), "parameters": parameters, "size": size}


def found(name, axes=("gyro_x",), alternatives=(), **parameters):
    others = [{"name": other, "log_score_gain": 8.0} for other in alternatives]
    known = {key: dict(zip(("value", "low", "high"), of, strict=True)) for key, of in parameters.items()}
    sure = {"p_value": 1e-4, "log_score_gain": 9.0, "alternatives": others}
    return {"name": name, "axes": list(axes), "parameters": known} | sure


PLACE = {"view": "spectrum", "axis": "gyro_x", "low": 1.0, "high": 2.0, "unit": "Hz", "p_value": 1e-3}
CLOSED = {
    "before": {"value": 9.0, "low": 8.0, "high": 10.0},
    "after": {"value": 1.1, "low": 1.0, "high": 1.2},
    "floor": {"value": 1.0, "low": 0.9, "high": 1.15},
}


def report(*effects, unexplained=(), distance=CLOSED):
    places = {"gaps": [PLACE] if effects or unexplained else [], "unexplained": list(unexplained)}
    return {"schema": "imugap/discovery/1", "effects": list(effects), "distance": distance} | places


def scored(*pairs):
    keys, reports = zip(*pairs, strict=True)
    return blind.score(keys, reports, [1.0] * len(keys))


def answer(one, other):
    return scored((one, other)).effects.iloc[0]


def test_the_right_name_on_the_right_axis_is_right():
    row = answer(key("a", effects=[hidden("sinusoid")]), report(found("sinusoid")))
    assert (row["answer"], row["top1"], row["top3"], row["axes"]) == ("sinusoid", True, True, True)


def test_the_right_name_on_another_axis_is_right_in_name_only():
    row = answer(key("a", effects=[hidden("sinusoid")]), report(found("sinusoid", ["gyro_y"])))
    assert (row["answer"], row["top1"], row["axes"]) == ("sinusoid", True, False)


@pytest.mark.parametrize(("others", "among"), [(["a", "sinusoid", "b"], True), (["a", "b", "sinusoid"], False)])
def test_the_chosen_name_and_two_alternatives_are_three(others, among):
    row = answer(key("a", effects=[hidden("sinusoid")]), report(found("quantization", alternatives=others)))
    assert (row["answer"], row["top1"], row["top3"]) == ("quantization", False, among)


def test_a_place_without_a_name_is_unknown_and_no_place_is_none():
    one = key("a", effects=[hidden("sinusoid")])
    assert answer(one, report(unexplained=[PLACE]))["answer"] == blind.UNKNOWN
    assert answer(one, report())["answer"] == blind.NONE
    assert answer(one, report() | {"gaps": [PLACE]})["answer"] == blind.UNKNOWN


def test_an_effect_named_on_an_unrelated_axis_does_not_answer():
    row = answer(key("a", effects=[hidden("sinusoid")]), report(found("rate_ramp", ["accel_x"])))
    assert row["answer"] == blind.NONE


def test_names_go_ahead_of_axes_in_the_matching_of_pairs():
    pair = [hidden("rate_ramp"), hidden("temperature")]
    matches = blind.match(pair, [found("temperature"), found("rate_ramp")])
    assert [one["name"] for one in matches] == ["rate_ramp", "temperature"]


def test_one_report_does_not_answer_two_effects():
    pair = [hidden("rate_ramp"), hidden("temperature")]
    assert [one and one["name"] for one in blind.match(pair, [found("temperature")])] == [None, "temperature"]


def test_unknown_effects_are_right_without_a_name():
    unknown = key("a", "unknown", [hidden("sweep")])
    assert answer(unknown, report(unexplained=[PLACE]))["top1"]
    assert not answer(unknown, report(found("sinusoid"), unexplained=[PLACE]))["top1"]
    assert not answer(unknown, report())["top1"]
    assert answer(unknown, report(found("sinusoid")))["name"] == blind.UNKNOWN


def test_superfluous_names_are_counted():
    scores = scored((key("a", effects=[hidden("sinusoid")]), report(found("sinusoid"), found("rate_ramp", ["gyro_y"]))))
    assert scores.cases.loc[0, ["named", "superfluous"]].tolist() == [2, 1]


def test_rates_have_the_beta_quantiles_of_clopper_and_pearson():
    found = blind.rate(pd.Series([True] * 3 + [False] * 7))
    assert found["rate"] == 0.3
    assert found["low"] == pytest.approx(beta.ppf(0.025, 3, 8))
    assert found["high"] == pytest.approx(beta.ppf(0.975, 4, 7))
    assert blind.rate(pd.Series([False] * 10))["low"] == 0
    assert blind.rate(pd.Series([], dtype=bool))["count"] == 0


@pytest.mark.parametrize("truth", [0.02, 0.1, 0.5])
def test_the_interval_of_a_rate_covers_it_at_least_as_often_as_it_says(truth):
    spans = [blind.rate(pd.Series(np.arange(30) < hits)) for hits in range(31)]
    covered = [hits for hits, span in enumerate(spans) if span["low"] <= truth <= span["high"]]
    assert 0.95 <= binom.pmf(covered, 30, truth).sum() < 0.995


def test_detection_counts_places_as_found_and_only_names_as_named():
    cases = [(key(str(n), effects=[hidden("sinusoid", size=3)]), report()) for n in range(2)]
    cases += [(key("p", effects=[hidden("sinusoid", size=3)]), report(unexplained=[PLACE]))]
    cases += [(key("q", effects=[hidden("sinusoid", size=3)]), report(found("sinusoid")))]
    cases += [(key("r", effects=[hidden("rate_ramp", size=3)]), report())]
    table = blind.detection(scored(*cases).effects).set_index(["name", "score"])
    assert table.loc[("sinusoid", "detected"), ["count", "rate"]].tolist() == [4, 0.5]
    assert table.loc[("sinusoid", "named"), ["count", "rate"]].tolist() == [4, 0.25]
    assert table.loc[(blind.ALL, "detected"), ["count", "rate"]].tolist() == [5, 0.4]


def test_false_alarms_are_names_or_places_where_nothing_is():
    quiet = [
        (key("a", "nothing"), report()),
        (key("b", "nothing"), report(found("sinusoid"))),
        (key("c", "nothing"), report(unexplained=[PLACE])),
        (key("d", effects=[hidden("sinusoid")]), report(found("sinusoid"))),
    ]
    table = blind.false_alarms(scored(*quiet).cases).set_index("alarm")
    assert table["count"].tolist() == [3, 3, 3]
    assert table["rate"].tolist() == pytest.approx([1 / 3, 1 / 3, 2 / 3])


def test_confusion_counts_every_case_once_and_ends_with_none_and_unknown():
    cases = [
        (key("a", effects=[hidden("sinusoid")]), report(found("gauss_markov"))),
        (key("b", effects=[hidden("sinusoid")]), report()),
        (key("c", "nothing"), report()),
        (key("d", "unknown", [hidden("sweep")]), report(unexplained=[PLACE])),
        (key("e", effects=[hidden("rate_ramp", size=1)]), report()),
    ]
    table = blind.confusion(scored(*cases).effects, smallest=3)
    assert list(table.columns) == list(table.index) == ["gauss_markov", "sinusoid", blind.NONE, blind.UNKNOWN]
    assert table.to_numpy().sum() == 4
    assert table.loc["sinusoid", "gauss_markov"] == table.loc["sinusoid", "none"] == 1
    assert table.loc["none", "none"] == table.loc["unknown", "unknown"] == 1


def test_naming_wants_both_names_of_a_pair_and_no_name_of_an_unknown():
    pair = [hidden("rate_ramp"), hidden("outliers", ["gyro_y"])]
    cases = [
        (key("a", "pair", pair), report(found("rate_ramp"), found("outliers", ["gyro_y"]))),
        (key("b", "pair", pair), report(found("rate_ramp"))),
        (key("c", "unknown", [hidden("sweep")]), report(found("sinusoid"))),
        (key("d", "unknown", [hidden("sweep")]), report()),
        (key("e", effects=[hidden("lever_arm", ["accel_x"])], motion=True), report(found("lever_arm", ["accel_y"]))),
        (key("f", effects=[hidden("sinusoid", size=1)]), report(found("sinusoid"))),
    ]
    table = blind.naming(scored(*cases).effects, smallest=10).set_index(["group", "score"])
    assert table.loc[("pair", "both"), ["count", "rate"]].tolist() == [2, 0.5]
    assert table.loc[("unknown", "abstained"), "rate"] == 0
    assert table.loc[("unknown", "no_name"), "rate"] == 0.5
    assert table.loc[("motion", "top1"), "rate"] == 1
    assert table.loc[("motion", "axes"), "rate"] == 0
    assert table.loc[("static", "top1"), "count"] == 0


def test_parameters_of_right_names_have_errors_in_half_widths():
    cases = [
        (key("a", effects=[hidden("sinusoid", amplitude=2.0)]), report(found("sinusoid", amplitude=(2.5, 1.5, 3.5)))),
        (key("b", effects=[hidden("sinusoid", amplitude=2.0)]), report(found("sinusoid", amplitude=(4.0, 3.0, 5.0)))),
        (key("c", effects=[hidden("sinusoid", amplitude=2.0)]), report(found("rate_ramp", amplitude=(2.0, 1.0, 3.0)))),
        (key("d", effects=[hidden("sinusoid", amplitude=2.0)]), report(found("sinusoid", other=(2.0, 1.0, 3.0)))),
    ]
    rows = scored(*cases).parameters
    assert rows["case"].tolist() == ["a", "b"]
    assert rows["error"].tolist() == [0.5, 2.0]
    table = blind.coverage(rows).set_index("name")
    assert table.loc["all", ["count", "rate", "error"]].tolist() == [2, 0.5, 1.25]


def test_wrong_answers_are_those_of_clear_effects_and_of_nothing():
    cases = [
        (key("a", effects=[hidden("sinusoid")]), report(found("sinusoid"))),
        (key("b", effects=[hidden("sinusoid")]), report(found("rate_ramp"))),
        (key("c", effects=[hidden("sinusoid", size=1)]), report()),
        (key("d", "pair", [hidden("rate_ramp"), hidden("outliers", ["gyro_y"])]), report(found("rate_ramp"))),
        (key("e", "unknown", [hidden("sweep")]), report(found("sinusoid"))),
        (key("f", "nothing"), report(unexplained=[PLACE])),
        (key("g", "nothing"), report()),
        (key("h", effects=[hidden("sinusoid")]), report(found("sinusoid"), found("outliers", ["gyro_z"]))),
        (key("i", effects=[hidden("sinusoid")]), report(found("sinusoid", ["gyro_z"]))),
    ]
    scores = scored(*cases)
    rows = blind.wrong_answers(scores, smallest=10)
    assert list(zip(rows["case"], rows["name"], rows["answer"], strict=True)) == [
        ("b", "sinusoid", "rate_ramp"), ("d", "outliers", blind.NONE), ("e", blind.UNKNOWN, "sinusoid"),
        ("f", blind.NONE, blind.UNKNOWN), ("h", "sinusoid", blind.MORE), ("i", "sinusoid", "sinusoid"),
    ]  # fmt: skip
    more = blind.superfluous_names(scores, smallest=10).set_index("group")
    assert more.loc["single", ["count", "rate"]].tolist() == [3, 1 / 3]
    assert more.loc["pair", "count"] == 0
    assert more.loc["every", ["count", "rate"]].tolist() == [9, 3 / 9]


def test_the_distance_is_closed_below_the_upper_end_of_the_floor():
    far = CLOSED | {"after": {"value": 2.0, "low": 1.9, "high": 2.1}}
    cases = [
        (key("a", effects=[hidden("sinusoid")]), report(found("sinusoid"))),
        (key("b", effects=[hidden("sinusoid")]), report(found("sinusoid"), distance=far)),
        (key("c", effects=[hidden("sinusoid", size=1)]), report(distance=far)),
    ]
    table = blind.floor_reached(scored(*cases), smallest=10).set_index(["distance", "scope"])
    for scope in (blind.ALL, blind.BEYOND):
        assert table.loc[("distance", scope), ["count", "rate"]].tolist() == [2, 0.5]
        assert table.loc[("distance", scope), "before"] == 9.0
        assert table.loc[("navigation_distance", scope), "count"] == 0


def test_keys_that_are_not_what_they_should_be_are_refused(tmp_path):
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"case": "a"}))
    with pytest.raises(FormatError, match=r"a\.json: expected the key kind; found an object with 'case'"):
        blind.read_key(path)
    one = key("a", effects=[hidden("sinusoid", amplitude=1.0)])
    path.write_text(json.dumps(one))
    assert blind.read_key(path) == one


def test_names_and_axes_of_all_effects_of_a_triple_have_to_be_right():
    three = [hidden("rate_ramp"), hidden("outliers", ["gyro_y"]), hidden("sinusoid", ["gyro_z"])]
    cases = [
        (key("a", "triple", three), report(*(found(one["name"], one["axes"]) for one in three))),
        (key("b", "triple", three), report(*(found(one["name"], one["axes"]) for one in three[:2]))),
        (key("c", "triple", [three[0] | {"size": 1.0}, *three[1:]]), report()),
    ]
    effects = scored(*cases).effects
    assert blind.whole(effects, "triple", 3, 10).to_dict() == {"a": True, "b": False}
    assert blind.confusion(effects).to_numpy().sum() == 0


def test_p_values_are_counted_up_to_each_level_by_view_and_over_all():
    p_values = pd.DataFrame({"view": ["line"] * 4 + ["mean"], "p_value": [0.005, 0.01, 0.03, 0.8, 0.4]})
    table = blind.calibration(p_values).set_index(["view", "level"])["rate"]
    assert table["line"].tolist() == [0.5, 0.75, 0.75]
    assert table["mean"].tolist() == [0, 0, 1]
    assert table[blind.ALL].tolist() == [0.4, 0.6, 0.8]


def test_uniform_p_values_are_covered_at_every_level():
    p_values = pd.DataFrame({"view": "mean", "p_value": stream(3, "uniform").random(2000)})
    table = blind.calibration(p_values)
    assert ((table["low"] < table["level"]) & (table["level"] < table["high"])).all()


def test_the_stochastic_subset_is_counted_by_name_and_by_whether_another_program_has_the_name():
    cases = [
        (key("a", effects=[hidden("random_walk")]), report(found("random_walk"))),
        (key("b", effects=[hidden("random_walk")]), report(found("gauss_markov"))),
        (key("c", effects=[hidden("sinusoid")]), report(found("sinusoid"))),
        (key("d", effects=[hidden("sinusoid", size=1)]), report()),
        (key("e", effects=[hidden("random_walk")], motion=True), report()),
        (key("f", effects=[hidden("temperature")]), report(found("temperature"))),
    ]
    table = blind.stochastic_names(scored(*cases).effects, {"random_walk": "RW"}, smallest=10).set_index("name")
    assert table["count"].to_dict() == dict.fromkeys(blind.STOCHASTIC, 0) | {
        "random_walk": 2, "sinusoid": 1, "all that it has": 2, "all that it has not": 1,
    }  # fmt: skip
    assert table.loc[["random_walk", "sinusoid"], "rate"].tolist() == [0.5, 1.0]
    assert table.loc[["random_walk", "sinusoid"], "term"].tolist() == ["RW", ""]
