"""Discovery on files: the folder is whole and keeps its schema, bad input is one message and leaves nothing."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.signal import butter, lfilter
from tests import strict_json

from imugap import cli, log
from imugap.api.discoveries import Discovered
from imugap.commands.discover import FILES
from imugap.discovery.device import Settings, discover
from imugap.discovery.inputs import Files
from imugap.discovery.verdict import verdict
from imugap.effects import (
    Bias,
    BiasStep,
    CommonMode,
    Outliers,
    RandomWalk,
    Resolution,
    Saturation,
    ScaleFactor,
    Sinusoid,
    Temperature,
    TimestampJitter,
    TurnOnBias,
    VarianceChange,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.io.json_schema import Draft202012Validator
from imugap.model import ErrorModel

SCHEMA = yaml.safe_load((Path(__file__).parents[2] / "workflow/schemas/discovery.schema.yaml").read_text())
INTERVAL, COUNT = 0.02, 4000
LINE = Sinusoid(7.3, 6e-4)
QUICK = {"replicates": 30, "simulations": 20}


def written(files, out):
    """Discover, quickly, and write the folder."""
    found = Discovered.of(files, Settings(**QUICK))
    found.report(out)
    return found.found


def device(*hidden, axes=("gyro_x", "gyro_y")):
    white = {axis: WhiteNoise(1e-4 if axis in log.GYRO else 1e-3) for axis in axes}
    return ErrorModel({a: AxisModel((white[a], Bias(1e-3), *(hidden if a == axes[-1] else ()))) for a in axes})


def still(axes=("gyro_x", "gyro_y"), count=COUNT):
    return log.from_samples({axis: np.full(count, -9.8 if axis == "accel_z" else 0.0) for axis in axes}, INTERVAL)


def measured(*hidden, seed=1, axes=("gyro_x", "gyro_y"), count=COUNT):
    return device(*hidden, axes=axes).simulate(still(axes, count), seed, "dossier")


TEXTS = {
    "foreign.csv": "time,giro_x\n0.0,0.1\n0.1,0.1\n",
    "misspelt.yaml": "gyro_x: [{white_nois: {density: 1}}]",
    "two_filters.yaml": "gyro_x: [{output_filter: {cutoff: 5}}, {output_filter: {cutoff: 9}}]",
    "in_degrees.yaml": "gyro_x: [{white_noise: {density: 1e-4}}, {resolution: {step: 10}}]",
    "broken_effects.py": "import nothing_that_is_there\n",
    "empty_effects.py": "A = 1\n",
}


def faulty():
    """Logs that are no runs of one device, by name."""
    table, row = measured(), np.arange(COUNT)
    return {
        "short": table[:100],
        "constant": table.assign(gyro_x=1e-3, gyro_y=1e-3),
        "stray": table.set_axis(pd.Index([0.0, *(1.6e9 + table.index[1:])], name="time")),
        "switched": table.assign(**dict.fromkeys(table, 1e-3 * (row // 50 % 2))),
        "slow": table[::2],
        "half": still(count=COUNT // 2),
        "x": table[["gyro_x"]],
        "every_other": table.assign(gyro_y=table["gyro_y"].where(row % 2 == 0)),
        "held": table.assign(gyro_y=table["gyro_y"].to_numpy()[row // 3 * 3]),
        "two_in_one": table.set_axis(pd.Index(row % (COUNT // 2) * INTERVAL, name="time")),
        "warm": table.assign(temperature=np.linspace(20.0, 30.0, COUNT)),
        "without": table.assign(temperature=np.nan),
        "x_alive": table.assign(gyro_y=0.0),
        "y_alive": measured(seed=2).assign(gyro_x=0.0),
        "holes": still()[lambda one: (one.index < 20.0) | (one.index > 40.0)],
    }


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Two runs of a device that has a line, and bad files."""
    folder = tmp_path_factory.mktemp("discover")
    for seed, name in ((1, "run1.csv"), (2, "run2.parquet")):
        log.write(measured(LINE, seed=seed), folder / name)
    run = measured(LINE, seed=3)
    log.write(run.set_axis(1.044 * run.index), folder / "clock.csv")
    for name, table in faulty().items():
        table.to_csv(folder / f"{name}.csv")
    for name, text in TEXTS.items():
        (folder / name).write_text(text)
    return folder


