"""Models of devices: each is shipped whole, says what is true of it, and is taken by its name."""

from pathlib import Path

import pytest
import yaml

from imugap.analysis.drive_settings import DriveSettings
from imugap.api.logs import open_model, simulate
from imugap.effects import CATALOGUE, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.devices import catalogue
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io import configuration
from imugap.io.catalogue import datasets
from imugap.io.json_schema import Draft202012Validator
from imugap.model import ErrorModel

ROOT = Path(__file__).parents[2]
SCHEMAS = ROOT / "workflow/schemas"
NAMES = catalogue.names()


@pytest.fixture(scope="module")
def recipes():
    return configuration.read(ROOT / "data/devices.yaml", SCHEMAS / "devices.schema.yaml")


def test_every_model_is_of_a_device_of_the_recipes(recipes):
    assert NAMES
    assert set(NAMES) <= set(recipes)


@pytest.mark.parametrize("name", NAMES)
def test_the_card_is_complete_and_agrees_with_the_catalogue_of_data(name, recipes):
    content = catalogue.read(name).content
    schema = yaml.safe_load((SCHEMAS / "device_model.schema.yaml").read_text())
    Draft202012Validator(schema).validate(content)
    own = datasets.load(ROOT / "data", SCHEMAS)[content["data"]["dataset"]]
    assert content["title"] == recipes[name]["title"]
    assert content["remarks"] == recipes[name]["remarks"]
    for key in ("licence", "source", "remarks", "frame"):
        assert content["data"][key] == getattr(own, key)
    digests = {one.name: one.sha256 for one in own.files}
    assert all(digests[one["name"]] == one["sha256"] for one in content["data"]["files"])


@pytest.mark.parametrize("name", NAMES)
def test_the_card_has_every_parameter_of_the_model_within_its_interval(name):
    card = catalogue.read(name)
    held = {
        (axis, effect.name, key, value)
        for axis, model in card.model.axes.items() for effect in model for key, value in effect.parameters().items()
    }  # fmt: skip
    assert {(one["axis"], one["effect"], one["parameter"], one["value"]) for one in card.content["parameters"]} == held
    for one in card.content["parameters"]:
        assert one["low"] is None or one["low"] <= one["value"]
        assert one["high"] is None or one["value"] <= one["high"]


@pytest.mark.parametrize("name", NAMES)
def test_nothing_that_happened_once_is_in_the_model(name):
    assert not [effect for model in catalogue.read(name).model.axes.values() for effect in model if effect.once]


@pytest.mark.parametrize("name", NAMES)
def test_a_device_is_simulated_by_its_name(name):
    log = simulate(name, duration=2, rate=50)
    assert set(catalogue.read(name).model.sensors) <= set(log.table)


def test_what_lies_beyond_the_rate_of_the_recording_is_said():
    opened = open_model(NAMES[0])
    rate = opened.device.rate_hz
    assert len(opened.at(rate).remarks) == 1
    assert f"above {rate / 2:.4g} Hz is not known" in opened.at(2 * rate).remarks[1]


def test_a_file_of_the_name_of_a_device_goes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own = ErrorModel({"gyro_x": AxisModel((WhiteNoise(1.0),))})
    own.write(NAMES[0])
    assert ModelFile.open(NAMES[0], CATALOGUE).model == own


def test_a_configuration_of_a_drive_names_a_device(tmp_path):
    path = tmp_path / "car.yaml"
    path.write_text("model: xsens_dot\n")
    settings = DriveSettings.read(path)
    assert settings.model == catalogue.read("xsens_dot").model
    assert "Xsens DOT" in settings.recognised[0]


def test_a_copy_of_the_file_is_taken_with_its_card(tmp_path):
    copy = tmp_path / "mine.yaml"
    copy.write_bytes((catalogue.FOLDER / f"{NAMES[0]}.yaml").read_bytes())
    assert ModelFile.open(copy, CATALOGUE).at(None).model == catalogue.read(NAMES[0]).model


@pytest.mark.parametrize("name", ["xsens_dott", "xsens-dot", "Xsens_Dot"])
def test_the_name_that_was_meant_is_said(name):
    with pytest.raises(ValueError, match=r"expected a file or the name of a device \(did you mean xsens_dot"):
        open_model(name)


def test_a_path_that_is_no_name_is_a_missing_file():
    with pytest.raises(FileNotFoundError):
        open_model("no/xsens_dot")


CARD = {"title": "a", "data": {"logs": [{"rate_hz": 9.0}]}, "model": {"gyro_x": [{"bias": {"value": 1.0}}]}}


@pytest.mark.parametrize("fault", [{"model": {}}, {"title": None}, {"data": {"logs": []}}, {"model": 3}])
def test_a_card_without_what_it_needs_is_refused(tmp_path, fault):
    path = tmp_path / "card.yaml"
    path.write_text(yaml.safe_dump({"schema": "imugap/device/1"} | CARD))
    assert open_model(path).at(None).model.sensors
    path.write_text(yaml.safe_dump({"schema": "imugap/device/1"} | CARD | fault))
    with pytest.raises(ValueError, match=rf"{path}: .*expected .*found"):
        open_model(path)
