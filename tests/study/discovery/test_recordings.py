"""Recordings of devices that took no part in building the method."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from imugap import log
from imugap.io import configuration, recording
from imugap.io.catalogue.datasets import LOG, POSES
from imugap.stream import stream
from imugap.study.discovery.recordings import RecordingRecipe, properties

ROOT = Path(__file__).parents[3]
SCHEMAS = ROOT / "workflow" / "schemas"


@pytest.fixture(scope="module")
def recipes():
    """The recipes of the study, as plain data."""
    return configuration.read(ROOT / "data" / "recordings.yaml", SCHEMAS / "recordings.schema.yaml")


def at_rest(count=6000, rate=100.0):
    """A device at rest: white noise on six axes, and gravity."""
    noise = stream(1, "at rest").normal(size=(6, count))
    scales = [1e-3] * 3 + [1e-2] * 3
    values = dict(zip(log.AXES, noise * np.array(scales)[:, None], strict=True))
    values["accel_z"] -= 9.81
    return log.from_samples(values, 1 / rate)


def test_every_recipe_has_its_file_and_can_be_chosen(recipes, sets):
    schema = yaml.safe_load((SCHEMAS / "study.schema.yaml").read_text())
    chosen = schema["properties"]["discovery"]["properties"]["recordings"]
    devices = configuration.read(ROOT / "data" / "devices.yaml", SCHEMAS / "devices.schema.yaml")
    of_devices = {one["recording"] for one in devices.values() if "recording" in one}
    of_study = [name for name, one in recipes.items() if sets[one["dataset"]].kind == "recording"]
    assert chosen["items"]["enum"] == chosen["default"] == of_study
    assert of_devices | set(of_study) == set(recipes)
    for one in map(RecordingRecipe.from_mapping, recipes.values()):
        assert all(sets[one.dataset].file(one.run, content) for content in (LOG, *([POSES] if one.moving else [])))


def test_a_stretch_is_cut_by_the_time_since_the_first_stamp(tmp_path):
    table = at_rest()
    table.index += 5.0
    log.write(table, tmp_path / "log.csv")
    given = {"title": "device", "dataset": "set", "run": 1, "begin_s": 10, "end_s": 40}
    recipe = RecordingRecipe.from_mapping(given | {"reading": {"columns": [], "units": []}})
    found = recipe.read(tmp_path / "log.csv").table
    assert (found.index[0], found.index[-1]) == pytest.approx((15.0, 44.99))
    assert not recipe.moving


def test_what_the_file_cannot_say_is_in_the_recipe(tmp_path):
    np.save(tmp_path / "axis.npy", 2 * stream(2, "axis").normal(size=2000))
    given = {"title": "axis", "dataset": "set", "run": 1, "begin_s": 0}
    reading = {"columns": ["gyro_x"], "units": ["gyro=deg/s"], "rate_hz": 50}
    found = RecordingRecipe.from_mapping(given | {"reading": reading}).read(tmp_path / "axis.npy")
    assert 1 / found.regular.interval == pytest.approx(50)
    assert np.std(found.table["gyro_x"]) == pytest.approx(np.radians(2), rel=0.1)


def test_a_row_without_power_and_a_knock_are_left_out():
    table = at_rest()
    table.iloc[0] = 0.0
    table.iloc[3000] += 200 * np.array([1e-3] * 3 + [1e-2] * 3)
    known = properties(recording.of_table(table.reset_index()))
    assert not known["in_motion"]
    assert known["rate_hz"] == pytest.approx(100)
    assert any("zero on all axes" in one for one in known["left_out"])
    assert len(known["shocks"]) == 1
    begin, end = known["shocks"][0]
    assert begin <= 30.0 <= end + 0.02


def test_a_sound_log_loses_nothing():
    known = properties(recording.of_table(at_rest().reset_index()))
    assert known["left_out"] == []
    assert known["shocks"] == []


@pytest.mark.slow
def test_the_knock_of_the_xsens_dot_is_a_shock(recipes, sets, mirror):
    recipe = RecordingRecipe.from_mapping(recipes["xsens_dot_1"])
    path = sets[recipe.dataset].file(recipe.run).place(mirror)
    if not path.is_file():
        pytest.skip(f"the mirror has no {path.name}")
    known = properties(recipe.read(path))
    assert any("zero on all axes" in one for one in known["left_out"])
    assert any(begin - 0.1 < 108.33 < end + 0.1 for begin, end in known["shocks"])
