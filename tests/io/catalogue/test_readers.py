import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.io.catalogue.datasets import LOG, POSITIONS
from imugap.io.catalogue.readers import read_positions, read_raw, read_raw_table, read_reference, read_strides
from imugap.io.references import reference
from imugap.log import LogError, interval
from imugap.numerics.rotation import to_euler
from imugap.stream import stream


def lines(path, *rows, header):
    path.write_text("".join(f"{row}\n" for row in (header, *rows)), encoding="utf-8")
    return path


@settings(deadline=None)
@given(st.binary(max_size=300), st.sampled_from([".csv", ".parquet", ".rda", ".npy", ".mat"]))
def test_noise_is_an_error_and_nothing_else(sets, content, suffix):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log{suffix}"
        path.write_bytes(content)
        with pytest.raises(LogError):
            read_raw(path, sets["adis16405"], 1)


def write_recording(path, samples):
    """Write samples, shape (n, columns), in the format that the suffix names."""
    frame = pd.DataFrame(samples, columns=[f"Channel {k}" for k in range(samples.shape[1])])
    writers = {
        ".npy": lambda: np.save(path, samples),
        ".mat": lambda: scipy.io.savemat(path, {"imu": samples}),
        ".csv": lambda: frame.to_csv(path, index=False),
        ".parquet": lambda: frame.to_parquet(path),
    }
    writers[path.suffix]()
    return path


@pytest.mark.parametrize("suffix", [".npy", ".mat", ".csv", ".parquet"])
def test_every_raw_format_is_converted_and_evenly_sampled(tmp_path, sets, suffix):
    samples = stream(2, "raw").standard_normal((50, 6))
    log = read_raw(write_recording(tmp_path / f"raw{suffix}", samples), sets["adis16405"], 3)
    assert interval(log) == pytest.approx(0.01)
    assert log.index[0] == 0.0
    np.testing.assert_allclose(np.degrees(log["gyro_y"]), samples[:, 1])
    np.testing.assert_allclose(log["accel_z"] / 9.80665, samples[:, 5])


def test_a_time_column_and_any_order_of_columns_are_respected(tmp_path, sets):
    dataset = replace(sets["adis16405"], columns=("accel_x", "time", "gyro_z"))
    samples = np.array([[1.0, 0.5, 180.0], [2.0, 0.7, 90.0], [3.0, 0.8, 0.0]])
    log = read_raw(write_recording(tmp_path / "raw.npy", samples), dataset, 1)
    assert list(log.columns) == ["gyro_z", "accel_x"]
    assert list(log.index) == [0.5, 0.7, 0.8]
    np.testing.assert_allclose(log["gyro_z"], [np.pi, np.pi / 2, 0.0])
    np.testing.assert_allclose(log["accel_x"], [9.80665, 2 * 9.80665, 3 * 9.80665])


def test_one_array_of_many_runs_gives_each_its_own(tmp_path, sets):
    recordings = stream(3, "recordings").standard_normal((11, 3, 40))
    np.save(tmp_path / "runs.npy", recordings)
    for run in (1, 5, 11):
        log = read_raw(tmp_path / "runs.npy", sets["memsense_turnon"], run)
        np.testing.assert_allclose(np.degrees(log.to_numpy()), recordings[run - 1].T)
        assert interval(log) == pytest.approx(0.004)


@pytest.mark.parametrize("suffix", [".npy", ".mat", ".parquet"])
def test_a_truncated_raw_file_says_what_was_expected_and_found(tmp_path, sets, suffix):
    path = write_recording(tmp_path / f"raw{suffix}", np.ones((50, 6)))
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: size - 100])
    with pytest.raises(LogError) as failure:
        read_raw(path, sets["adis16405"], 1)
    assert failure.value.expected == f"3200168 bytes in {suffix} format"
    assert failure.value.found.startswith(f"{size - 100} bytes that cannot be read")


@pytest.mark.parametrize("shape", [(50, 5), (6, 50), (2, 6, 50), (50,)])
def test_an_array_of_another_shape_is_refused(tmp_path, sets, shape):
    np.save(tmp_path / "raw.npy", np.zeros(shape))
    with pytest.raises(LogError, match=r"shape: expected 1 recording\(s\) of 6 columns"):
        read_raw(tmp_path / "raw.npy", sets["adis16405"], 1)


def test_a_mat_file_of_two_arrays_is_ambiguous(tmp_path, sets):
    scipy.io.savemat(tmp_path / "raw.mat", {"left": np.ones((9, 6)), "right": np.ones((9, 6))})
    with pytest.raises(LogError, match="expected one array, found left, right"):
        read_raw(tmp_path / "raw.mat", sets["adis16405"], 1)


def write_trial(path, count=50, **arrays):
    """Write a file as those of ``broad`` are, with some arrays replaced (None: absent)."""
    rng = stream(7, "trial")
    known = {
        "imu_gyr": rng.standard_normal((count, 3)),
        "imu_acc": rng.standard_normal((count, 3)),
        "opt_quat": np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        "movement": np.zeros((count, 1), np.uint8),
        "info": "text",
    } | arrays
    scipy.io.savemat(path, {name: value for name, value in known.items() if value is not None})
    return path