def discovered(*arguments, out="found"):
    return cli.main(["discover", *arguments, "--workers", "1", "--out", out])


def read_report(folder):
    report = strict_json.load(f"{folder}/report.json")
    Draft202012Validator(SCHEMA).validate(report)
    return report


@pytest.mark.slow
def test_a_run_of_another_clock_is_compared_at_its_own_rate(here):
    found = written(Files((Path("run1.csv"),), (Path("clock.csv"),)), "found")
    (test,) = found.report()["test"]
    assert test["rate_hz"] == pytest.approx(1 / (1.044 * INTERVAL), rel=1e-6)
    distance = found.found.distances["distribution"]
    assert distance.after.value < distance.before.value


def test_an_axis_that_is_held_is_named_so(here):
    (one,) = written(Files((Path("held.csv"),)), "found").found.findings
    assert (one.name, one.axes, one.parameters["every"].value) == ("held_samples", ("gyro_y",), 3.0)


@pytest.mark.slow
def test_the_folder_is_whole_and_tells_the_line(here, capsys):
    assert discovered("run1.csv") == 0
    out, _ = capsys.readouterr()
    assert "gyro_y: sinusoid (frequency 7.3 Hz" in out
    assert {path.name for path in Path("found").iterdir()} == set(FILES)
    report = read_report("found")
    (effect,) = report["effects"]
    assert (effect["name"], effect["axes"]) == ("sinusoid", ["gyro_y"])
    frequency = effect["parameters"]["frequency"]
    assert frequency["low"] < 7.3 < frequency["high"]
    assert report["test"] == []
    assert report["navigation_distance"] is None
    (one,) = report["log"]
    assert one["rate_hz"] == pytest.approx(50)
    assert one["duration_s"] == pytest.approx(80)
    assert report["distance"]["before"]["value"] > report["distance"]["after"]["value"]
    final = ErrorModel.read("found/model.yaml")
    assert final.to_mapping() == report["final_model"]
    parameters = pd.read_csv("found/parameters.csv").set_index(["axis", "effect", "parameter"])
    held = {(axis, one.name, key) for axis, some in final.axes.items() for one in some for key in one.parameters()}
    assert set(parameters.index) == held
    assert ((parameters["low"] <= parameters["value"]) & (parameters["value"] <= parameters["high"])).all()
    for axis in ("gyro_x", "gyro_y"):
        white = parameters.loc[axis, "white_noise", "density"]
        assert white["low"] < 1e-4 < white["high"] < 1.1 * white["low"]
    table = pd.read_csv("found/gaps.csv")
    assert {("gyro_y", "line", "start")} <= set(zip(table["axis"], table["view"], table["model"], strict=True))
    page = Path("found/report.md").read_text()
    assert set(re.findall(r"\]\((\S+)\)", page)) == {name for name in FILES if name.endswith(".svg")}
    for name in re.findall(r"\]\((\S+)\)", page):
        assert "<svg" in (Path("found") / name).read_text()


@pytest.mark.slow
def test_two_runs_of_the_command_write_the_same_bytes(here):
    for out in ("one", "two"):
        written(Files((Path("run1.csv"),)), out)
    for name in FILES:
        assert (here / "one" / name).read_bytes() == (here / "two" / name).read_bytes()


def test_the_discrepancy_shrinks_on_a_run_that_no_fit_has_seen(here):
    found = written(Files((Path("run1.csv"),), (Path("run2.parquet"),)), "found").found
    report = read_report("found")
    assert [one["path"] for one in report["test"]] == ["run2.parquet"]
    apart = found.distances["distribution"]
    assert apart.before.low > apart.floor.high
    assert apart.floor.low * 0.9 < apart.after.value < apart.floor.high * 1.1


@pytest.mark.slow
def test_a_test_run_of_another_device_stays_far(here):
    log.write(measured(Sinusoid(11.0, 6e-4), seed=3), "other.csv")
    found = written(Files((Path("run1.csv"),), (Path("other.csv"),)), "found").found
    apart = found.distances["distribution"]
    assert apart.after.low > apart.floor.high


@pytest.mark.slow
def test_distances_over_two_runs_are_root_mean_squares():
    runs = [measured(LINE, seed=seed) for seed in (1, 2, 3)]
    settings = Settings(**QUICK)
    alone = discover(runs[:1], settings, runs[1:2]).distances["distribution"]
    both = discover(runs[:1], settings, [runs[1], runs[1]]).distances["distribution"]
    # the same run twice: each with simulations of its own, so that only the scatter differs
    assert both.before.value == pytest.approx(alone.before.value, rel=0.1)
    assert both.floor.high - both.floor.low < alone.floor.high - alone.floor.low


