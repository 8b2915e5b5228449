import numpy as np
import pytest
import scipy.io
from tests.io.devices import RATE, at_rest, times

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

SAMPLES = at_rest(up=(0, 0, -1))
TABLE = np.column_stack([times(), SAMPLES])


def same(found):
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-12)
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)


@pytest.mark.parametrize("table", [TABLE, TABLE.T], ids=["rows", "columns"])
def test_a_plain_array_needs_the_names_of_its_columns(tmp_path, table):
    path = tmp_path / "run.npy"
    np.save(path, table)
    with pytest.raises(LogError, match=r"--columns names them"):
        read(path)
    same(read(path, RecordingSettings(columns=("time", *AXES))))


def test_a_structured_array_has_its_names(tmp_path):
    path = tmp_path / "run.npy"
    np.save(path, np.rec.fromarrays(TABLE.T, names=["t", "wx", "wy", "wz", "ax", "ay", "az"]))
    same(read(path))


MATLAB = {
    "triads": {"imu_gyr": SAMPLES[:, :3], "imu_acc": SAMPLES[:, 3:], "time": times()[:, None], "other": np.arange(7.0)},
    "columns": dict(zip(["t", *AXES], TABLE.T, strict=True)),
    "structure": {"imu": {"t": times(), "gyro": SAMPLES[:, :3], "acc": SAMPLES[:, 3:]}},
    "labels": {
        "IMU": TABLE * [1e3, *[1] * 6],
        "IMU_label": np.array(["TimeMS", "GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"], dtype=object),
        "GPS": np.zeros((12, 3)),
    },
}  # fmt: skip


@pytest.mark.parametrize("kind", MATLAB)
def test_unmistakable_names_of_matlab_variables_are_enough(tmp_path, kind):
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, MATLAB[kind])
    same(read(path))


def test_columns_of_an_array_without_names_are_given_by_pairs(tmp_path):
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"imu": SAMPLES, "ts": times()[None]})
    pairs = ("time=ts", *(f"{axis}=imu[{k}]" for k, axis in enumerate(AXES)))
    same(read(path, RecordingSettings(columns=pairs)))


def test_several_recordings_in_one_array_are_refused(tmp_path):
    np.save(tmp_path / "runs.npy", np.zeros((3, 6, 40)))
    with pytest.raises(LogError, match=r"expected a table of samples .*--topic 0 to 2.*; found \(3, 6, 40\)"):
        read(tmp_path / "runs.npy", RecordingSettings(rate_hz=100.0))


def test_one_of_several_recordings_in_an_array_is_asked_for(tmp_path):
    np.save(tmp_path / "runs.npy", np.stack([2 * TABLE.T, TABLE.T]))
    found = read(tmp_path / "runs.npy", RecordingSettings(topic="1", columns=("time", *AXES)))
    same(found)
    assert "run 1" in found.recognised
    with pytest.raises(LogError, match="expected a table of samples"):
        read(tmp_path / "runs.npy", RecordingSettings(topic="2", columns=("time", *AXES)))


def test_the_rate_that_a_file_states_stands_for_stamps_that_it_lacks(tmp_path):
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"gyr": SAMPLES[:, :3], "acc": SAMPLES[:, 3:], "sampling_rate": RATE})
    found = read(path)
    same(found)
    assert f"no stamps, {RATE:g} Hz from sampling_rate" in found.recognised
    given = read(path, RecordingSettings(rate_hz=50.0))
    assert 1 / np.diff(given.log.index).mean() == pytest.approx(50)
    scipy.io.savemat(path, {"gyr": SAMPLES[:, :3], "acc": SAMPLES[:, 3:], "time": times(), "fs": 50.0})
    same(read(path))


def test_one_of_two_devices_in_a_file_is_asked_for(tmp_path):
    path = tmp_path / "run.mat"
    device = {"t": times(), "gyro": SAMPLES[:, :3], "acc": SAMPLES[:, 3:]}
    scipy.io.savemat(path, {"left": device, "right": {name: 2 * values for name, values in device.items()}})
    with pytest.raises(LogError, match="--topic what stands before the dot"):
        read(path)
    same(read(path, RecordingSettings(topic="left")))
    with pytest.raises(LogError, match=r"expected a group of columns .*: left, right; found hip"):
        read(path, RecordingSettings(topic="hip"))


def test_logs_of_ardupilot_are_named_with_the_next_step(tmp_path):
    (tmp_path / "00000001.BIN").write_bytes(b"\xa3\x95\x80\x80" + bytes(200))
    with pytest.raises(LogError, match=r"mavlogdump.* csv 00000001.BIN.*dataflash log of ArduPilot"):
        read(tmp_path / "00000001.BIN")
