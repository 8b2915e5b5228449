from pathlib import Path

import pandas as pd
import pytest
import yaml

from imu_benchmark import recipe
from imu_benchmark import scores as blind
from imu_benchmark.sealing import plan
from imugap.figures import blind as drawn

ROOT = Path(__file__).parents[2]


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


MIXED = [
    (key("a", effects=[hidden("sinusoid", amplitude=2.0)]), report(found("sinusoid", amplitude=(2.5, 1.5, 3.5)))),
    (key("b", effects=[hidden("rate_ramp")]), report(found("sinusoid"))),
    (key("c", effects=[hidden("rate_ramp", size=1)]), report()),
    (key("d", "nothing"), report()),
    (key("e", "unknown", [hidden("sweep")]), report(unexplained=[PLACE])),
]
QUIET = [(key("a", "nothing"), report())]


def test_detection_has_a_row_for_each_hidden_name_and_a_panel_for_all():
    rates = blind.detection(scored(*MIXED).effects)
    together, each = drawn.detection(rates, clear=10).axes
    assert (together.get_title(), each.get_title()) == ("all effects", "each effect")
    assert [label.get_text() for label in each.get_yticklabels()] == ["rate ramp", "sinusoid"]
    by_name = rates[rates["name"] != blind.ALL]
    assert [len(discs.get_offsets()) for discs in each.collections] == [
        sum(by_name["score"] == score) for score in ("detected", "named")
    ]


def test_without_a_case_of_one_effect_detection_is_a_sentence():
    (panel,) = drawn.detection(blind.detection(scored(*QUIET).effects), clear=10).axes
    assert panel.get_title() == ""
    assert panel.texts


def test_the_counts_of_the_confusion_figure_are_those_of_the_cases():
    figure = drawn.confusion(blind.confusion(scored(*MIXED).effects, smallest=10))
    (panel,) = figure.axes
    assert sorted(int(text.get_text()) for text in panel.texts) == [1, 1, 1, 1]
    assert [tick.get_text() for tick in panel.get_yticklabels()] == ["rate ramp", "sinusoid", "none", "unknown"]


@pytest.mark.parametrize("cases", [MIXED, QUIET])
def test_distances_and_errors_of_as_many_cases_as_there_are(cases):
    scores = scored(*cases)
    figure = drawn.distances(scores.cases)
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == [len(cases)] * 2
    assert [len(line.get_xdata()) for line in figure.axes[1].lines] == [0] * 2
    covered = blind.coverage(scores.parameters)
    figure = drawn.coverage(scores.parameters, covered)
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == covered["count"].tolist()


def test_p_values_rise_in_steps_to_one():
    figure = drawn.calibration(pd.DataFrame({"view": ["line", "line", "mean"], "p_value": [0.5, 0.1, 0.2]}))
    lines, mean = (panel.lines[1].get_xydata() for panel in figure.axes)
    assert lines[:, 0].tolist() == [drawn.LOWEST, 0.1, 0.5, 1.0]
    assert lines[:, 1].tolist() == [0, 0.5, 1, 1]
    assert mean[:, 1].tolist() == [0, 1, 1]


@pytest.mark.skipif(not (ROOT / "data/blind_recorded").exists(), reason="no run of the benchmark is recorded")
def test_the_recorded_run_is_of_the_cases_that_recipe_and_seed_give():
    asked = yaml.safe_load((ROOT / "workflow/config/study.yaml").read_text())["blind"]
    planned = plan(asked["seed"], asked["cases"], recipe.read())
    cases, effects = (pd.read_csv(ROOT / f"data/blind_recorded/{name}.csv") for name in ("cases", "effects"))
    columns = ["case", "kind", "motion", "base", "rate_hz", "duration_s"]
    assert cases[columns].to_numpy().tolist() == [
        [one.name, str(one.kind), one.motion != "rest", one.base, one.rate_hz, one.duration_s] for one in planned
    ]
    named = ["single", "pair"]
    hidden = [(one.name, each.name, each.size) for one in planned if one.kind in named for each in one.effects]
    found = effects.loc[effects["kind"].isin(named), ["case", "name", "size"]]
    assert list(found.itertuples(index=False, name=None)) == hidden
