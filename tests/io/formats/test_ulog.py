import numpy as np
import pytest
from tests.io.devices import RATE, at_rest, times, write_ulog

from imugap.io.recording import RecordingSettings, read
from imugap.log import GYRO, LogError

pytest.importorskip("pyulog")

COUNT = 300
SAMPLES = at_rest(COUNT, up=(0, 0, -1))
FIELDS = [
    ("timestamp", "<u8"), *((f"gyro_rad_{k}", "<f4") for k in range(3)),
    *((f"accelerometer_m_s2_{k}", "<f4") for k in range(3)), ("accelerometer_clipping", "<u1"),
]  # fmt: skip


def combined():
    rows = np.zeros(COUNT, FIELDS)
    rows["timestamp"] = np.round(5e6 + 1e6 * times(COUNT))
    for k, field in enumerate(rows.dtype.names[1:7]):
        rows[field] = SAMPLES[:, k]
    return rows


def one_sensor():
    rows = np.zeros(COUNT, [("timestamp", "<u8"), *((axis, "<f4") for axis in "xyz")])
    rows["timestamp"] = np.round(5e6 + 1e6 * times(COUNT))
    for k, axis in enumerate("xyz"):
        rows[axis] = SAMPLES[:, k]
    return rows


def test_the_samples_of_a_log_are_those_of_its_combined_message(tmp_path):
    found = read(write_ulog(tmp_path / "flight.ulg", {"sensor_combined": combined(), "sensor_gyro:1": one_sensor()}))
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-6, atol=1e-12)
    assert found.log.index[0] == 5
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)
    assert "message sensor_combined:0" in found.recognised


def test_one_sensor_of_a_log_is_asked_for_by_its_message(tmp_path):
    path = write_ulog(tmp_path / "flight.ulg", {"sensor_combined": combined(), "sensor_gyro:1": one_sensor()})
    found = read(path, RecordingSettings(topic="sensor_gyro:1"))
    assert tuple(found.log) == GYRO
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES[:, :3], rtol=1e-6, atol=1e-12)
    with pytest.raises(LogError, match=r"expected the message sensor_accel .*; found sensor_combined:0, sensor_gyro:1"):
        read(path, RecordingSettings(topic="sensor_accel"))