@pytest.mark.slow
def test_six_axes_at_rest_are_navigated():
    found = discover([measured(axes=log.AXES, count=1600)], Settings(**QUICK))
    assert set(found.distances) == {"distribution", "navigation"}
    (path,) = found.drifts
    assert path.before.shape == path.after.shape == (20, *path.measured.shape)
    assert path.time[-1] == pytest.approx(0.2 * 1600 * INTERVAL, abs=17 * INTERVAL)


def test_a_clipped_log_with_lost_values_is_compared_as_it_is():
    flawed = measured(Saturation(1.4e-3))
    flawed.iloc[100:2000:50, 0] = np.nan
    apart = discover([flawed], Settings(**QUICK)).distances["distribution"]
    assert apart.floor.high < apart.before.value
    assert apart.after.value < apart.floor.high


def test_steps_are_told_in_order_to_the_last():
    told = []
    discover([measured()], Settings(**QUICK), progress=lambda *step: told.append(step))
    assert [done for _, done, _ in told] == list(range(told[0][2] + 1))
    assert (told[0][0], told[-1][0]) == ("integrity", "done")


FAULTS = {
    "none.csv": "none.csv: file: .*no such file",
    "run1.csv --test none.csv": "none.csv: file: .*no such file",
    "foreign.csv": "foreign.csv: line 1: .*did you mean gyro_x",
    "short.csv": "short.csv: column gyro_x: expected at least 320 samples; found 100",
    "constant.csv": "constant.csv: columns: expected values that vary on one axis at least",
    "switched.csv": "switched.csv: columns: expected values that vary on one axis at least",
    "stray.csv": "stray.csv: column time: expected one recording without a pause of most of its time",
    "run1.csv run1.csv --reference run1.csv": "reference: expected one log, which it is the error-free one of; found 2",
    "run1.csv --test slow.csv": "slow.csv: time: expected the rate of the first log, 50 Hz; found 25 Hz",
    "run1.csv slow.csv": "slow.csv: time: expected the rate of the first log, 50 Hz; found 25 Hz",
    "run1.csv --test run2.parquet --reference run1.csv": "test: expected runs",
    "run1.csv --reference half.csv": "half.csv: time: expected that of the log, 0 to 79.98 s; found 0 to 39.98 s",
    "run1.csv --reference holes.csv": "holes.csv: time: expected stamps near 90 % of those of the log; "
    "found holes, which leave 75 %",
    "run1.csv --reference x.csv": "x.csv: columns: expected those of the first log, gyro_x, gyro_y; found no gyro_y",
    "run1.csv --test x.csv": "x.csv: columns: expected those of the first log, gyro_x, gyro_y; found no gyro_y",
    "every_other.csv": "every_other.csv: column gyro_y: expected a value in every row.*one of 2 rows",
    "two_in_one.csv": "two_in_one.csv: row 2000, column time: expected a time that increases; found 0 s after 39.98 s",
    "warm.csv --test without.csv": "without.csv: column temperature: expected values, as the first log has; found none",
    "x_alive.csv y_alive.csv": "y_alive.csv: columns: expected values that vary on an axis on which those "
    "of the first log do, gyro_x; found none",
    "run1.csv --model none.yaml": "none.yaml: .*; found 'No such file",
    "run1.csv --model misspelt.yaml": (
        r"misspelt.yaml: gyro_x: effect: expected a known name \(did you mean white_noise\?\); found 'white_nois'"
    ),
    "run1.csv --model two_filters.yaml": "two_filters.yaml: gyro_x: expected one output_filter at most; found 2",
    "run1.csv --model in_degrees.yaml": "in_degrees.yaml: gyro_x: resolution: expected a step below the range "
    "of the values of the log.*found 10",
    "run1.csv --effects not_a_module": "effects: not_a_module: expected a module that can be imported; found",
    "run1.csv --effects broken_effects": "nothing_that_is_there",
    "run1.csv --effects empty_effects": "found none in empty_effects",
}


@pytest.mark.parametrize(("arguments", "message"), FAULTS.items(), ids=FAULTS)
def test_bad_input_is_one_message_and_leaves_nothing(refused, arguments, message):
    refused(f"discover {arguments} --workers 1 --out found", message, among="imugap:")


