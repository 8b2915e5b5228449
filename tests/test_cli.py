import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap import cli, log, readers
from imugap.indices import INDICES
from imugap.model import ErrorModel

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
    "one sample": (nothing, ["simulate", "model.yaml", "--duration", "0.1", "--rate", "9"], "at least 2 samples"),
}


DUE = ("--duration", "30", "--rate", "50")


def lines(capsys):
    """The lines on the standard error, but for those that say which index a log is too short for."""
    titles = "|".join(re.escape(index.title) for index in INDICES.values())
    note = re.compile(rf"imugap: ({titles}): expected at least \S+ s; found \S+ s")
    return [line for line in capsys.readouterr().err.splitlines() if not note.fullmatch(line)]


@pytest.mark.parametrize("fault", FAULTS)
def test_bad_input_is_one_line_and_exit_code_1_and_leaves_no_file(here, capsys, fault):
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


@pytest.mark.parametrize(("option", "value"), [("--rate", "0"), ("--duration", "inf"), ("--gravity", "-1")])
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


def test_a_log_too_short_for_every_index_is_refused(here, capsys):
    simulate("run.csv", duration=5)
    assert cli.main(["indices", "run.csv"]) == 1
    assert len(lines(capsys)) == 1


def test_a_slow_log_shows_what_it_can(here, capsys):
    simulate("run.csv", duration=100, rate=1)
    assert cli.main(["indices", "run.csv"]) == 0
    assert "stability" in capsys.readouterr().out


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
