"""Folders and archives of a text for each sensor, as the loggers of phones write them."""

import zipfile

import numpy as np
import pytest
from tests.io.devices import RATE, at_rest

from imugap.io.fixes import reading
from imugap.io.recording import RecordingSettings, read
from imugap.log import ACCEL, GYRO, LogError

COUNT = 400
START_NS = 1_767_620_467_350_470_700
GRAVITY = np.array([0.0, 0.0, 9.80665])


ALL = ("Gyroscope", "Accelerometer", "Gravity", "TotalAcceleration")


def sensor_logger(folder, samples, late_ns=0, files=ALL, platform=",android"):
    """Write the files of Sensor Logger: columns z, y, x, and an accelerometer without gravity."""
    stamps = START_NS + (np.arange(COUNT) / RATE * 1e9).astype(np.int64)
    parts = {
        "Gyroscope": samples[:, :3], "Accelerometer": samples[:, 3:] - GRAVITY, "Gravity": np.tile(GRAVITY, (COUNT, 1)),
        "TotalAcceleration": samples[:, 3:], "AccelerometerUncalibrated": samples[:, 3:],
    }  # fmt: skip
    folder.mkdir()
    (folder / "Metadata.csv").write_text(f"version,device name,platform\n3,phone{platform}\n")
    for name in files:
        late = 0 if name == "Gyroscope" else late_ns
        rows = [
            f"{stamp + late},{k / RATE:.6f},{z!r},{y!r},{x!r}"
            for k, (stamp, (x, y, z)) in enumerate(zip(stamps.tolist(), parts[name].tolist(), strict=True))
        ]
        (folder / f"{name}.csv").write_text("\n".join(["time,seconds_elapsed,z,y,x", *rows, ""]))
    return folder


def phyphox(folder, samples):
    """Write the files of phyphox: a name, an axis and a unit in each header."""
    folder.mkdir()
    for name, word, unit, values in (
        ("Accelerometer", "Acceleration", "m/s^2", samples[:, 3:]),
        ("Linear Accelerometer", "Linear Acceleration", "m/s^2", samples[:, 3:] - GRAVITY),
        ("Gyroscope", "Gyroscope", "rad/s", samples[:, :3]),
    ):
        head = ",".join(['"Time (s)"', *(f'"{word} {axis} ({unit})"' for axis in "xyz")])
        rows = [",".join(f"{value:.9E}" for value in (k / RATE, *row)) for k, row in enumerate(values)]
        (folder / f"{name}.csv").write_text("\n".join([head, *rows, ""]))
    (folder / "meta").mkdir()
    (folder / "meta" / "time.csv").write_text('"event","experiment time"\n"START",0\n')
    return folder


def zipped(folder):
    path = folder.with_suffix(".zip")
    with zipfile.ZipFile(path, "w") as archive:
        for one in folder.rglob("*.csv"):
            archive.write(one, one.relative_to(folder))
    return path


@pytest.fixture
def samples():
    return at_rest(COUNT, up=(0, 0, 1))


