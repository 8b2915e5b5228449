"""A converted recording is the one that is read; it is canonical, and takes no word any more."""

import numpy as np
import pandas as pd
import pytest
from tests.io.devices import at_rest, times, turned, write_text

from imugap import cli
from imugap.io import recording
from imugap.log import AXES

HEADER = ["Time (ms)", *(f"Gyro {a} (deg/s)" for a in "XYZ"), *(f"Accel {a} (g)" for a in "XYZ"), "flag"]


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    samples = at_rest(40_000)
    units = np.repeat([np.pi / 180, 9.80665], 3)
    columns = [times(len(samples)) * 1e3, samples / units, np.zeros(len(samples))]
    return write_text(tmp_path / "run.csv", HEADER, np.column_stack(columns))


def test_a_converted_recording_is_the_one_that_is_read(run, capsys):
    assert cli.main(["convert", "run.csv", "--out", "run.parquet"]) == 0
    said = capsys.readouterr().err
    for words in ("100 Hz, 40000 samples", "stamps ms -> s", "gyro deg/s -> rad/s", "accel g -> m/s^2", "z up (FLU)"):
        assert words in said
    found = recording.read("run.parquet")
    assert found.recognised == ()
    pd.testing.assert_frame_equal(found.log, recording.read("run.csv").log, rtol=1e-12)
    assert pd.read_parquet("run.parquet").index.name == "time"


def test_the_options_decide_as_in_every_command(run, tmp_path):
    write_text(tmp_path / "imu.txt", None, turned(), separator=" ")
    (tmp_path / "device.yaml").write_text(
        "columns: [gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z]\nunits: [gyro=rad/s, accel=m/s^2]\nrate: 100\n"
    )
    options = ["--reading", "device.yaml", "--frame", "FLU"]
    assert cli.main(["convert", "imu.txt", "--out", "imu.parquet", *options]) == 0
    found = recording.read("imu.parquet").log
    np.testing.assert_allclose(found.to_numpy(), turned() * [1, -1, -1, 1, -1, -1], rtol=1e-8)
    np.testing.assert_allclose(found.index, times())


@pytest.mark.parametrize("options", [["--out", "run.csv"], ["--out", "x.parquet", "--units", "gyro=g"]])
def test_what_cannot_be_converted_leaves_nothing(run, tmp_path, capsys, options):
    before = set(tmp_path.iterdir())
    assert cli.main(["convert", "run.csv", *options]) == 1
    assert capsys.readouterr().err.count("\n") == 1
    assert set(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("place", "message"),
    [(0, "line 40002, column time: expected a number of at most 1e+20"),
     (1, "line 40002, column gyro_x: expected a number of at most 1e+12")],
)  # fmt: skip
def test_a_number_beyond_any_device_is_named_by_its_line(run, capsys, place, message):
    cells = ["400000", "0", "0", "0", "0", "0", "1", "0"]
    cells[place] = "1e300"
    with run.open("a") as file:
        file.write(",".join(cells) + "\n")
    assert cli.main(["convert", "run.csv", "--out", "out.parquet"]) == 1
    assert message in capsys.readouterr().err


def test_stamps_of_which_none_increases_are_refused(run, capsys):
    write_text(run, ["time", *AXES], np.column_stack([0 * times(), turned()]))
    assert cli.main(["convert", "run.csv", "--out", "out.parquet"]) == 1
    assert "found 0 in all 3000 rows" in capsys.readouterr().err