def test_arrays_are_taken_by_name(tmp_path, sets):
    gyro = stream(8, "gyro").standard_normal((50, 3))
    table = read_raw(write_trial(tmp_path / "trial.mat", imu_gyr=gyro), sets["broad"], 6)
    np.testing.assert_allclose(table[["gyro_x", "gyro_y", "gyro_z"]], gyro)
    assert table.shape == (50, 6)
    with pytest.raises(LogError, match="expected an array imu_acc, found none"):
        read_raw(write_trial(tmp_path / "trial.mat", imu_acc=None), sets["broad"], 6)


def test_a_reference_turns_to_north_east_down_and_leaves_out_what_was_lost(tmp_path, sets):
    """A body whose axes point east, north, up has heading 90 deg and lies on its back."""
    quats, moving = np.tile([1.0, 0.0, 0.0, 0.0], (50, 1)), np.zeros((50, 1), np.uint8)
    quats[10:20], moving[30:] = np.nan, 1
    path = write_trial(tmp_path / "trial.mat", opt_quat=quats, movement=moving)
    known = read_reference(path, sets["broad"], 6)
    assert list(known.columns) == [*reference.QUATERNION, reference.MOVING]
    assert len(known) == 40
    assert known.index[10] == pytest.approx(20 * 0.0035)
    np.testing.assert_allclose(np.abs(to_euler(reference.rotations(known))), np.tile([np.pi, 0, np.pi / 2], (40, 1)))
    assert (to_euler(reference.rotations(known))[:, 2] > 0).all()
    assert reference.motion(known) == pytest.approx((30 * 0.0035, 49 * 0.0035))


@pytest.mark.parametrize(
    ("arrays", "found"),
    [
        ({"opt_quat": np.full((50, 4), np.nan)}, "50 rows of NaN"),
        ({"opt_quat": np.ones((50, 3))}, "4 in all"),
        ({"movement": None}, "expected an array movement, found none"),
    ],
)
def test_a_reference_that_is_none_is_named(tmp_path, sets, arrays, found):
    with pytest.raises(LogError, match=found):
        read_reference(write_trial(tmp_path / "trial.mat", **arrays), sets["broad"], 6)


def test_the_real_static_log_reads_as_at_rest(sets, mirror, tmp_path):
    file = sets["adis16405"].file(1)
    log = read_raw(file.place(mirror), sets["adis16405"], 1)
    assert log.shape == (1_000_000, 6)
    assert log["accel_z"].mean() / 9.80665 == pytest.approx(-1.0161, abs=1e-3)
    cut = tmp_path / file.name
    cut.write_bytes(file.place(mirror).read_bytes()[:100_000])
    with pytest.raises(LogError, match=r"expected 3200168 bytes in \.rda format; found 100000 bytes"):
        read_raw(cut, sets["adis16405"], 1)


def test_the_real_turn_on_means_scatter_as_published(sets, mirror):
    dataset = sets["memsense_turnon"]
    path = dataset.files[0].place(mirror)
    means = np.degrees([read_raw(path, dataset, run).mean().to_numpy() for run in dataset.runs])
    np.testing.assert_allclose(means.std(axis=0, ddof=1), [0.0008, 0.0006, 0.0022], atol=1e-4)


@pytest.mark.parametrize("run", [1, 6, 10, 24])
def test_the_real_trials_rest_level_with_z_up_and_agree_with_their_reference(sets, mirror, run):
    dataset = sets["broad"]
    path = dataset.file(run).place(mirror)
    table, known = read_raw(path, dataset, run), read_reference(path, dataset, run)
    first, last = reference.rests(table, known, 3.0)
    assert first["accel_z"].mean() == pytest.approx(9.87, abs=0.05)
    for rest in (first, last):
        up = reference.rotations(known.loc[rest.index[0] : rest.index[-1]]).inv().apply([0, 0, -1]).mean(axis=0)
        force = rest[["accel_x", "accel_y", "accel_z"]].mean().to_numpy()
        assert np.degrees(np.arccos(up @ force / np.linalg.norm(force) / np.linalg.norm(up))) < 0.3


@pytest.mark.parametrize("run", [1, 2])
def test_one_table_holds_a_recording_for_each_sensor(tmp_path, sets, run):
    """The left foot is run 1, the right run 2; units and order are those of the catalogue."""
    path = tmp_path / "imu_sample.csv"
    axes = ("acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z")
    head = ["sensor," + ",".join(side for _ in axes for side in ("left", "right"))]
    head += ["axis," + ",".join(axis for axis in axes for _ in (1, 2))]
    rows = [
        ",".join(map(str, [row, *(10 * number + side for number in range(6) for side in (1, 2))])) for row in (0, 1)
    ]
    path.write_text("\n".join(head + rows) + "\n")
    log = read_raw(path, sets["gaitmap_2x20m"], run)
    np.testing.assert_allclose(log.iloc[0, 3:], np.arange(3) * 10 + run)
    np.testing.assert_allclose(np.degrees(log.iloc[1, :3]), np.arange(3, 6) * 10 + run)
    assert interval(log) == pytest.approx(1 / 204.8)


