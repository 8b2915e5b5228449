import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imugap import cli, log
from imugap.estimation.indices import INDICES
from imugap.interchange.conventions import Rule, Triad
from imugap.interchange.export import Target, export
from imugap.io import readers
from imugap.model import ErrorModel
from imugap.stream import stream

MODEL = """
gyro_x: [{white_noise: {density: 1e-4}}, {bias: {value: 1.0e-3}}]
gyro_z: [{white_noise: {density: 2e-4}}]
accel_z: [{white_noise: {density: 1e-3}}, {bias: {value: 0.02}}]
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working directory with a model."""
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").write_text(MODEL)
    return tmp_path


def simulate(out, duration=40, rate=50, seed=1):
    options = ["--duration", duration, "--rate", rate, "--seed", seed, "--out", out]
    return cli.main(["simulate", "model.yaml", *map(str, options)])


def names(folder):
    return {path.name for path in folder.iterdir()}


@pytest.mark.parametrize("name", ["run.csv", "run.parquet"])
def test_a_simulated_log_is_the_one_of_the_library(here, name):
    assert simulate(name) == 0
    found = readers.read(name)
    still = {axis: np.full(2000, -9.80665 * (axis == "accel_z")) for axis in ("gyro_x", "gyro_z", "accel_z")}
    expected = ErrorModel.read("model.yaml").simulate(log.from_samples(still, 0.02), 1, "simulate")
    pd.testing.assert_frame_equal(found, expected, rtol=1e-15)
    assert names(here) == {"model.yaml", name}


def test_another_seed_is_another_log_and_the_same_seed_is_the_same(here):
    for name, seed in (("a.csv", 1), ("b.csv", 1), ("c.csv", 2)):
        assert simulate(name, seed=seed) == 0
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes() != Path("c.csv").read_bytes()