WRITERS = {
    "Sensor Logger": sensor_logger,
    "Sensor Logger without total": lambda folder, samples: sensor_logger(
        folder, samples, files=("Gyroscope", "Accelerometer", "Gravity")
    ),
    "Sensor Logger raw": lambda folder, samples: sensor_logger(
        folder, samples, files=("Gyroscope", "Accelerometer", "AccelerometerUncalibrated")
    ),
    "phyphox": phyphox,
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("pack", [lambda folder: folder, zipped], ids=["folder", "zip"])
def test_the_files_of_a_phone_are_one_log(tmp_path, samples, name, pack):
    found = read(pack(WRITERS[name](tmp_path / "run", samples)))
    flipped = samples * [1, -1, -1, 1, -1, -1]  # z up, turned
    np.testing.assert_allclose(found.log[[*GYRO, *ACCEL]], flipped, atol=1e-8)
    assert 1 / np.median(np.diff(found.log.index)) == pytest.approx(RATE, rel=1e-6)
    assert not found.weightless


def test_sensors_on_stamps_of_their_own_keep_them(tmp_path, samples):
    found = read(sensor_logger(tmp_path / "run", samples, late_ns=1_300_000)).regular
    assert len(found.samples["gyro_x"].values) == len(found.samples["accel_x"].values) == COUNT
    assert 1 / found.samples["accel_x"].interval == pytest.approx(RATE, rel=1e-4)


def test_a_phone_that_logs_no_gravity_is_no_log_of_specific_force(tmp_path, samples):
    folder = sensor_logger(tmp_path / "run", samples, files=("Gyroscope", "Accelerometer"))
    with pytest.raises(LogError, match="gravity"):
        read(folder).require_gravity()


def test_a_folder_of_other_texts_is_refused(tmp_path):
    (tmp_path / "Barometer.csv").write_text("time,seconds_elapsed,pressure\n1,0,1000\n2,1,1000\n")
    (tmp_path / "Compass.csv").write_text("time,seconds_elapsed,bearing\n1,0,10\n2,1,10\n")
    with pytest.raises(LogError, match="expected"):
        read(tmp_path)


def test_positions_of_a_phone_are_read_from_its_folder(tmp_path, samples):
    folder = sensor_logger(tmp_path / "run", samples)
    names = "time,seconds_elapsed,speedAccuracy,horizontalAccuracy,speed,bearing,altitude,longitude,latitude"
    rows = [f"{START_NS + k * 10**9},{k},0.5,5,1,90,500,{11.5 + k * 1e-5},48" for k in range(5)]
    (folder / "Location.csv").write_text("\n".join([names, *rows, ""]))
    found = reading.read(zipped(folder)).fixes
    np.testing.assert_allclose(found.index, START_NS / 1e9 + np.arange(5), rtol=0, atol=1e-6)
    np.testing.assert_allclose(np.degrees(found["longitude"]), 11.5 + np.arange(5) * 1e-5)


@pytest.mark.parametrize(
    "files", [("Gyroscope", "Accelerometer", "Gravity"), ("Gyroscope", "AccelerometerUncalibrated")]
)
def test_the_sign_of_a_phone_of_apple_is_undone_where_the_logger_names_it(tmp_path, samples, files):
    apple = samples * [1, 1, 1, -1, -1, -1]
    folder = sensor_logger(tmp_path / "ios", apple, files=files, platform=",ios")
    if "Gravity" in files:
        text = (folder / "Gravity.csv").read_text()
        (folder / "Gravity.csv").write_text(text.replace("9.80665", "-9.80665"))
        text = (folder / "Accelerometer.csv").read_text().splitlines()
        rows = (line.split(",") for line in text[1:])
        shifted = [",".join([*row[:2], repr(float(row[2]) + 2 * 9.80665), *row[3:]]) for row in rows]
        (folder / "Accelerometer.csv").write_text("\n".join([text[0], *shifted, ""]))
    found = read(folder)
    np.testing.assert_allclose(found.log[[*GYRO, *ACCEL]], samples * [1, -1, -1, 1, -1, -1], atol=1e-8)
    assert any("gravity points down" in one for one in found.recognised)


def test_accelerations_of_an_unknown_phone_are_refused_and_read_by_the_option(tmp_path, samples):
    files = ("Gyroscope", "Accelerometer", "Gravity")
    folder = sensor_logger(tmp_path / "phone", samples, files=files, platform=",")
    with pytest.raises(LogError, match=r"--units accel=m/s\^2, or accel=-m/s\^2"):
        read(folder)
    found = read(folder, RecordingSettings(units={"accel": "m/s^2"}))
    np.testing.assert_allclose(found.log[[*GYRO, *ACCEL]], samples * [1, -1, -1, 1, -1, -1], atol=1e-8)
