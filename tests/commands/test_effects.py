"""The command effects: every effect is described with its parameters, and drawn with values that it admits."""

from pathlib import Path

import pytest

from imugap import cli
from imugap.analysis.effect_description import axis_of
from imugap.commands.effects import describe, given_effect
from imugap.effects import CATALOGUE, GaussMarkov
from imugap.effects.effect import Stage
from imugap.figures.effects import picture
from imugap.io import strict_yaml
from imugap.model import ErrorModel


def test_all_effects_are_listed(capsys):
    assert cli.main(["effects"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    assert [line.split()[0] for line in lines] == list(CATALOGUE)


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_effect_is_described_by_parameters_and_a_line_that_a_model_takes(name):
    effect = given_effect(CATALOGUE[name])
    text = describe(effect)
    assert text.startswith(f"{name}: ")
    assert all(parameter in text for parameter in effect.parameters())
    assert "`" not in text
    (axis,) = ErrorModel.from_mapping(strict_yaml.parse(text.splitlines()[-1], "text")).axes.values()
    assert [one.name for one in axis] == [name]


@pytest.mark.parametrize("name", [name for name, kind in CATALOGUE.items() if kind.stage is not Stage.STANCE])
def test_an_effect_is_drawn(name):
    effect = given_effect(CATALOGUE[name])
    assert len(picture(effect, axis_of(effect)).axes) == 2


@pytest.mark.parametrize(("name", "begin"), [("a.svg", b"<?xml"), ("a.png", b"\x89PNG"), ("a.PDF", b"%PDF")])
def test_the_picture_has_the_format_of_its_name_and_the_given_values(tmp_path, monkeypatch, capsys, name, begin):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["effects", "gauss_markov", "std=1e-3", "--out", name]) == 0
    assert Path(name).read_bytes().startswith(begin)
    assert "{gauss_markov: {std: 0.001, correlation_time: 10}}" in capsys.readouterr().out
    assert given_effect(GaussMarkov, ["std=1e-3"]) == GaussMarkov(1e-3, 10.0)