def test_simulate_check_and_indices_make_a_round_trip(here, capsys):
    runs = ["one.csv", "two.parquet", "three.csv"]
    for seed, name in enumerate(runs):
        assert simulate(name, seed=seed) == 0
    assert capsys.readouterr() == ("", "")

    assert cli.main(["check", *runs]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert [line for line in out.splitlines() if line in runs] == runs
    facts, _ = json.JSONDecoder().raw_decode(out[out.index("{") :])
    assert facts["timing"]["missing"] == facts["timing"]["duplicated"] == 0

    assert cli.main(["indices", *runs, "--out", "indices.csv"]) == 0
    out, err = capsys.readouterr()
    assert set(err.splitlines()) == {
        "imugap: bias instability: expected at least 600 s; found 40 s",
        "imugap: random walk of the rate: expected at least 600 s; found 40 s",
    }
    found = pd.read_csv("indices.csv").set_index(["axis", "symbol"])
    assert set(found.index.get_level_values("symbol")) == {"bias", "stability", "repeatability", "N"}
    assert (found["runs"] == 3).all()
    for axis, density, bias in (("gyro_x", 1e-4, 1e-3), ("gyro_z", 2e-4, 0.0), ("accel_z", 1e-3, 0.02)):
        white, mean = found.loc[(axis, "N")], found.loc[(axis, "bias")]
        assert white["value"] == pytest.approx(density, rel=0.15)  # 4 standard errors
        assert mean["value"] == pytest.approx(bias, abs=4 * density / np.sqrt(3 * 40))
        assert mean["low"] < mean["value"] < mean["high"]
        assert out.count(axis) == 4
    shown = next(line for line in out.splitlines() if line.split()[:2] == ["gyro_x", "bias"])
    assert float(shown.split()[2]) == pytest.approx(np.rad2deg(found.loc[("gyro_x", "bias"), "value"]) * 3600, rel=1e-5)


def test_indices_count_from_the_gravity_of_the_place(here, capsys):
    simulate("run.csv")
    for gravity in (9.80665, 9.79665):
        cli.main(["indices", "run.csv", "--gravity", str(gravity), "--out", f"{gravity}.csv"])
    one, other = (
        pd.read_csv(f"{gravity}.csv").set_index(["axis", "symbol"])["value"] for gravity in (9.80665, 9.79665)
    )
    difference = one - other
    assert difference[("accel_z", "bias")] == pytest.approx(0.01, rel=1e-9)
    assert difference.drop(("accel_z", "bias")).abs().max() < 1e-12


def unsorted(path):
    log.from_samples({"gyro_x": np.arange(5.0) / 100}, 0.1).iloc[[0, 1, 3, 2, 4]].to_csv(path)


def half(path):
    Path(path).write_text("time,gyro_x\n0.0,0.1\n0.1,0.")


def foreign(path):
    Path(path).write_text("time,giro_x\n0.0,0.1\n0.1,0.1\n")


def constant(path):
    log.from_samples({"gyro_x": np.zeros(3000)}, 0.01).to_csv(path)


def nothing(path):
    """Leave no file."""


def still(path):
    log.from_samples({"gyro_x": np.sin(np.arange(3000.0)), "accel_y": np.full(3000, 0.1)}, 0.01).to_csv(path)


def noisy(path, count=3000):
    rng = stream(1, "noisy")
    log.from_samples({axis: rng.normal(0, 1e-3, count) for axis in ("gyro_x", "accel_y")}, 0.01).to_csv(path)


def brief(path):
    noisy(path, 100)


def holed(path):
    Path(path).write_text("time,gyro_x\n0.0,0.1\n0.1,nan\n0.2,0.1\n")


FAULTS = {
    "time goes back": (unsorted, ["check", "bad.csv"], "bad.csv: line 5, column time"),
    "cut off": (half, ["check", "bad.csv"], "bad.csv: line 3"),
    "unknown column": (foreign, ["indices", "bad.csv"], "did you mean gyro_x"),
    "no log": (nothing, ["indices", "bad.csv"], "bad.csv: file: .*no such file"),
    "constant": (constant, ["indices", "bad.csv"], "found a constant sequence"),
    "no model": (nothing, ["simulate", "bad.yaml", "--duration", "1", "--rate", "9"], "No such file.*bad.yaml"),
    "not a model": (
        lambda path: Path("bad.yaml").write_text("gyro_x: [{white_nois: {density: 1}}]"),
        ["simulate", "bad.yaml", "--duration", "1", "--rate", "9"],
        "bad.yaml: gyro_x: effect: expected white_noise; found 'white_nois'",
    ),
    "no sensor": (
        lambda path: Path("bad.yaml").write_text("time: [{clock_scale: {ratio: 1.1}}]"),
        ["simulate", "bad.yaml", "--duration", "1", "--rate", "9"],
        "bad.yaml: expected a model of at least one sensor axis; found none",
    ),
    "no such target": (
        nothing,
        ["export", "model.yaml", "--to", "kaliber", "--rate", "100"],
        "target: expected kalibr; found 'kaliber'",
    ),
    "not enough axes": (
        nothing,
        ["export", "model.yaml", "--to", "kalibr", "--rate", "100"],
        "model: expected all of .*; found none of gyro_y, accel_x, accel_y",
    ),
    "absurd duration": (
        nothing,
        ["simulate", "model.yaml", "--duration", "1e15", "--rate", "1e3"],
        r"simulate: expected a duration and rate of at most \S+ samples; found 1e\+18",
    ),
    "endless duration": (
        nothing,
        ["simulate", "model.yaml", "--duration", "1e200", "--rate", "1e200"],
        r"simulate: expected a duration and rate of at most \S+ samples; found inf",
    ),
    "constant axis": (
        still,
        ["estimate", "bad.csv", "--terms", "white_noise"],
        "accel_y: likelihood: expected finite samples that vary; found constant",
    ),
    "NaN": (holed, ["estimate", "bad.csv"], "bad.csv: line 3, column gyro_x: expected a finite number; found nan"),
    "too short": (brief, ["estimate", "bad.csv"], "gyro_x: choice: expected at least 256 samples; found 100"),
    "unknown term": (
        noisy,
        ["estimate", "bad.csv", "--terms", "white_noise,gaus_markov"],
        "terms: expected gauss_markov; found 'gaus_markov'",
    ),
    "no term": (noisy, ["estimate", "bad.csv", "--terms", ""], "terms: expected one of .*; found ''"),
    "term twice": (
        noisy,
        ["estimate", "bad.csv", "--terms", "white_noise,white_noise"],
        "terms: expected only gauss_markov more than once; found white_noise",
    ),
    "unknown axis": (noisy, ["estimate", "bad.csv", "--axis", "gyro_X"], "axis: expected gyro_x; found 'gyro_X'"),
    "axis that the log lacks": (noisy, ["estimate", "bad.csv", "--axis", "accel_z"], "axis: expected accel_y; found"),
    "two for Allan": (
        noisy,
        ["estimate", "bad.csv", "--method", "allan", "--terms", "gauss_markov,gauss_markov"],
        "terms: expected at most one gauss_markov for the method allan",
    ),
    "robust likelihood": (noisy, ["estimate", "bad.csv", "--robust"], "robust: expected the method wavelet"),
    "figure of another format": (
        noisy,
        ["estimate", "bad.csv", "--figure", "out.png"],
        "out.png: file name: expected one that ends in .svg",
    ),
    "one sample": (nothing, ["simulate", "model.yaml", "--duration", "0.1", "--rate", "9"], "at least 2 samples"),
}


DUE = ("--duration", "30", "--rate", "50")


def lines(capsys):
    """The lines on the standard error, but for those that say which index a log is too short for."""
    titles = "|".join(re.escape(index.title) for index in INDICES.values())
    note = re.compile(rf"imugap: ({titles}): expected at least \S+ s; found \S+ s")
    return [line for line in capsys.readouterr().err.splitlines() if not note.fullmatch(line)]


@pytest.mark.parametrize("fault", FAULTS)
def test_bad_input_is_one_line_and_exit_code_1_and_leaves_no_file(here, judge, capsys, fault):
    make, arguments, message = FAULTS[fault]
    make("bad.csv")
    before = names(here)
    assert cli.main(arguments if arguments[0] == "check" else [*arguments, "--out", "out.csv"]) == 1
    (line,) = lines(capsys)
    assert re.match(f"imugap: .*{message}", line)
    assert names(here) == before


def test_a_file_that_is_no_yaml_is_one_line(here, capsys):
    Path("bad.yaml").write_text("gyro_x: [{white_noise: {density: 1e-4}\n")
    assert cli.main(["simulate", "bad.yaml", *DUE, "--out", "out.csv"]) == 1
    assert len(lines(capsys)) == 1


@pytest.mark.parametrize(
    ("option", "value"), [("--rate", "0"), ("--rate", "abc"), ("--duration", "inf"), ("--gravity", "-1")]
)
def test_an_option_that_has_to_be_positive_is_refused(here, capsys, option, value):
    with pytest.raises(SystemExit, match="2"):
        cli.main(["simulate", "model.yaml", *DUE, option, value, "--out", "out.csv"])
    assert f"argument {option}: expected a finite number > 0; found {value}" in capsys.readouterr().err
    assert names(here) == {"model.yaml"}


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf"])
@pytest.mark.parametrize("option", ["--period", "--gravity"])
def test_an_option_of_the_indices_that_has_to_be_positive_is_refused(here, capsys, option, value):
    with pytest.raises(SystemExit, match="2"):
        cli.main(["indices", "run.csv", f"{option}={value}", "--out", "out.csv"])
    assert f"argument {option}: expected a finite number > 0; found {value}" in capsys.readouterr().err
    assert names(here) == {"model.yaml"}


def estimate(*options):
    return cli.main(["estimate", "run.csv", "--out", "out.json", *options])


def test_estimates_are_written_in_every_form(here, capsys, judge, validated):
    simulate("run.csv", duration=60)
    assert estimate("--table", "out.csv", "--figure", "out.svg", "--model", "found.yaml") == 0
    records = validated(Path("out.json").read_text())
    assert [record["axis"] for record in records] == ["gyro_x", "gyro_z", "accel_z"]
    found = ErrorModel.read("found.yaml")
    table = pd.read_csv("out.csv").set_index(["axis", "effect", "parameter"])
    for record, density in zip(records, (1e-4, 2e-4, 1e-3), strict=True):
        (term,) = record["terms"]
        white = term["parameters"]["density"]
        assert term["name"] == "white_noise"
        assert white["low"] < density < white["high"]
        assert table.loc[(record["axis"], "white_noise", "density"), "value"] == white["value"]
        assert [effect.parameters() for effect in found[record["axis"]]] == [{"density": white["value"]}]
    assert "<svg" in Path("out.svg").read_text()
    out, err = capsys.readouterr()
    assert err == ""
    assert out.count(judge) == 3
    assert names(here) == {"model.yaml", "run.csv", "out.json", "out.csv", "out.svg", "found.yaml"}


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.sets(st.sampled_from(log.AXES), min_size=1), st.sampled_from(["run.csv", "run.parquet"]))
def test_any_subset_of_axes_is_estimated(here, judge, validated, axes, name):
    rng = stream(2, "subset")
    log.write(log.from_samples({axis: rng.normal(0, 1e-3, 300) for axis in axes}, 0.01), name)
    assert cli.main(["estimate", name, "--terms", "white_noise,gauss_markov", "--out", "out.json"]) == 0
    records = validated(Path("out.json").read_text())
    assert [record["axis"] for record in records] == [axis for axis in log.AXES if axis in axes]