def test_a_file_in_the_place_of_the_folder_is_refused_before_the_work(here, capsys):
    Path("found").write_text("mine")
    assert discovered("run1.csv") == 1
    assert "found: expected a folder; found a file" in capsys.readouterr().err
    assert Path("found").read_text() == "mine"


@pytest.mark.slow
def test_what_the_log_cannot_tell_stays_as_the_start_model_has_it(here, capsys):
    clock = {"time": AxisModel((TimestampJitter(1e-5),))}
    start = {**device(ScaleFactor(1e-3), Temperature(1e-4), TurnOnBias(1e-3)).axes, **clock}
    ErrorModel(start | {"accel_z": AxisModel((WhiteNoise(1e-3),))}).write("sheet.yaml")
    assert discovered("run1.csv", "--model", "sheet.yaml") == 0
    assert (
        "cannot tell scale factor of gyro_y, temperature of gyro_y, turn on bias of gyro_y" in capsys.readouterr().out
    )
    report = read_report("found")
    assert [(one["name"], one["axes"]) for one in report["effects"]] == [("sinusoid", ["gyro_y"])]
    for key in ("start_model", "final_model"):
        kept = ErrorModel.from_mapping(report[key])
        assert {"scale_factor", "temperature", "turn_on_bias"} <= {effect.name for effect in kept["gyro_y"]}
        assert (kept["time"], kept["accel_z"]) == (clock["time"], AxisModel((WhiteNoise(1e-3),)))


def test_what_the_start_model_knows_is_not_named_again():
    white = WhiteNoise(1e-4)
    start = ErrorModel({
        "gyro_x": AxisModel((white, Bias(0.0), Outliers(5e-3, 2e-2), CommonMode(1e-4, 1.0))),
        "gyro_y": AxisModel((white, Bias(0.0), RandomWalk(0.0), CommonMode(1e-4, -0.8))),
    })  # fmt: skip
    found = discover([start.simulate(still(), 5)], Settings(start, **QUICK))
    assert (found.findings, found.unexplained) == ((), ())
    assert {"outliers", "common_mode"} <= {effect.name for effect in found.final["gyro_x"]}


@pytest.mark.slow
def test_an_axis_without_two_values_is_a_place_and_does_not_stop_the_others():
    found = discover([measured(LINE).assign(gyro_x=2.0, gyro_z=np.nan)], Settings(**QUICK))
    assert [(one.name, one.axes) for one in found.findings] == [("sinusoid", ("gyro_y",))]
    for discrepancies in (found.discrepancies, found.unexplained):
        assert {(place.axis, place.view) for place in discrepancies} >= {("gyro_x", "values"), ("gyro_z", "values")}


def test_a_change_of_variance_that_lasts_goes_on_in_what_no_fit_has_seen():
    found = discover([measured(VarianceChange(48.0, 80.0, 3.0))], Settings(**QUICK))
    assert [one.name for one in found.findings] == ["variance_change"]
    assert found.findings[0].log_score_gain > 0
    apart = found.distances["distribution"]
    assert apart.after.value < 0.6 * apart.before.value


def test_outliers_of_the_start_model_stay_where_the_log_shows_none():
    start = ErrorModel({**device().axes, "gyro_x": AxisModel((WhiteNoise(1e-4), Bias(1e-3), Outliers(1e-3, 0.02)))})
    found = discover([measured()], Settings(start, **QUICK))
    assert "outliers" in {effect.name for effect in found.final["gyro_x"]}
    assert ("gyro_x", "outliers") in found.undetermined


def turning(axes, seed=7):
    slow = lfilter(*butter(2, 0.05), np.random.default_rng(seed).standard_normal((len(axes), COUNT)))
    return log.from_samples(dict(zip(axes, 3 * slow, strict=True)), INTERVAL)


@pytest.mark.slow
def test_a_log_of_one_axis_may_answer_a_motion_of_which_all_is_known():
    ideal = turning(log.AXES)
    answered = 2e-3 * ideal["accel_y"]
    device = pd.DataFrame({"gyro_x": measured()["gyro_x"] + ideal["gyro_x"] + answered})
    found = discover([device], Settings(**QUICK), reference=ideal)
    assert [one.name for one in found.findings] == ["g_sensitivity"]
    assert found.distances["distribution"].after.value < found.distances["distribution"].before.value


