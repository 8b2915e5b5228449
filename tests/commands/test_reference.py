import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from imugap import cli, log
from imugap.discovery.preparation.reference_band import reference_band
from imugap.io import recording
from imugap.io.recognition.frame import AS_IS
from imugap.kinematics.error_free import POSITION, QUATERNION, error_free_log
from imugap.stream import stream

STEP, COUNT, G = 0.01, 3000, 9.80665
TIME = STEP * np.arange(COUNT)
MOUNTED = Rotation.from_euler("XYZ", [20, -10, 35], degrees=True)


def poses(up=True):
    """A tumbling and swaying body, in a world whose third axis points up or down."""
    angles = np.column_stack([0.8 * TIME, 0.5 * np.sin(1.3 * TIME), 0.4 * np.cos(0.9 * TIME)])
    attitude, place = Rotation.from_euler("ZYX", angles), np.column_stack([np.sin(0.7 * TIME), TIME, np.cos(2 * TIME)])
    if not up:
        flip = Rotation.from_euler("x", np.pi)
        attitude, place = flip * attitude, flip.apply(place)
    columns = dict(zip(QUATERNION, attitude.as_quat().T, strict=True)) | dict(zip(POSITION, place.T, strict=True))
    return pd.DataFrame(columns, index=pd.Index(TIME, name=log.TIME))


@pytest.fixture(scope="module")
def ideal():
    return error_free_log(poses(), TIME, -G)


def written(path):
    """The log in a file, in the axes of the file."""
    return recording.read(path, recording.RecordingSettings(frame=AS_IS)).log


def write_tum(path, table):
    path.write_text(table[[*POSITION, *QUATERNION]].to_csv(sep=" ", header=False))
    return str(path)


def write_log(path, ideal, turn=None):
    """The log of a device along the poses, whose axes are turned."""
    values = ideal.to_numpy(copy=True)
    if turn is not None:
        values = np.hstack([turn.inv().apply(values[:, :3]), turn.inv().apply(values[:, 3:])])
    noise = 1e-3 * stream(1, "log").normal(size=values.shape)
    log.write(pd.DataFrame(values + noise, index=ideal.index, columns=ideal.columns), path)
    return str(path)


@pytest.mark.parametrize("up", [True, False])
def test_the_error_free_log_of_poses_in_a_world_up_or_down_is_written(tmp_path, ideal, up, capsys):
    out = tmp_path / "ideal.parquet"
    arguments = [write_tum(tmp_path / "poses.txt", poses(up)), "--log", write_log(tmp_path / "log.csv", ideal)]
    assert cli.main(["reference", *arguments, "--out", str(out)]) == 0
    np.testing.assert_allclose(written(out)[list(ideal)], ideal, atol=2e-4)
    assert "can be trusted at all frequencies" in capsys.readouterr().out


def test_turned_axes_are_refused_until_they_are_to_be_aligned(tmp_path, ideal, capsys):
    out = tmp_path / "ideal.csv"
    measured = write_log(tmp_path / "log.csv", ideal, MOUNTED)
    arguments = ["reference", write_tum(tmp_path / "poses.txt", poses()), "--log", measured, "--out", str(out)]
    assert cli.main(arguments) == 1
    angle = np.degrees(MOUNTED.magnitude())
    assert f"found them turned by {angle:.1f} deg" in capsys.readouterr().err
    assert not out.exists()
    assert cli.main([*arguments, "--align"]) == 0
    turned = np.hstack([MOUNTED.inv().apply(ideal.to_numpy(copy=True)[:, some]) for some in (slice(3), slice(3, 6))])
    np.testing.assert_allclose(written(out)[list(ideal)], turned, atol=5e-3)


@pytest.mark.filterwarnings("error")
def test_a_motion_about_one_axis_leaves_the_axes_as_they_are(tmp_path):
    columns = dict(zip(QUATERNION, Rotation.from_euler("Z", np.sin(TIME)[:, None]).as_quat().T, strict=True))
    turning = pd.DataFrame(columns | dict.fromkeys(POSITION, 0.0), index=pd.Index(TIME, name=log.TIME))
    out = tmp_path / "ideal.csv"
    about_z = error_free_log(turning, TIME, -G)
    measured = write_log(tmp_path / "log.csv", about_z)
    arguments = [write_tum(tmp_path / "poses.txt", turning), "--log", measured, "--out", str(out)]
    assert cli.main(["reference", *arguments]) == 0
    np.testing.assert_allclose(written(out)[list(about_z)], about_z, atol=2e-4)


@pytest.mark.filterwarnings("error")
def test_an_axis_without_any_motion_or_noise_is_compared_without_a_warning():
    still = dict.fromkeys(log.AXES, np.zeros(COUNT))
    ideal = log.from_samples(still | {"gyro_z": np.sin(TIME)}, STEP)
    assert reference_band(ideal.assign(gyro_x=1e-3), ideal, STEP) is None


def test_a_lag_moves_the_motion_to_later_stamps(tmp_path, ideal):
    out = tmp_path / "ideal.csv"
    arguments = [write_tum(tmp_path / "poses.txt", poses()), "--log", write_log(tmp_path / "log.csv", ideal)]
    assert cli.main(["reference", *arguments, "--lag", "0.05", "--out", str(out)]) == 0
    found = written(out)
    np.testing.assert_allclose(found.index[0], 0.05, atol=1e-9)
    np.testing.assert_allclose(found.to_numpy(), ideal.iloc[:-5].to_numpy(), atol=2e-3)


def test_poses_of_another_time_are_refused(tmp_path, ideal, capsys):
    later = poses().set_axis(pd.Index(TIME + 1e4, name=log.TIME))
    arguments = [write_tum(tmp_path / "poses.txt", later), "--log", write_log(tmp_path / "log.csv", ideal)]
    assert cli.main(["reference", *arguments, "--out", str(tmp_path / "ideal.csv")]) == 1
    assert "expected times of the log, 0 to 29.99 s" in capsys.readouterr().err
