"""The command walk: the folder is whole, the numbers are those of the walk, bad input is one message and no folder."""

import json
import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests import strict_json

from imugap import cli, log
from imugap.analysis.walk import INDOORS, STD, WalkInputs, navigate_walk
from imugap.commands.walk import FILES
from imugap.figures.walk import ellipse
from imugap.kinematics.strapdown import COLUMNS
from imugap.log import AXES, GYRO
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import WalkAssumptions
from imugap.simulation.walk import Walk, WalkCourse, WalkLeg
from imugap.stream import stream
from imugap.workflow.tables import measured

ROOT = Path(__file__).parents[2]
SEED = 31
STRIDES = 20


@pytest.fixture(scope="module")
def recipe():
    walk = Walk.read(ROOT / "data" / "walk.yaml")
    return replace(walk, course=WalkCourse.out_and_back(STRIDES // 2, stand_s=4.0))


@pytest.fixture(scope="module")
def files(tmp_path_factory, recipe):
    """A walk, its model, and a walk without the stand."""
    folder = tmp_path_factory.mktemp("walk")
    record = recipe.record(1, SEED)
    log.write(record, folder / "walk.csv")
    log.write(record.loc[4.3:], folder / "late.parquet")
    log.write(record[(record.index < 7.001) | (record.index > 7.501)], folder / "gap.csv")
    recipe.model.write(folder / "device.yaml")
    (folder / "empty.yaml").write_text("{}")
    (folder / "one.yaml").write_text("gyro_x: [{white_noise: {density: 1e-4}}]")
    (folder / "huge.yaml").write_text("gyro_x: [{white_noise: {density: 1.0e+160}}]")
    return folder


@pytest.mark.parametrize("model", [(), pytest.param(("--model", "device.yaml"), marks=pytest.mark.slow)])
def test_the_folder_is_whole_and_says_how_far_the_walk_went_and_where_it_ended(here, recipe, capsys, model):
    assert cli.main(["walk", "walk.csv", *model, "--gravity", str(recipe.site.gravity), "--out", "found"]) == 0
    assert {path.name for path in Path("found").iterdir()} == set(FILES)
    given = strict_json.load("found/inputs.json")
    assert [(one["role"], one["path"]) for one in given] == [
        ("log", "walk.csv"),
        *([("model", model[1])] if model else []),
    ]
    assert [one["sha256"] for one in given] == [sha256(Path(one["path"]).read_bytes()).hexdigest() for one in given]
    found = strict_json.load("found/summary.json")
    out = capsys.readouterr().out
    assert out.startswith(f"The walk went {found['distance_m']:.2f} m in {found['strides']} strides")
    assert out.endswith("More: found/report.html\n")
    assert len(out.splitlines()) < 15
    lengths = pd.read_csv("found/strides.csv")["length"]
    page = Path("found/report.html").read_text()
    assert f"Median stride: {lengths.median():.3g} m in " in page
    assert f"± {measured(found['end_horizontal_m'], found['end_horizontal_m' + STD])[1]} m from where it began" in page
    assert found["strides"] == STRIDES
    assert re.search(r"<td[^>]*>\d\.\d{3} ± 0\.\d{3}</td>", page)
    assert found["duration_s"] == pytest.approx(recipe.duration_s, abs=0.01)
    assert abs(found["distance_m"] - STRIDES * recipe.gait.length_m) < 3 * found["distance_m_std"] < 1.0
    assert found["end_horizontal_m"] < 3 * found["end_horizontal_m_std"]
    assert abs(found["end_vertical_m"]) < 3 * found["end_vertical_m_std"]
    assert abs(found["end_heading_deg"]) < 3 * found["end_heading_deg_std"]
    assert {name for name in found if not name.endswith(STD)} == {
        name.removesuffix(STD) for name in found if name.endswith(STD)
    }
    table = pd.read_parquet("found/solution.parquet")
    assert set(COLUMNS) | {name + STD for name in COLUMNS} | {"stance"} < set(table.columns)
    assert np.hypot(*table[["north", "east"]].iloc[-1]) == pytest.approx(found["end_horizontal_m"])
    assert not table.isna().any().any()


def test_pace_and_strides_are_those_of_the_gait_at_any_epoch(recipe):
    """Straight strides: speed and cadence of the recipe, and the time without stands; no epoch in a table."""
    straight = replace(recipe, course=WalkCourse(4.0, (WalkLeg(STRIDES),), 3.0))
    record = straight.record(1, SEED)
    late = record.set_index(pd.Index(record.index + 1274437206.0, name="time"))
    found, other = (navigate_walk(WalkInputs(one, recipe.model)) for one in (record, late))
    gait, summary = recipe.gait, found.summary()
    assert summary["speed_m_per_s"] == pytest.approx(gait.length_m / gait.stride_s, rel=0.01)
    assert summary["cadence_per_min"] == pytest.approx(60 / gait.stride_s, rel=0.01)
    assert summary["walking_s"] == pytest.approx(STRIDES * gait.stride_s, abs=1.0)
    assert summary["duration_s"] == pytest.approx(straight.duration_s, abs=0.01)
    assert list(found.strides()["stride"]) == list(range(1, STRIDES + 1))
    np.testing.assert_allclose(other.strides(), found.strides(), atol=1e-3)
    assert other.strides()["end"].max() < straight.duration_s


def test_the_bias_of_another_run_is_no_knowledge_and_a_wrong_model_is_said(here, recipe, capsys):
    """A model with biases alone begins at zero and errs no more than it says; one of small spread is contradicted."""
    other = {axis: [{"white_noise": {"density": 3e-4}}, {"bias": {"value": 0.02}}] for axis in AXES}
    ErrorModel.from_mapping(other).write("other.yaml")
    narrow = {axis: [*one, {"turn_on_bias": {"std": 1e-4}}] for axis, one in other.items()}
    ErrorModel.from_mapping(narrow).write("narrow.yaml")
    given = ["--gravity", str(recipe.site.gravity), "--out", "found"]
    assert cli.main(["walk", "walk.csv", "--model", "other.yaml", *given]) == 0
    said, found = capsys.readouterr().err, strict_json.load("found/summary.json")
    assert "other.yaml: no turn-on bias of gyro_x, gyro_y, gyro_z, accel_x" in said
    assert "the model of another device?" not in said
    assert found["end_horizontal_m"] < 3 * found["end_horizontal_m_std"]
    assert cli.main(["walk", "walk.csv", "--model", "narrow.yaml", *given]) == 0
    assert "rad/s off" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("assumptions", [WalkAssumptions(), INDOORS])
def test_height_is_up_and_the_heading_in_degrees(recipe, assumptions):
    """Stairs: a foot that goes up three metres and turns by 90 degrees ends there, whatever is assumed of floors."""
    legs = tuple(replace(leg, rise_m=0.15, turn_deg=90 / 20) for leg in WalkCourse.loop(20).legs)
    stairs = replace(recipe, course=WalkCourse(4.0, legs, 2.0))
    assumptions = replace(assumptions, gravity=recipe.site.gravity)
    found = navigate_walk(WalkInputs(stairs.record(2, SEED), recipe.model, assumptions)).summary()
    assert found["end_vertical_m"] == pytest.approx(3.0, abs=3 * found["end_vertical_m_std"])
    assert found["end_vertical_m_std"] < 0.5
    assert found["end_heading_deg"] == pytest.approx(90, abs=3 * found["end_heading_deg_std"])


def test_a_walk_that_begins_in_motion_is_navigated_where_its_heading_is_free(here, recipe):
    """It goes as far as from the stand, and is said to be less sure."""
    gravity, found = str(recipe.site.gravity), []
    for name, option in (("walk.csv", []), ("late.parquet", ["--heading-free"])):
        assert cli.main(["walk", name, *option, "--gravity", gravity, "--out", "free"]) == 0
        found.append(strict_json.load("free/summary.json"))
    assert abs(found[1]["distance_m"] - found[0]["distance_m"]) < 1.5
    for name in ("distance_m", "end_heading_deg", "end_vertical_m"):
        assert found[1][name + STD] > found[0][name + STD]


def test_all_facts_are_printed_as_json(here, recipe, capsys):
    gravity = str(recipe.site.gravity)
    assert cli.main(["walk", "walk.csv", "--gravity", gravity, "--json", "--out", "found"]) == 0
    assert json.loads(capsys.readouterr().out) == strict_json.load("found/summary.json")


def test_outdoors_nothing_is_taken_for_level(here, recipe):
    stds = []
    for option in ([], ["--outdoors"]):
        assert cli.main(["walk", "walk.csv", *option, "--gravity", str(recipe.site.gravity), "--out", "found"]) == 0
        stds.append(strict_json.load("found/summary.json")["end_vertical_m" + STD])
        assert ("floor" in pd.read_parquet("found/solution.parquet")) == (not option)
    assert stds[0] < 0.5 * stds[1]


@pytest.mark.slow
def test_near_the_full_scale_samples_are_doubted(here, recipe):
    stds = []
    for option in ([], ["--full-scale", "1.5"], ["--full-scale", "1000"]):
        assert cli.main(["walk", "walk.csv", *option, "--gravity", str(recipe.site.gravity), "--out", "found"]) == 0
        stds.append(strict_json.load("found/summary.json")["end_horizontal_m" + STD])
    assert stds[1] > 1.05 * stds[0]
    assert stds[2] == stds[0]
    with pytest.raises(SystemExit, match="2"):
        cli.main(["walk", "walk.csv", "--full-scale", "0", "--out", "none"])


@pytest.mark.slow
def test_rows_that_come_twice_are_left_out(here, recipe):
    record = pd.read_csv("walk.csv")
    twice = record.loc[np.repeat(record.index, np.where(record.index % 500 == 7, 2, 1))]
    twice.to_csv("twice.csv", index=False)
    for name in ("walk", "twice"):
        assert cli.main(["walk", f"{name}.csv", "--gravity", str(recipe.site.gravity), "--out", name]) == 0
    assert strict_json.load("twice/summary.json") == strict_json.load("walk/summary.json")


def test_lost_samples_are_filled(recipe):
    record = recipe.record(1, SEED)
    lost = stream(SEED, "lost").choice(np.arange(1, len(record) - 1), len(record) // 50, replace=False)
    whole, holes = (
        navigate_walk(WalkInputs(some, recipe.model)).smoothed for some in (record, record.drop(record.index[lost]))
    )
    assert len(holes.trajectory) == len(record)
    ends = [one.trajectory[["north", "east", "down"]].iloc[-1] for one in (whole, holes)]
    assert (ends[0] - ends[1]).abs().max() < whole.trajectory_std[["north", "east", "down"]].iloc[-1].max()


FAULTS = {
    "late.parquet": r"late.parquet: walk: expected a stand of 0.2 s or more at the start \(or --heading-free\); found",
    "gap.csv": "gap.csv: walk: expected gaps of at most 0.1 s; found 0.505 s, 6.995 s after the begin",
    "none.csv": "none.csv",
    "walk.csv --model none.yaml": "none.yaml",
    "walk.csv --model empty.yaml": "empty.yaml: expected a model of at least one axis; found none",
    "walk.csv --model one.yaml": "one.yaml: expected a model of all of gyro_x, .*; found none of gyro_y, .*, accel_z",
    "walk.csv --model huge.yaml": r"huge.yaml: gyro_x: .* in \[1e-30, 1e\+12\]; found 1e\+160",
}


@pytest.mark.parametrize(("arguments", "message"), FAULTS.items(), ids=FAULTS)
def test_bad_input_is_one_message_and_leaves_nothing(refused, arguments, message):
    refused(f"walk {arguments} --out found", message)


def test_a_figure_that_fails_leaves_no_folder(here, fill_disk):
    fill_disk()
    assert cli.main(["walk", "walk.csv", "--out", "found"]) == 1
    assert not Path("found").exists() or not any(Path("found").iterdir())


def test_the_ellipse_holds_as_much_as_it_says():
    covariance = np.array([[4.0, 1.5], [1.5, 1.0]])
    points = stream(SEED, "ellipse").multivariate_normal([1, 2], covariance, 20_000) - [1, 2]
    edge = ellipse(np.zeros(2), covariance, 0.9)
    limit = np.einsum("ni,ij,nj->n", edge, np.linalg.inv(covariance), edge)
    np.testing.assert_allclose(limit, limit[0])
    inside = np.einsum("ni,ij,nj->n", points, np.linalg.inv(covariance), points) < limit[0]
    assert abs(inside.mean() - 0.9) < 4 * np.sqrt(0.09 / 20_000)


def test_the_folder_says_what_was_recognised_in_the_log(here, recipe, capsys):
    record = recipe.record(1, SEED)
    other = record.assign(**{axis: np.degrees(record[axis]) for axis in GYRO})
    other.rename(columns={axis: f"{axis} (deg/s)" for axis in GYRO}).to_csv("other.csv")
    assert cli.main(["walk", "other.csv", "--gravity", str(recipe.site.gravity), "--out", "found"]) == 0
    (file,) = strict_json.load("found/inputs.json")
    assert "gyro deg/s -> rad/s from the header" in file["recognised"]
    assert f"other.csv: {', '.join(file['recognised'])}" in capsys.readouterr().err