@pytest.mark.slow
def test_noise_in_common_takes_no_place_of_what_an_axis_answers():
    axes = ("gyro_x", "gyro_y")
    ideal, shared = turning(axes), np.random.default_rng(3).standard_normal(COUNT) * 2e-3
    errors = {"gyro_x": shared + 4e-3 * np.abs(ideal["gyro_y"]), "gyro_y": shared}
    device = measured() + ideal + pd.DataFrame(errors, index=ideal.index)
    found = discover([device], Settings(**QUICK), reference=ideal)
    assert "common_mode" in {one.name for one in found.findings}
    assert any(place.view == "rate" and place.axis == "gyro_x,gyro_y" for place in found.unexplained)


def test_nothing_is_told_of_the_holes_of_a_reference():
    ideal = turning(("gyro_x", "gyro_y"))
    device = measured() + ideal
    broken = ideal[(ideal.index < 30.0) | (ideal.index > 34.0)]
    found = discover([device], Settings(**QUICK), reference=broken)
    assert (found.findings, found.unexplained) == ((), ())


@pytest.mark.slow
def test_times_count_from_the_first_sample_that_is_used(here):
    table = measured(BiasStep(40.0, 5e-3))[["gyro_y"]]
    table.iloc[:500] = np.nan
    table.set_axis(table.index + 100.0).rename_axis("time").to_csv("late.csv")
    assert discovered("late.csv") == 0
    report = read_report("found")
    (step,) = report["effects"]
    (used,) = report["log"]
    assert used["begin_s"] + step["parameters"]["time"]["value"] == pytest.approx(140.0, abs=0.1)
    assert used["duration_s"] == pytest.approx(70.0)


@pytest.mark.slow
def test_a_test_run_knows_nothing_of_a_step_that_happened_in_the_log():
    step = BiasStep(40.0, 5e-3)
    apart = discover([measured(step)], Settings(**QUICK), [measured(seed=2)]).distances["distribution"]
    assert apart.after.low < apart.floor.high < apart.before.low  # 260 where the step is simulated


@pytest.mark.parametrize("steps", [0.5, 1.1, 2.5])
def test_a_log_on_a_coarse_lattice_is_reached_by_the_model_with_it(steps):
    std = 1e-4 / np.sqrt(INTERVAL)
    start = ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-4), Bias(0.3 * steps * std)))})
    truth = ErrorModel({"gyro_x": AxisModel((*start["gyro_x"], Resolution(steps * std)))})
    found = discover([truth.simulate(still(("gyro_x",)), 6)], Settings(**QUICK))
    assert [one.name for one in found.findings] == ["resolution"]
    assert found.distances["distribution"].after.value < found.distances["distribution"].floor.high
    white, bias = (one for one in found.final["gyro_x"] if isinstance(one, (WhiteNoise, Bias)))
    assert white.density == pytest.approx(1e-4, rel=0.05)
    assert bias.value == pytest.approx(0.3 * steps * std, abs=0.06 * std)


def test_values_without_a_unit_are_written_in_full():
    step = VarianceChange(20.0, 60.0, 11.0)
    text = verdict(discover([measured(step)], Settings(**QUICK)))
    ratio = float(re.search(r"variance_change \(.*ratio ([0-9.]+)[,)]", text)[1])
    assert ratio == pytest.approx(11.0, rel=0.2)


@pytest.mark.slow
def test_a_write_that_fails_leaves_the_old_folder(here, capsys, fill_disk):
    written(Files((Path("run1.csv"),)), "found")
    before = {name: (here / "found" / name).read_bytes() for name in FILES}
    fill_disk()
    assert discovered("run2.parquet") == 1
    assert "imugap: found: expected a file or folder that can be used; found 'disk full'" in capsys.readouterr().err
    assert {path.name: path.read_bytes() for path in Path("found").iterdir()} == before


@pytest.mark.parametrize(
    ("option", "value"), [("--alpha", "0"), ("--alpha", "1"), ("--alpha", "x"), ("--workers", "0")]
)
def test_an_option_out_of_range_is_refused(here, capsys, option, value):
    with pytest.raises(SystemExit, match="2"):
        discovered("run1.csv", option, value)
    assert f"argument {option}: expected" in capsys.readouterr().err
    assert not Path("found").exists()
