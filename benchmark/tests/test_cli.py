import json
import re
import shutil

import pandas as pd
import pytest

from imu_benchmark import commitments, recipe
from imu_benchmark.cli import main
from imu_benchmark.log import AXES

EMPTY = {"schema": "imugap/discovery/1", "effects": [], "unexplained": []}


def perfect(key):
    """The report that says what the key says."""
    if key["kind"] == "unknown":
        return EMPTY | {"unexplained": [{"axis": key["effects"][0]["axes"][0]}]}
    effects = [
        {
            "name": one["name"], "axes": one["axes"],
            "parameters": {
                name: {"value": value, "low": value - abs(value) - 1, "high": value + abs(value) + 1}
                for name, value in one["parameters"].items()
            },
        }
        for one in key["effects"]
    ]  # fmt: skip
    return EMPTY | {"effects": effects}


@pytest.fixture
def revealed(made, tmp_path):
    """The benchmark with its keys, and the keys."""
    public = tmp_path / "public"
    shutil.copytree(made[0], public)
    commitments.reveal(made[1], public)
    return public, commitments.read_keys(public)


def summary(public, out, *entries):
    assert main(["score", str(public), *map(str, entries), "--clear", "0", "--out", str(out)]) == 0
    return pd.read_csv(out / "summary.csv").set_index(["entry", "score"])


def test_a_perfect_answer_has_every_score_of_one_and_an_empty_one_no_false_alarm(
    revealed, write_entry, tmp_path, capsys
):
    public, keys = revealed
    right = write_entry(tmp_path / "right", {key["case"]: perfect(key) for key in keys})
    empty = write_entry(tmp_path / "empty", {key["case"]: EMPTY for key in keys})
    table = summary(public, tmp_path / "out", right, empty)
    shares = table[(table["kind"] == "share") & (table["count"] > 0)]["rate"]
    alarms = shares.index.get_level_values("score").isin(["false_name", "false_alarm"])
    assert (shares[alarms] == 0).all()
    assert (shares[~alarms]["right"] == 1).all()
    assert (shares[~alarms]["empty"] == 0).all()
    for kind in ("single_axes", "pair", "triple", "unknown", "coverage"):
        assert table.loc[("right", kind), "count"] > 0, kind
    assert ("right", "brier") not in table.index
    shown = capsys.readouterr().out
    assert shown.splitlines()[0].split() == ["score", "right", "empty"]
    assert {path.name for path in (tmp_path / "out/right").iterdir()} == {
        "cases.csv", "effects.csv", "parameters.csv", "forecasts.csv", "confusion.csv",
    }  # fmt: skip


def test_the_probabilities_of_an_entry_are_scored(revealed, write_entry, tmp_path):
    public, keys = revealed
    sure = {key["case"]: perfect(key) | {"probabilities": {"none": 1.0}} for key in keys}
    table = summary(public, tmp_path / "out", write_entry(tmp_path / "sure", sure))["rate"]["sure"]
    scores = table[["brier", "log_score", "calibration_error", "set_holds", "set_size"]]
    # a place of an unknown effect has no probabilities, and those of its report are wrong
    unknown = sum(key["kind"] == "unknown" for key in keys)
    questions = sum(max(len(key["effects"]), 1) for key in keys)
    assert scores.tolist() == pytest.approx(
        [2 * unknown / questions, scores["log_score"], unknown / questions, 1 - unknown / questions, 1.0]
    )
    assert scores["log_score"] > 0


def test_keys_are_scored_only_after_they_are_revealed(made, write_entry, tmp_path, capsys):
    public, _ = made
    entry = write_entry(tmp_path / "empty", dict.fromkeys(commitments.read_cases(public), EMPTY))
    assert main(["score", str(public), str(entry)]) == 1
    assert "keys.json: expected a file; found none" in capsys.readouterr().err


def test_spoilt_keys_and_cases_are_not_scored_and_told_in_one_line(revealed, write_entry, tmp_path, capsys):
    public, keys = revealed
    entry = write_entry(tmp_path / "empty", {key["case"]: EMPTY for key in keys})
    spoilt = json.loads((public / "keys.json").read_text())
    spoilt["keys"]["c0001"]["record"]["base"] = "flicker?"
    (public / "keys.json").write_text(json.dumps(spoilt))
    assert main(["score", str(public), str(entry)]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert "c0001: expected the digest" in told.err


def test_the_commands_of_an_organiser_and_of_an_entrant(short, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = recipe.shipped()
    for name in ("duration_s", "motion_duration_s"):
        text = text.replace(f"\n{name} = {json.dumps(recipe.read()[name])}", f"\n{name} = [40, 60]")
    (tmp_path / "short.toml").write_text(text)
    commands = (
        "make public --secret keys.json --cases 3 --recipe short.toml", "verify public",
        "baseline nothing public --out nothing", "check nothing public", "reveal keys.json public",
        "score public nothing",
    )  # fmt: skip
    for command in commands:
        assert main(command.split()) == 0, command
    shown = capsys.readouterr().out
    assert "3 cases as the manifest says" in shown
    assert "3 answers; SHA-256 " in shown
    assert "nothing hidden: a name" in shown
    assert main(["make", "public", "--secret", "other.json", "--cases", "3"]) == 1
    assert main(["baseline", "nothing", "public", "--out", "nothing"]) == 1
    assert capsys.readouterr().err.count("\n") == 2


def test_recipe_and_schema_are_printed_as_they_are_read(capsys, tmp_path):
    assert main(["recipe"]) == 0
    (tmp_path / "recipe.toml").write_text(capsys.readouterr().out)
    assert recipe.read(tmp_path / "recipe.toml") == recipe.read()
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "Answer to a case"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("sizes = [", "sizes = [-1, "), r"\.sizes\[0\]: expected more than 0; found -1"),
        (("duration_s = [600, 3600]", "duration_s = [600]"), r"\.duration_s: expected 2 or more items"),
        (("duration_s = [600, 3600]", "duration_s = [3600, 600]"), r"\.duration_s: expected a range \[low, high\]"),
        (("temperature_share", "temperature_shares"), r"expected the key(s)? .*temperature_share"),
        (("lever_arm", "lever"), r"\.confusable\[12\]: expected names of .*; found lever"),
        (("sizes = [", "sizes = "), "expected TOML"),
    ],
)
def test_a_recipe_that_is_none_is_refused_in_one_line(change, message, tmp_path, capsys):
    path = tmp_path / "recipe.toml"
    path.write_text(recipe.shipped().replace(*change, 1))
    assert main(["make", str(tmp_path / "p"), "--secret", str(tmp_path / "k"), "--recipe", str(path)]) == 1
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert re.search(message, told), told
    assert not (tmp_path / "p").exists()


def test_axes_are_those_of_the_logs(made):
    case = commitments.read_cases(made[0])[0]
    columns = pd.read_csv(next((made[0] / "cases" / case).glob("*.csv")), nrows=1).columns
    assert columns[1:7].tolist() == list(AXES)
