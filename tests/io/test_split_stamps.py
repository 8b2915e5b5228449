"""Stamps whose parts stand in several columns."""

from datetime import datetime, timedelta

import numpy as np
import pytest
from tests.io.devices import at_rest, times

from imugap.io.fixes.reading import read as fixes_of
from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import AXES, LogError

COUNT = 1200
SAMPLES = at_rest(COUNT, up=(0, 0, -1))
START_NS = 1_709_337_595_123_456_789
SETTINGS = RecordingSettings(units={"gyro": "rad/s"}, frame="as-is")


def since(k):
    return START_NS + 10_000_000 * k


def moment(k):
    return datetime(2024, 3, 1, 23, 59, 55) + timedelta(milliseconds=10 * k)


PARTS = {
    "secs,nsecs": lambda k: f"{since(k) // 10**9},{since(k) % 10**9}",
    "header.stamp.sec,header.stamp.nanosec": lambda k: f"{since(k) // 10**9},{since(k) % 10**9}",
    "Time (s),Time (us)": lambda k: f"{since(k) // 10**9},{since(k) % 10**9 // 1000}",
    "GPS Week,GPS Seconds": lambda k: f"{2303 + (k > 599)},{(604794 + k / 100 + 1e-9) % 604800:.2f}",
    "week,itow": lambda k: f"2303,{432_000_000 + 10 * k}",
    "hour,minute,second,ms": lambda k: (
        (moment(0) + timedelta(milliseconds=10 * k - 10**6)).strftime("%H,%M,%S,") + str(10 * k % 1000)
    ),
    "year,month,day,hour,minute,second": lambda k: moment(k).strftime("%Y,%m,%d,%H,%M,%S.%f"),
    "timestamp,timestamp_ms": lambda k: f"{1_000_000_000 + k // 100},{10 * (k % 100)}",
    "stamp_sec_imu,stamp_nsec_imu": lambda k: f"{since(k) // 10**9},{since(k) % 10**9}",
    "Date,Time": lambda k: moment(k).strftime("%Y-%m-%d,%H:%M:%S.%f"),
}


def written(path, header, parts):
    rows = [f"{parts(k)},{','.join(f'{value:.9g}' for value in SAMPLES[k])}" for k in range(COUNT)]
    path.write_text("\n".join([f"{header},{','.join(AXES)}", *rows, ""]))
    return path


@pytest.mark.parametrize("header", PARTS)
def test_the_parts_of_a_stamp_are_one(tmp_path, header):
    path = written(tmp_path / "run.csv", header, PARTS[header])
    found = read(path, SETTINGS)
    np.testing.assert_allclose(found.log.index - found.log.index[0], times(COUNT), atol=2e-6)
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-8)
    assert any(one.startswith("stamps from ") for one in found.recognised)
    streamed = np.concatenate([part.index.to_numpy() for part in stream(path, SETTINGS)[1]])
    np.testing.assert_array_equal(streamed, found.log.index)


@pytest.mark.parametrize("header", ["time_s,time_ms", "seconds,milliseconds"])
def test_two_columns_of_one_time_in_two_units_are_not_added(tmp_path, header):
    whole = header.startswith("seconds")
    path = written(tmp_path / "run.csv", header, lambda k: f"{k // 100 if whole else k / 100},{10 * k}")
    found = read(path, SETTINGS)
    np.testing.assert_allclose(found.log.index, times(COUNT), atol=1e-9)


def test_times_of_day_as_numbers_are_refused(tmp_path):
    path = written(tmp_path / "run.csv", "date,time", lambda k: moment(k).strftime("%Y%m%d,%H%M%S.%f"))
    with pytest.raises(
        LogError, match="column time: expected seconds, or times of day as HH:MM:SS; found numbers HHMMSS"
    ):
        read(path, SETTINGS)


def test_a_clock_in_the_numbers_of_a_day_gives_way_to_one_that_runs(tmp_path):
    path = written(
        tmp_path / "run.csv", "time,millis", lambda k: f"{moment(k // 10 * 10).strftime('%H%M%S%f')[:9]},{10 * k}"
    )
    found = read(path, SETTINGS)
    np.testing.assert_allclose(found.log.index, times(COUNT), atol=1e-9)


def of_two_sensors(path):
    """Every 100th row holds a fix with stamps of its own, and no sample."""
    rows = []
    for k in range(COUNT):
        if k % 100 == 0:
            ahead = since(k) + 3_000_000
            rows.append(f"{ahead // 10**9},{ahead % 10**9},,,{48 + 1e-6 * k},11.5,500" + "," * len(AXES))
        samples = ",".join(f"{value:.9g}" for value in SAMPLES[k])
        rows.append(f",,{since(k) // 10**9},{since(k) % 10**9},,,,{samples}")
    header = "stamp_sec_gps,stamp_nsec_gps,stamp_sec_imu,stamp_nsec_imu,latitude,longitude,altitude"
    path.write_text("\n".join([f"{header},{','.join(AXES)}", *rows, ""]))
    return path


def test_of_two_sensors_in_one_file_each_has_its_rows_and_stamps(tmp_path):
    path = of_two_sensors(tmp_path / "run.csv")
    found = read(path, SETTINGS)
    np.testing.assert_allclose(found.log.index - since(0) / 1e9, times(COUNT), atol=2e-6)
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-8)
    assert "12 rows without stamp and sample: left out" in found.recognised
    streamed = np.concatenate([part.index.to_numpy() for part in stream(path, SETTINGS)[1]])
    np.testing.assert_array_equal(streamed, found.log.index)
    fixes = fixes_of(path)
    np.testing.assert_allclose(fixes.fixes.index - since(0) / 1e9, 0.003 + np.arange(12), atol=2e-6)
    assert f"{COUNT} rows without a fix: left out" in fixes.recognised
