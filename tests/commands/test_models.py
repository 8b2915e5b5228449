"""The command models: every device is listed, its card shown, and its model written."""

import pytest

from imugap import cli
from imugap.effects import CATALOGUE
from imugap.interchange.devices import catalogue
from imugap.interchange.start_models.catalogue import ModelFile

NAMES = catalogue.names()


def test_all_devices_are_listed_with_licence_and_distance(capsys):
    assert cli.main(["models"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    assert [line.split()[0] for line in lines] == NAMES
    assert all("floor" in line for line in lines)


@pytest.mark.parametrize("name", NAMES)
def test_a_card_says_what_was_found_and_what_is_not_known(name, capsys):
    assert cli.main(["models", name]) == 0
    text, card = capsys.readouterr().out, catalogue.read(name)
    plain = " ".join(text.split())
    assert " ".join(card.content["data"]["licence"].split()) in plain
    assert "not known:" in text
    assert all(" ".join(one.split()) in plain for one in (*card.content["not_known"], *card.content["remarks"]))
    assert all(effect.name in text for model in card.model.axes.values() for effect in model)


def test_the_model_alone_is_written(tmp_path, capsys):
    path = tmp_path / "own.yaml"
    assert cli.main(["models", NAMES[0], "--out", str(path)]) == 0
    assert ModelFile.open(path, CATALOGUE).model == catalogue.read(NAMES[0]).model


def test_the_name_that_was_meant_is_said(capsys):
    assert cli.main(["models", "xsens_dott"]) == 1
    assert "did you mean xsens_dot" in capsys.readouterr().err


def test_commands_take_a_device_by_its_name(tmp_path, capsys):
    log, file = tmp_path / "log.csv", tmp_path / "imu.hpp"
    assert cli.main(["simulate", "xsens_dot", "--duration", "2", "--rate", "120", "--out", str(log)]) == 0
    assert cli.main(["export", "xsens_dot", "--to", "cpp", "--rate", "120", "--out", str(file)]) == 0
    assert "xsens_dot: model of one Xsens DOT" in capsys.readouterr().err
    assert log.exists()
    assert "class" in file.read_text()
