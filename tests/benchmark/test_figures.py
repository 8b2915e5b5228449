from pathlib import Path

import pandas as pd
import pytest
import yaml

from imu_benchmark import recipe
from imu_benchmark import scores as blind
from imu_benchmark.sealing import plan
from imugap.figures import blind as drawn

ROOT = Path(__file__).parents[2]


EFFECTS = pd.DataFrame(
    [
        ("a", "single", False, "white", "sinusoid", 10.0, "sinusoid", True, True, True),
        ("b", "single", False, "white", "rate_ramp", 10.0, "sinusoid", False, False, True),
        ("c", "single", False, "white", "rate_ramp", 1.0, blind.NONE, False, False, False),
        ("d", "nothing", False, "white", blind.NONE, 0.0, blind.NONE, True, None, None),
        ("e", "unknown", False, "white", blind.UNKNOWN, 10.0, blind.UNKNOWN, True, None, None),
    ],
    columns=list(blind.EFFECT_COLUMNS),
)
PARAMETERS = pd.DataFrame(
    [("a", False, "sinusoid", 10.0, "amplitude", 2.0, 2.5, 1.5, 3.5, 0.5, True)], columns=list(blind.PARAMETER_COLUMNS)
)
CLOSED = {"distance_before": 9.0, "distance_after": 1.1, "distance_floor": 1.0}
CLOSED |= {"distance_floor_low": 0.9, "distance_floor_high": 1.15}
NAVIGATED = {name.replace("distance", "navigation_distance"): float("nan") for name in CLOSED}


def scored(cases):
    """Scores of some of the cases."""
    effects, parameters = (table[table["case"].isin(list(cases))] for table in (EFFECTS, PARAMETERS))
    return blind.Scores(pd.DataFrame([{"case": one} | CLOSED | NAVIGATED for one in cases]), effects, parameters)


MIXED, QUIET = "abcde", "d"


def test_detection_has_a_row_for_each_hidden_name_and_a_panel_for_all():
    rates = blind.detection(scored(MIXED).effects)
    together, each = drawn.detection(rates, clear=10).axes
    assert (together.get_title(), each.get_title()) == ("all effects", "each effect")
    assert [label.get_text() for label in each.get_yticklabels()] == ["rate ramp", "sinusoid"]
    by_name = rates[rates["name"] != blind.ALL]
    assert [len(discs.get_offsets()) for discs in each.collections] == [
        sum(by_name["score"] == score) for score in ("detected", "named")
    ]


def test_without_a_case_of_one_effect_detection_is_a_sentence():
    (panel,) = drawn.detection(blind.detection(scored(QUIET).effects), clear=10).axes
    assert panel.get_title() == ""
    assert panel.texts


def test_the_counts_of_the_confusion_figure_are_those_of_the_cases():
    figure = drawn.confusion(blind.confusion(scored(MIXED).effects, smallest=10))
    (panel,) = figure.axes
    assert sorted(int(text.get_text()) for text in panel.texts) == [1, 1, 1, 1]
    assert [tick.get_text() for tick in panel.get_yticklabels()] == ["rate ramp", "sinusoid", "none", "unknown"]


@pytest.mark.parametrize("cases", [MIXED, QUIET])
def test_distances_and_errors_of_as_many_cases_as_there_are(cases):
    scores = scored(cases)
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
