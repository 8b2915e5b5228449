"""Texts in which the first word of each line names a sensor."""

import numpy as np
import pytest
from tests.io.devices import at_rest, times

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

COUNT = 800
SAMPLES = at_rest(COUNT, up=(0, 0, -1))
START_NS = 4_123_000_000_000
GNSS_LOGGER = """#
# Header Description:
#
# Raw,utcTimeMillis,TimeNanos,LeapSecond
# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2,BiasYMps2
# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,DriftX
#
"""
RAD = RecordingSettings(units={"gyro": "rad/s"}, frame="as-is")


def lines(gyro, accel, separator=","):
    """Write a line of each sensor, by its words before the samples and after, for each sample."""
    for k in range(COUNT):
        for (before, after), values in ((gyro(k), SAMPLES[k, :3]), (accel(k), SAMPLES[k, 3:])):
            yield separator.join([*before, *(f"{value:.9g}" for value in values), *after]) + "\n"


def same(found):
    np.testing.assert_allclose(found.table[list(AXES)].to_numpy(), SAMPLES, rtol=1e-8)
    np.testing.assert_allclose(np.diff(found.table.index), np.diff(times(COUNT)), atol=1e-6)


def test_lines_of_gnss_logger_are_read_on_the_stamps_of_the_sensors(tmp_path):
    def stamps(k):
        return [str(1_700_000_000_000 + 10 * k + k % 3), str(START_NS + 10_000_000 * k)]

    body = list(
        lines(lambda k: (["UncalGyro", *stamps(k)], ["0.01"]), lambda k: (["UncalAccel", *stamps(k)], ["0.1", "0.1"]))
    )
    body.insert(3, "Raw,1700000000000,5,18\n")
    path = tmp_path / "gnss_log.txt"
    path.write_text(GNSS_LOGGER + "".join(body))
    found = read(path, RecordingSettings(frame="as-is"))
    same(found)
    assert "lines UncalGyro, UncalAccel" in found.recognised
    assert "gyro rad/s from the header" in found.recognised


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_lines_of_a_time_and_three_axes_need_no_names(tmp_path, separator):
    path = tmp_path / "run.txt"
    gyro, accel = (lambda k, tag=tag: ([tag, f"{k / 100:.2f}"], []) for tag in ("GYR", "ACC"))
    path.write_text("".join(lines(gyro, accel, separator)))
    same(read(path, RAD))
    found = read(path, RecordingSettings(units={"gyro": "deg/s"}, frame="as-is"))
    np.testing.assert_allclose(found.table["gyro_x"], np.radians(SAMPLES[:, 0]), rtol=1e-8)


def test_lines_of_more_values_without_names_are_refused(tmp_path):
    path = tmp_path / "run.txt"
    path.write_text("".join(lines(lambda k: (["GYR", f"{k / 100}"], ["3"]), lambda k: (["ACC", f"{k / 100}"], ["3"]))))
    with pytest.raises(LogError, match=r"lines of \w+: expected a comment with the names .*; found 5 values without"):
        read(path)


def test_a_bad_number_in_a_line_is_named(tmp_path):
    path = tmp_path / "run.txt"
    text = "".join(lines(lambda k: (["GYR", f"{k / 100}"], []), lambda k: (["ACC", f"{k / 100}"], [])))
    rows = text.splitlines(keepends=True)
    rows[100] = "GYR,0.5,x,0,0\n"
    path.write_text("".join(rows))
    with pytest.raises(LogError, match=r"run.txt: lines of GYR, line 52, column x: expected a number; found 'x'"):
        read(path, RAD)