def test_axes_asked_for_come_in_that_order_and_once(here, judge, validated):
    simulate("run.csv")
    assert estimate("--terms", "white_noise", "--axis", "gyro_z", "gyro_x", "gyro_z") == 0
    assert [record["axis"] for record in validated(Path("out.json").read_text())] == ["gyro_z", "gyro_x"]


def test_lost_samples_are_said(here, judge, capsys):
    simulate("run.csv")
    readers.read("run.csv").drop(index=1.0).to_csv("run.csv")
    assert estimate("--terms", "white_noise") == 0
    assert "expected evenly spaced samples; found 1 gaps, the first at 0.98 s" in capsys.readouterr().err


def test_estimates_are_written_all_or_none(here, judge, capsys, monkeypatch):
    simulate("run.csv")
    before = names(here)

    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(pd.DataFrame, "to_csv", broken)
    assert estimate("--terms", "white_noise", "--model", "found.yaml", "--table", "out.csv") == 1
    assert lines(capsys) == ["imugap: disk full"]
    assert names(here) == before


def test_a_log_too_short_for_every_index_is_refused(here, capsys):
    simulate("run.csv", duration=5)
    assert cli.main(["indices", "run.csv"]) == 1
    assert len(lines(capsys)) == 1


def test_a_slow_log_shows_what_it_can(here, capsys):
    simulate("run.csv", duration=100, rate=1)
    assert cli.main(["indices", "run.csv"]) == 0
    assert "stability" in capsys.readouterr().out


