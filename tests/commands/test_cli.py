import re
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from imugap import cli, log
from imugap.estimation.indices import INDICES
from imugap.interchange.conventions import Rule, Triad
from imugap.interchange.export import Target, export
from imugap.io import recording
from imugap.model import ErrorModel
from imugap.stream import stream

MODEL = """
gyro_x: [{white_noise: {density: 1e-4}}, {bias: {value: 1.0e-3}}]
gyro_z: [{white_noise: {density: 2e-4}}]
accel_z: [{white_noise: {density: 1e-3}}, {bias: {value: 0.02}}]
"""


TEXTS = {
    "model.yaml": MODEL,
    "half.csv": "time,gyro_x\n0.0,0.1\n0.1,0.",
    "foreign.csv": "time,giro_x\n0.0,0.1\n0.1,0.1\n",
    "holed.csv": "time,gyro_x\n0.0,0.1\n0.1,nan\n0.2,0.1\n",
    "bad.yaml": "gyro_x: [{white_nois: {density: 1}}]",
    "clock.yaml": "time: [{clock_scale: {ratio: 1.1}}]",
    "empty.yaml": "",
    "huge.yaml": "gyro_x: [{bias: {value: 1.0e+160}}]",
    "no.yaml": "gyro_x: [{white_noise: {density: 1e-4}\n",
}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A model, and bad files."""
    folder = tmp_path_factory.mktemp("cli")
    for name, text in TEXTS.items():
        (folder / name).write_text(text)
    rng = stream(1, "noisy")
    noisy = log.from_samples({axis: rng.normal(0, 1e-3, 3000) for axis in ("gyro_x", "accel_y")}, 0.01)
    tables = {
        "unsorted": log.from_samples({"gyro_x": np.arange(5.0) / 100}, 0.1).iloc[[0, 1, 3, 2, 4]],
        "constant": log.from_samples({"gyro_x": np.zeros(3000)}, 0.01),
        "still": log.from_samples({"gyro_x": 1e-3 * np.sin(np.arange(3000.0)), "accel_y": np.full(3000, 0.1)}, 0.01),
        "noisy": noisy,
        "brief": noisy[:100],
    }
    for name, table in tables.items():
        table.to_csv(folder / f"{name}.csv")
    return folder


def simulate(out, duration=40, rate=50, seed=1):
    options = ["--duration", duration, "--rate", rate, "--seed", seed, "--out", out]
    return cli.main(["simulate", "model.yaml", *map(str, options)])


def names(folder):
    """Names of the files that no fixture has put there."""
    return {path.name for path in folder.iterdir() if not path.is_symlink()}


@pytest.mark.parametrize("name", ["run.csv", "run.parquet"])
def test_a_simulated_log_is_the_one_of_the_library(here, name):
    assert simulate(name) == 0
    found = recording.read(name).log
    still = {axis: np.full(2000, -9.80665 * (axis == "accel_z")) for axis in ("gyro_x", "gyro_z", "accel_z")}
    expected = ErrorModel.read("model.yaml").simulate(log.from_samples(still, 0.02), 1, "simulate")
    pd.testing.assert_frame_equal(found, expected, rtol=1e-15)
    assert names(here) == {name}


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
    said = "usable for indices, estimate, discover"
    assert [line.split(": ")[:2] for line in out.splitlines() if ": " in line] == [[name, said] for name in runs]

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
    assert float(shown.split()[2]) == pytest.approx(np.rad2deg(found.loc[("gyro_x", "bias"), "value"]) * 3600, rel=1e-3)


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


NEAREST = r"expected a known name \(did you mean {}\?\); found '{}'".format
FAULTS = {
    "check unsorted.csv": "unsorted.csv: line 5, column time",
    "check half.csv": "half.csv: line 3",
    "indices foreign.csv": "did you mean gyro_x",
    "indices none.csv": "none.csv: file: .*no such file",
    "indices constant.csv": "constant.csv: columns: expected an axis that varies; found gyro_x: 0 throughout",
    "simulate none.yaml --duration 1 --rate 9": "none.yaml: expected a file .*; found 'No such file",
    "simulate no.yaml --duration 1 --rate 9": "",
    "simulate bad.yaml --duration 1 --rate 9": "bad.yaml: gyro_x: effect: " + NEAREST("white_noise", "white_nois"),
    "simulate clock.yaml --duration 1 --rate 9": "clock.yaml: expected a model of at least one sensor axis; found none",
    "simulate model.yaml --duration 0.1 --rate 9": "at least 2 samples",
    "simulate model.yaml --duration 1e15 --rate 1e3": r"simulate: expected a duration and rate of at most \S+ "
    r"samples, for which there is room; found 1e\+18",
    "simulate model.yaml --duration 1e200 --rate 1e6": r"simulate: expected a duration and rate of at most \S+ "
    r"samples, for which there is room; found 1e\+206",
    "simulate empty.yaml --duration 1 --rate 9": "empty.yaml: expected a model of at least one axis; found none",
    "simulate huge.yaml --duration 1 --rate 9": r"huge.yaml: gyro_x: .* in \[1e-30, 1e\+12\]; found 1e\+160",
    "export empty.yaml --to python --rate 100": "empty.yaml: expected a model of at least one axis; found none",
    "export model.yaml --to kaliber --rate 100": "target: " + NEAREST("kalibr", "kaliber"),
    "export model.yaml --to kalibr --rate 100": "model: expected a model of all of .*; "
    "found none of gyro_y, accel_x, accel_y",
    "estimate still.csv --axis accel_y": "accel_y: 0.1 throughout, no noise can be seen",
    "estimate holed.csv": "gyro_x: 0.1 throughout, no noise can be seen",
    "estimate noisy.csv --to kaliber imu.yaml": "target: " + NEAREST("kalibr", "kaliber"),
    "estimate noisy.csv --to kalibr imu.yaml": "expected .*all of .*; found none of gyro_y",
    "estimate brief.csv": "gyro_x: choice: expected at least 256 samples; found 100",
    "estimate noisy.csv --terms white_noise,gaus_markov": "terms: " + NEAREST("gauss_markov", "gaus_markov"),
    "estimate noisy.csv --terms ''": "terms: expected one of .*; found ''",
    "estimate noisy.csv --terms white_noise,white_noise": "terms: expected only gauss_markov more than once; "
    "found white_noise",
    "estimate noisy.csv --axis gyro_X": "axis: " + NEAREST("gyro_x", "gyro_X"),
    "estimate noisy.csv --axis accel_z": r"axis: expected a known name \(did you mean accel_y\?\); found",
    "estimate noisy.csv --method allan --terms gauss_markov,gauss_markov": "terms: expected at most one "
    "gauss_markov for the method allan",
    "estimate noisy.csv --robust": "robust: expected the method wavelet",
    "estimate noisy.csv --figure out.jpg": "out.jpg: file name: expected one that ends in .svg, .png, .pdf; found",
    "effects white_nois": "effect: " + NEAREST("white_noise", "white_nois"),
    "effects white_noise dens=1": "white_noise: parameter: " + NEAREST("density", "dens"),
    "effects white_noise density=much": "density: expected a number; found 'much'",
    "effects white_noise density=-1": "white_noise.density: expected a finite number",
    "effects white_noise": "out.csv: file name: expected one that ends in",
}
TITLES = "|".join(re.escape(index.title) for index in INDICES.values())
NO_NOTE = rf"(?!imugap: ({TITLES}): expected at least \S+ s; found \S+ s$)"
"""Matches a line on the standard error that does not say which index a log is too short for."""


@pytest.mark.parametrize(("line", "message"), FAULTS.items(), ids=FAULTS)
def test_bad_input_is_one_line_and_exit_code_1_and_leaves_no_file(refused, judge, line, message):
    refused(line if line.startswith("check") else f"{line} --out out.csv", message, among=NO_NOTE)


def test_a_picture_of_an_effect_that_acts_on_no_log_is_refused(refused):
    refused("effects stance_motion --out out.svg", "expected an effect that acts on a log")


DUE = "simulate model.yaml --duration 30 --rate 50"


@pytest.mark.parametrize(
    ("line", "option", "value"),
    [(DUE, "--rate", "0"), (DUE, "--rate", "abc"), (DUE, "--duration", "inf"), (DUE, "--gravity", "-1")]
    + [
        ("indices run.csv", option, value)
        for option in ("--period", "--gravity")
        for value in ("0", "-1", "nan", "inf")
    ],
)
def test_an_option_that_has_to_be_positive_is_refused(here, capsys, line, option, value):
    with pytest.raises(SystemExit, match="2"):
        cli.main([*line.split(), f"{option}={value}", "--out", "out.csv"])
    assert f"argument {option}: expected a finite number > 0; found {value}" in capsys.readouterr().err
    assert not names(here)


@pytest.mark.parametrize(
    ("line", "option", "expected"),
    [
        (DUE, "--rate=5e7", "expected a rate of 1e-06 to 1e+06 Hz; found 5e7"),
        (DUE, "--gravity=1e160", "expected a gravity of 0.1 to 100 m/s^2; found 1e160"),
        ("export model.yaml --to python", "--rate=5e7", "expected a rate of 1e-06 to 1e+06 Hz; found 5e7"),
        ("estimate noisy.csv", "--rate=5e7", "expected a rate of 1e-06 to 1e+06 Hz; found 5e7"),
    ],
)
def test_an_option_beyond_its_range_is_refused(here, capsys, line, option, expected):
    with pytest.raises(SystemExit, match="2"):
        cli.main([*line.split(), option, "--out", "out.csv"])
    assert f"argument {option.partition('=')[0]}: {expected}" in capsys.readouterr().err
    assert not names(here)


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
    assert names(here) == {"run.csv", "out.json", "out.csv", "out.svg", "found.yaml"}


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
    recording.read("run.csv").log.drop(index=1.0).to_csv("run.csv")
    assert estimate("--terms", "white_noise") == 0
    out, err = capsys.readouterr()
    assert "1 of 2000 samples lost at 50 Hz" in err
    assert "Left out: 1 gap, 1 sample (0.05 %), at 1 s" in out


def test_an_axis_that_fails_costs_itself_alone(here, judge, capsys, validated):
    """A constant axis, and one of which the method finds no effect."""
    assert cli.main(["estimate", "still.csv", "--terms", "white_noise", "--out", "out.json"]) == 0
    assert [record["axis"] for record in validated(Path("out.json").read_text())] == ["gyro_x"]
    assert "accel_y: 0.1 throughout" in capsys.readouterr().err


def test_verdict_comes_before_numbers_and_the_table_is_readable(here, capsys):
    rng = stream(3, "misfit")
    filtered = np.convolve(rng.normal(0, 1e-3, 3010), np.ones(11) / 11, "valid")
    log.from_samples({"gyro_x": rng.normal(0, 1e-3, 3000), "gyro_y": filtered}, 0.01).to_csv("two.csv")
    assert cli.main(["estimate", "two.csv", "--terms", "white_noise"]) == 0
    first, second, third, length, blank, titles, *rest = capsys.readouterr().out.splitlines()
    rows, notes = rest[: rest.index("")], rest[rest.index("") + 1 :]
    assert first.startswith("gyro_y: THE MODEL DOES NOT FIT THE LOG: misfit at")
    assert second == "gyro_x: fits."
    assert "`imugap discover` finds what it lacks" in third
    assert length.startswith("gyroscopes: white noise known to")
    assert blank == ""
    assert titles.split("  ")[0] == "axis"
    names = ["white_noise", "random_walk", "white_noise", "random_walk", "bias", "bias"]
    assert [row.split()[1] for row in rows] == names
    assert max(map(len, (titles, *rows))) <= 100
    assert [note.split(":")[0] for note in notes][-1] == "Upper bound"
    assert re.search(r"white_noise N +0\.0001\d+ .* rad/s/sqrt\(Hz\) +0\.3\d+ deg/sqrt\(h\)", rows[0])


def kalibr(name, *options):
    assert cli.main(["estimate", "rest.csv", "--to", name, "filter.yaml", *options]) == 0
    text = Path("filter.yaml").read_text()
    return text, yaml.safe_load(text)


@pytest.fixture
def rest(here):
    """Ten minutes of six axes of white noise, with the biases of a cheap device, z down."""
    rng, levels = stream(4, "rest"), [5e-3, -4e-3, 3e-3, 0.1, -0.05, 0.08 - 9.80665]
    samples = {
        axis: level + rng.normal(0, (2e-3 if axis in log.GYRO else 2e-2), 12_000)
        for axis, level in zip(log.AXES, levels, strict=True)
    }
    log.from_samples(samples, 0.05).to_csv("rest.csv")


def test_the_file_for_a_filter_says_of_which_axis_the_model_does_not_fit(rest):
    still = recording.read("rest.csv").log
    still["gyro_y"] += 1e-3 * np.cos(2 * np.pi * 7 * still.index.to_numpy())
    still.to_csv("rest.csv")
    text, _ = kalibr("kalibr", "--terms", "white_noise")
    said = [line for line in text.splitlines() if "DOES NOT FIT" in line]
    assert [line.split(":")[0] for line in said] == ["# THE MODEL DOES NOT FIT THE LOG of gyro_y"]


def test_a_log_becomes_a_file_of_kalibr_in_one_step_with_an_upper_bound_of_the_walk(rest):
    text, found = kalibr("kalibr")
    assert found["gyroscope_noise_density"] == pytest.approx(2e-3 * np.sqrt(0.05), rel=0.02)
    assert found["accelerometer_noise_density"] == pytest.approx(2e-2 * np.sqrt(0.05), rel=0.02)
    hidden = 2e-3 * np.sqrt(0.05) * np.sqrt(3) / 200  # crosses the white noise at a third of the log
    assert 0.3 * hidden < found["gyroscope_random_walk"] < 4 * hidden
    assert 3 * hidden < found["accelerometer_random_walk"] < 40 * hidden
    assert found["update_rate"] == 20.0
    assert text.count("Upper bound (one-sided 95 %), no estimate: ") == 6
    assert "10 to 20 times" in text


def test_a_file_of_kf_gins_leaves_the_bias_open(rest):
    _, found = kalibr("kf-gins")
    degrees = np.rad2deg([5e-3, -4e-3, 3e-3]) * 3600
    np.testing.assert_allclose(found["initgyrbias"], degrees, rtol=0.05)
    assert min(found["initbgstd"]) > 0.9 * np.abs(degrees).max()
    assert min(found["initbastd"]) > 9000  # mGal
    assert min(found["imunoise"]["gbstd"] + found["imunoise"]["abstd"]) > 0


@pytest.mark.parametrize("name", ["vins", "ros"])
def test_other_filters_get_their_file_too(rest, name):
    text, _ = kalibr(name)
    assert "Upper bound" in text


def test_estimates_are_written_all_or_none(here, judge, capsys, monkeypatch):
    simulate("run.csv")
    before = names(here)

    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(pd.DataFrame, "to_csv", broken)
    assert estimate("--terms", "white_noise", "--model", "found.yaml", "--table", "out.csv") == 1
    assert capsys.readouterr().err == "imugap: out.csv: expected a file or folder that can be used; found 'disk full'\n"
    assert names(here) == before


def test_a_log_too_short_for_every_index_is_refused(refused):
    simulate("run.csv", duration=5)
    refused("indices run.csv", "", among=NO_NOTE)


def test_indices_leave_out_what_is_no_noise_of_the_sensor(here, capsys):
    """A knock, outliers and a stuck stretch change no index by more than its interval."""
    rng, found = stream(5, "disturbed"), {}
    sound = {axis: rng.normal(0, 1e-3, 40_000) for axis in ("gyro_x", "gyro_y")}
    disturbed = {axis: values.copy() for axis, values in sound.items()}
    disturbed["gyro_x"][5000:5040] += rng.normal(0, 1.0, 40)
    disturbed["gyro_x"][rng.choice(40_000, 400, replace=False)] += 0.1
    disturbed["gyro_y"][10_000:20_000] = disturbed["gyro_y"][10_000]
    for name, samples in (("sound", sound), ("disturbed", disturbed)):
        log.from_samples(samples, 0.02).to_csv(f"{name}.csv")
        assert cli.main(["indices", f"{name}.csv", "--out", f"{name}_indices.csv"]) == 0
        found[name] = pd.read_csv(f"{name}_indices.csv").set_index(["axis", "symbol"])
    err = capsys.readouterr().err
    assert re.search(r"disturbed.csv: gyro_x: Left out: (39|40)\d outliers", err)
    assert "imugap: disturbed.csv: gyro_y: Left out: 1 stuck stretch" in err
    ratio = found["disturbed"]["value"] / found["sound"]["value"]
    assert (abs(ratio.xs("N", level="symbol") - 1) < 0.02).all()
    assert (abs(ratio.xs("stability", level="symbol") - 1) < 0.1).all()


def test_a_slow_log_shows_what_it_can(here, capsys):
    simulate("run.csv", duration=100, rate=1)
    assert cli.main(["indices", "run.csv"]) == 0
    assert "stability" in capsys.readouterr().out


def test_an_export_is_that_of_the_library(here):
    options = ["--to", "imugap", "--rate", "100", "--horizon", "5", "--triad", "worst", "--correlation-time", "60"]
    assert cli.main(["export", "model.yaml", *options, "--out", "filter.yaml"]) == 0
    rule = Rule(100.0, 5.0, 60.0, Triad.WORST)
    assert Path("filter.yaml").read_text() == export(ErrorModel.read("model.yaml"), Target.IMUGAP, rule)
    assert names(here) == {"filter.yaml"}


def test_an_export_without_comments_has_notes_beside_it_and_says_what_it_leaves_out(here, capsys):
    effects = "[{white_noise: {density: 1.0e-3}}, {sinusoid: {frequency: 5.0, amplitude: 0.01}}]"
    Path("line.yaml").write_text("\n".join(f"{axis}: {effects}" for axis in log.AXES))
    assert cli.main(["export", "line.yaml", "--to", "matlab", "--rate", "100", "--out", "imu.json"]) == 0
    assert names(here) == {"line.yaml", "imu.json", "imu.json.notes.txt"}
    assert "Left out: gyro_x sinusoid" in Path("imu.json.notes.txt").read_text()
    err = capsys.readouterr().err
    assert re.search(r"imugap: left out: gyro_x sinusoid .*: without it the Allan deviation is 0\.\d+ times", err)
    assert re.search(r"imugap: left out: gyro_x sinusoid .*; distance \d", err)
    assert "; distance " in Path("imu.json.notes.txt").read_text()


def test_an_estimate_says_what_its_export_leaves_out(here, capsys):
    Path("coarse.yaml").write_text(
        "\n".join(
            f"{axis}: [{{white_noise: {{density: 1.0e-3}}}}, {{quantization: {{q: 1.0e-3}}}}]" for axis in log.AXES
        )
    )
    assert cli.main(["simulate", "coarse.yaml", "--duration", "200", "--rate", "20", "--out", "coarse.csv"]) == 0
    options = ["--terms", "white_noise,random_walk,quantization", "--to", "matlab", "imu.json"]
    assert cli.main(["estimate", "coarse.csv", *options]) == 0
    assert names(here) == {"coarse.yaml", "coarse.csv", "imu.json", "imu.json.notes.txt"}
    notes = Path("imu.json.notes.txt").read_text()
    said = re.findall(r"imugap: left out: (gyro_x quantization \(q .*)", capsys.readouterr().err)
    assert len(said) == 1
    assert f"Left out: {said[0]}" in notes


def test_a_program_holds_the_effects_of_a_plug_in_and_says_what_it_leaves_out(here, capsys, monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))
    effects = "{white_noise: {density: 1}}, {stability_restoration: {stability: 1, period: 1}}, {dead_band: {width: 2}}"
    Path("mine.yaml").write_text(f"gyro_x: [{effects}]")
    options = ["mine.yaml", "--effects", "tests.plugins.renamed", "--rate", "100"]
    for target in ("python", "cpp", "gazebo-plugin"):
        assert cli.main(["export", *options, "--to", target, "--out", f"imu.{target}"]) == 0
        assert "struct DeadBand" in (text := Path(f"imu.{target}").read_text()) or "class DeadBand" in text
        err = capsys.readouterr().err
        assert "imugap: left out: gyro_x stability_restoration (stability 1, period 1), which has no form" in err


def test_an_ending_that_is_not_read_is_not_written(here):
    assert simulate("run.txt") == 1


@pytest.mark.parametrize("name", ["out.csv", "out.parquet"])
def test_an_interrupted_write_leaves_the_old_file_and_no_other(here, capsys, monkeypatch, name):
    def broken(file):
        Path(getattr(file, "name", file)).write_text("half")
        raise OSError("disk full")

    Path(name).write_text("old")
    monkeypatch.setattr(pd.DataFrame, "to_csv", lambda _, file, **__: broken(file))
    monkeypatch.setattr(pyarrow.parquet.ParquetWriter, "write_table", lambda one, _: broken(one.where))
    assert simulate(name) == 1
    assert capsys.readouterr().err == f"imugap: {name}: expected a file or folder that can be used; found 'disk full'\n"
    assert Path(name).read_text() == "old"
    assert names(here) == {name}


def test_the_page_has_the_files_that_were_asked_for_first(here):
    assert cli.main(["simulate", "xsens_dot", "--duration", "60", "--rate", "30", "--out", "run.csv"]) == 0
    options = ["--terms", "white_noise,random_walk", "--to", "vins", "imu.yaml", "--to", "ros", "ros.yaml"]
    assert cli.main(["estimate", "run.csv", *options, "--out", "found"]) == 0
    page = Path("found/report.html").read_text()
    assert page.index("What you asked for") < page.index("For vins") < page.index("For gazebo")
    assert page.count("For ros") == 1
    assert "gyr_w: " in page
