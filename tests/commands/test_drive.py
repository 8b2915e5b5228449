"""The command drive: the folder is whole, its numbers are those of the drive, bad input is one message."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from tests import strict_json

from imugap import cli, log
from imugap.analysis.drive import STD, RecordedDrive, mounted, navigate_drive
from imugap.analysis.drive_settings import SCHEMA, DriveSettings
from imugap.api import logs
from imugap.api.drives import in_axes_of_mounting
from imugap.commands.drive import FILES
from imugap.io.configuration import configure
from imugap.io.json_schema import Draft202012Validator
from imugap.kinematics.strapdown import COLUMNS, GEODETIC
from imugap.log import ACCEL, GYRO
from imugap.numerics.rotation import from_euler

ROOT = Path(__file__).parents[2]
SEED = 61
MOUNTING = {"roll_deg": 180.0, "pitch_deg": 7.0, "heading_deg": -175.0}
UPWARD = np.array([1.0, -1.0, -1.0] * 2)
"""Signs of the axes of a device with x forward and z up."""
LEVER = {"x_m": 0.4, "y_m": -0.3, "z_m": -1.2}


def degrees(fixes):
    return fixes.assign(latitude=np.degrees(fixes["latitude"]), longitude=np.degrees(fixes["longitude"]))


def in_device(record):
    """Return a log as a device that is mounted upside down and backwards has it."""
    turn = from_euler(np.radians(list(MOUNTING.values()))).inv()
    parts = [turn.apply(record[list(triad)].to_numpy(copy=True)) for triad in (GYRO, ACCEL)]
    return pd.DataFrame(np.hstack(parts), index=record.index, columns=[*GYRO, *ACCEL])


@pytest.fixture(scope="module")
def files(tmp_path_factory, lap):
    """A drive, straight and turned, its fixes with an outage and outliers, and settings."""
    folder = tmp_path_factory.mktemp("drive")
    record, fixes = lap.record(1, SEED), degrees(lap.fixes(1, SEED))
    fixes = fixes[(fixes.index < 150) | (fixes.index > 170)]
    fixes.loc[100.0, "latitude"] += 50 / 111e3
    log.write(record, folder / "imu.csv")
    log.write(in_device(record), folder / "turned.parquet")
    log.write(record * UPWARD, folder / "upward.csv")
    log.write(record[(record.index < 90.001) | (record.index > 91.0)], folder / "gap.csv")
    fixes.to_csv(folder / "gnss.csv")
    fixes.drop(columns=[name for name in fixes if name not in GEODETIC]).to_parquet(folder / "places.parquet")
    fixes.loc[:14].to_csv(folder / "still.csv")
    fixes.set_index(fixes.index + 1e5).to_csv(folder / "later.csv")
    fixes.set_index(fixes.index * 1e-12).to_csv(folder / "tiny.csv")
    fixes.set_index(fixes.index + 298.5).to_csv(folder / "brief.csv")
    lap.model.write(folder / "device.yaml")
    own = {"model": "device.yaml", "lever_arm": LEVER, "scale_factor": {"gyro_std": 1e-3, "accel_std": 1e-3}}
    (folder / "own.yaml").write_text(yaml.safe_dump(own))
    (folder / "turned.yaml").write_text(yaml.safe_dump(own | {"mounting": MOUNTING}))
    (folder / "left.yaml").write_text(yaml.safe_dump({"mounting": {"heading_deg": 20.0}}))
    (folder / "upright.yaml").write_text(yaml.safe_dump({"mounting": {"roll_deg": 180.0, "heading_deg": 20.0}}))
    (folder / "tilted.yaml").write_text(yaml.safe_dump({"mounting": {"pitch_deg": 85.0}}))
    (folder / "misspelt.yaml").write_text("quality: {robustt: true}")
    (folder / "wrong.yaml").write_text("epoch_s: -1")
    (folder / "list.yaml").write_text("- 1")
    (folder / "broken.yaml").write_text("a: [")
    return folder


@pytest.mark.parametrize(
    ("samples", "fixes", "config", "limit"),
    [
        ("imu.csv", "gnss.csv", ("--config", "own.yaml"), 3.0),
        pytest.param("turned.parquet", "gnss.csv", ("--config", "turned.yaml"), 3.0, marks=pytest.mark.slow),
        pytest.param("imu.csv", "gnss.csv", (), 6.0, marks=pytest.mark.slow),
        pytest.param("imu.csv", "places.parquet", ("--config", "own.yaml"), 6.0, marks=pytest.mark.slow),
    ],
)
def test_the_folder_is_whole_and_says_where_the_vehicle_was(here, lap, capsys, samples, fixes, config, limit):
    assert cli.main(["drive", samples, fixes, *config, "--out", "found"]) == 0
    assert {path.name for path in Path("found").iterdir()} == set(FILES)
    given = [(one["role"], one["path"]) for one in strict_json.load("found/inputs.json")]
    assert given == [("log", samples), ("fixes", fixes), *([("configuration", config[1])] if config else [])]
    found = strict_json.load("found/summary.json")
    out = capsys.readouterr().out
    assert out.startswith(f"{found['verdict']}\n\n")
    assert f"set aside {found['set_aside']}" in out
    assert out.endswith("More: found/report.html\n")
    assert len(out.splitlines()) < 15
    assert found["outages"] == 1
    assert found["longest_outage_s"] == pytest.approx(22.0)
    assert found["distance_m"] == pytest.approx(2830, rel=0.02)
    truth = lap.path[0]
    for name in ("solution", "smoothed"):
        table = pd.read_parquet(f"found/{name}.parquet")
        assert {*COLUMNS, *GEODETIC, *(f"{one}{STD}" for one in COLUMNS)} < set(table.columns)
        assert not table.isna().any().any()
        aided = table[(table.index > 60) & (table.index < 150)]
        true = truth.iloc[np.rint(aided.index * lap.rate_hz).astype(int)]
        off = aided[["north", "east"]].to_numpy() - true[["north", "east"]].to_numpy()
        off -= off.mean(axis=0)  # the origin is the first fix, noise and antenna included
        assert np.hypot(*off.T).max() < limit
        assert table["latitude"].mean() == pytest.approx(48, abs=0.05)
    events = pd.read_csv("found/events.csv")
    assert "set aside" in set(events[events["time"] == 100.0]["event"])
    for name in ("set_aside", "weighed_down", "offset_opened", "offset_closed"):
        assert found[name] == (events["event"] == name.replace("_", " ")).sum()
    assert found["set_aside"] >= 1
    drifts = pd.read_csv("found/outages.csv")
    pd.testing.assert_frame_equal(pd.DataFrame(found["drift_over_outages"]), drifts)
    assert f"(95 %: {drifts['p95_m'][0]:.3g}) in 10 s, {drifts['windows'][0]} windows" in out
    assert cli.main(["export", "found/model.yaml", "--to", "kf-gins", "--rate", "100", "--out", "kf-gins.yaml"]) == 0
    page = Path("found/report.html").read_text()
    assert all(line in page for line in Path("found/settings.yaml").read_text().splitlines())
    assert f"s long. It starts {found['start_s']:.3g} s into the log" in page


def test_all_facts_are_printed_as_json(here, capsys):
    assert cli.main(["drive", "imu.csv", "gnss.csv", "--as-given", "--json", "--out", "found"]) == 0
    assert json.loads(capsys.readouterr().out) == strict_json.load("found/summary.json")


@pytest.mark.slow
def test_the_summary_tells_whether_the_filter_knows_itself(lap):
    """Over clean drives with the true settings: NIS in its band as often as it says."""
    given = {
        "lever_arm": dict(LEVER),
        "scale_factor": {"gyro_std": 1e-3, "accel_std": 1e-3},
        "quality": {"component_sigma": None, "gated": False, "reset_s": None},
    }
    setting = DriveSettings.of(configure(given, SCHEMA), lap.model)
    inside = []
    for run in range(30):
        found = navigate_drive(RecordedDrive(lap.record(run, SEED), lap.fixes(run, SEED), setting)).summary()
        inside.append(found["nis_low"] < found["nis"] < found["nis_high"])
        assert found["global_test_failed"] <= 3
    assert 25 <= sum(inside) <= 30


@pytest.mark.slow
def test_lost_samples_are_filled(lap):
    record, fixes = lap.record(1, SEED), lap.fixes(1, SEED)
    whole, holes = (
        navigate_drive(RecordedDrive(some, fixes)).filtered for some in (record, record.drop(record.index[5000:5020]))
    )
    apart = whole.history.navigation[-1, :3] - holes.history.navigation[-1, :3]
    assert np.abs(apart).max() < np.sqrt(whole.history.variances[-1, :3].max())


FAULTS = {
    "gap.csv gnss.csv": "drive: expected gaps of at most 0.5 s; found 1.01 s after 90",
    "imu.csv still.csv": "start: expected a fix that tells the course",
    "imu.csv later.csv": r"0 s to 300 s; found fixes from 100001 s .*\(.*one clock\? time_offset: {offset_s: -1000",
    "imu.csv tiny.csv": r"tiny.csv: column time: expected stamps in seconds, at most 1000 Hz; found 1e\+12 Hz",
    "imu.csv brief.csv": "drive: expected at least 2 fixes within the time of the log; found 1 of",
    "turned.parquet gnss.csv": "expected a mean specific force that points up, accel_z near -9.8",
    "imu.csv gnss.csv --config tilted.yaml": "pitch_deg: 85, heading_deg: 0}, which gravity contra",
    "imu.csv none.csv": "none.csv: file: expected a log of fixes",
    "none.csv gnss.csv": "none.csv: file: expected a log",
    "imu.csv imu.csv": "imu.csv: line 1: expected all of latitude, longitude, height",
    "imu.csv gnss.csv --config misspelt.yaml": r"quality: expected a key of the schema "
    r"\(did you mean robust\?\); found 'robustt'",
    "imu.csv gnss.csv --config wrong.yaml": "epoch_s: expected a number > 0; found -1",
    "imu.csv gnss.csv --config list.yaml": "list.yaml: expected keys and values; found a list of 1",
    "imu.csv gnss.csv --config broken.yaml": "broken.yaml",
    "imu.csv gnss.csv --config none.yaml": "none.yaml",
}


@pytest.mark.parametrize(("arguments", "message"), FAULTS.items(), ids=FAULTS)
def test_bad_input_is_one_message_and_leaves_nothing(refused, arguments, message):
    refused(f"drive {arguments} --out found", message)


def test_a_figure_that_fails_leaves_no_folder(here, fill_disk):
    fill_disk()
    assert cli.main(["drive", "imu.csv", "gnss.csv", "--out", "found"]) == 1
    assert not Path("found").exists() or not any(Path("found").iterdir())


def test_the_schema_is_one_closed_and_described():
    schema = yaml.safe_load(SCHEMA.read_text())
    Draft202012Validator.check_schema(schema)

    def walk(part):
        assert part.get("description")
        if part.get("type") == "object":
            assert part["additionalProperties"] is False
            for one in part["properties"].values():
                assert "default" in one
                walk(one)

    walk(schema)


def test_the_defaults_are_those_of_the_library():
    default = DriveSettings.read(None)
    plain = DriveSettings()
    assert default.assumptions == plain.assumptions
    assert default.quality == plain.quality
    assert default.model.to_mapping() == plain.model.to_mapping()


values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5), lambda one: st.lists(one, max_size=2), max_leaves=3
)
keys = st.sampled_from(["quality", "epoch_s", "start", "model", "mounting", "lever_arm", "other"])


@pytest.mark.slow
@given(st.dictionaries(keys, values | st.dictionaries(st.sampled_from(["robust", "x_m", "std_m", "y"]), values)))
def test_any_configuration_is_a_setting_or_one_message(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("any") / "drive.yaml"
    path.write_text(yaml.safe_dump(content))
    try:
        found = DriveSettings.read(path)
    except (OSError, ValueError):
        return
    assert found.assumptions.epoch_s > 0


def test_a_mounting_turns_the_device_into_the_vehicle(lap):
    record = lap.record(1, SEED)
    turned = mounted(in_device(record), tuple(np.radians(list(MOUNTING.values()))))
    np.testing.assert_allclose(turned, record, atol=1e-12)


@pytest.mark.parametrize("config", ["left.yaml", "upright.yaml"])
def test_a_mounting_leaves_the_recognition_of_a_device_with_z_up(here, capsys, config):
    """By heading alone it is one in the recognised axes, with a roll of 180 deg in those of the file."""
    found = in_axes_of_mounting(logs.read("upward.csv"), settings := DriveSettings.read(config))
    turned = mounted(found.table, settings.mounting)
    plain = mounted(logs.read("imu.csv").table, (0.0, 0.0, np.radians(20)))
    np.testing.assert_allclose(turned[list(ACCEL)], plain[list(ACCEL)], atol=1e-6)
    assert ("z up (FLU)" in " ".join(found.recognised)) == (config == "left.yaml")