def test_an_export_is_that_of_the_library(here):
    options = ["--to", "imugap", "--rate", "100", "--horizon", "5", "--triad", "worst", "--correlation-time", "60"]
    assert cli.main(["export", "model.yaml", *options, "--out", "filter.yaml"]) == 0
    rule = Rule(100.0, 5.0, 60.0, Triad.WORST)
    assert Path("filter.yaml").read_text() == export(ErrorModel.read("model.yaml"), Target.IMUGAP, rule)
    assert names(here) == {"model.yaml", "filter.yaml"}


def test_an_ending_that_is_not_read_is_not_written(here):
    assert simulate("run.txt") == 1


@pytest.mark.parametrize(
    "name",
    [
        "out.csv",
        "out.parquet",
    ],
)
def test_an_interrupted_write_leaves_the_old_file_and_no_other(here, capsys, monkeypatch, name):
    def broken(self, *_, **__):
        self.write_bytes(b"half")
        raise OSError("disk full")

    Path(name).write_text("old")
    monkeypatch.setattr(pd.DataFrame, "to_csv", lambda _, path: broken(path))
    monkeypatch.setattr(pd.DataFrame, "to_parquet", lambda _, path: broken(path))
    assert simulate(name) == 1
    assert lines(capsys) == ["imugap: disk full"]
    assert Path(name).read_text() == "old"
    assert names(here) == {"model.yaml", name}