def test_a_row_that_repeats_the_one_before_is_left_out_and_a_stamp_that_repeats_is_refused(tmp_path, sets):
    rows = ["0,1,2,3,0,0,1", "0,1,2,3,0,0,1", "0.0025,2,2,3,0,0,1", "0.005,3,2,3,0,0,1"]
    path = lines(tmp_path / "walk.csv", *rows, header="t,gx,gy,gz,ax,ay,az")
    log = read_raw(path, sets["xio_gait_tracking"], 1)
    np.testing.assert_allclose(np.degrees(log["gyro_x"]), [1, 2, 3])
    assert len(read_raw_table(path, sets["xio_gait_tracking"], 1)) == 4
    with pytest.raises(LogError, match="time that increases"):
        read_raw(
            lines(path, "0,1,2,3,0,0,1", "0,9,2,3,0,0,1", header="t,gx,gy,gz,ax,ay,az"), sets["xio_gait_tracking"], 1
        )


def test_a_recording_of_the_logger_is_read_between_its_bytes(tmp_path, sets):
    path = tmp_path / "data_inert.txt"
    row = "   0xcb   +0.1 +0.2 +1.0   +0.01 -0.02 +0.03   130516848   0x15fd   1 1274434048.503018"
    path.write_text("\r\nInertial data.\r\n\r\nHeader:   a_x [g]:\r\n" + f"{row}  +nan\r\n{row}\r\n")
    log = read_raw(path, sets["openshoe_kth"], 1)
    np.testing.assert_allclose(log.iloc[1], [0.01, -0.02, 0.03, *(9.80665 * np.array([0.1, 0.2, 1.0]))])
    assert len(log) == 2


def test_reference_positions_come_in_metres_north_east_down(tmp_path, sets):
    arrays = {"imu": np.zeros((3, 6)), "ts": np.array([[0.1, 0.2, 0.3]]), "gt": np.arange(9.0).reshape(3, 3)}
    scipy.io.savemat(tmp_path / "walk.mat", arrays)
    found = read_positions(tmp_path / "walk.mat", sets["pyshoe_vicon"], 4)
    np.testing.assert_allclose(found, arrays["gt"] * [1, 1, -1])
    np.testing.assert_allclose(found.index, [0.1, 0.2, 0.3])
    path = tmp_path / "mocap_sample.csv"
    path.write_text(",L_FCC,L_FCC,L_FCC,R_FCC,R_FCC,R_FCC\n,x,y,z,x,y,z\n0,1000,2000,30,4,5,6\n1,1,2,3,4000,5000,60\n")
    found = read_positions(path, sets["gaitmap_2x20m"], 2)
    np.testing.assert_allclose(found, [[0.004, -0.005, -0.006], [4, -5, -0.06]])
    assert found.index[1] == pytest.approx(0.01)


def test_the_strides_of_a_foot_come_in_seconds(tmp_path, sets):
    path = tmp_path / "stride_events_sample.csv"
    path.write_text("s_id,foot,start,end,ic\n0,left,2048,4096,1\n0,right,1024,3072,1\n1,right,3072,4096,1\n")
    found = read_strides(path, sets["gaitmap_2x20m"], 2)
    np.testing.assert_allclose(found, [[5, 15], [15, 20]])
    assert list(found.columns) == ["start", "end"]
    np.testing.assert_allclose(read_strides(path, sets["gaitmap_2x20m"], 1), [[10, 20]])


@pytest.mark.parametrize(
    ("name", "up"), [("openshoe_kth", 1), ("xio_gait_tracking", 1), ("gaitmap_2x20m", 1), ("pyshoe_vicon", -1)]
)
def test_the_real_walks_begin_with_a_stand_under_gravity_with_z_as_stated(sets, mirror, name, up):
    dataset = sets[name]
    for run in dataset.runs:
        stand = read_raw(dataset.file(run).place(mirror), dataset, run).iloc[:100].mean()
        force = stand[["accel_x", "accel_y", "accel_z"]]
        assert np.linalg.norm(force) == pytest.approx(9.81, abs=0.09)
        assert np.sign(force["accel_z"]) == up
        assert stand[["gyro_x", "gyro_y", "gyro_z"]].abs().max() < np.radians(1)


def test_a_foot_in_swing_rises_in_the_reference_positions(sets, mirror):
    """Down is what the accelerometers call down: in every walk the foot is for half of the time near its lowest."""
    for name in ("gaitmap_2x20m", "pyshoe_vicon"):
        dataset = sets[name]
        content = POSITIONS if dataset.position_rate_hz else LOG
        for run in dataset.runs:
            down = read_positions(dataset.file(run, content).place(mirror), dataset, run)["down"]
            assert 0.1 < down.median() - down.min() < 0.3
            assert down.max() - down.median() < 0.1
