import numpy as np
import pytest
from tests.io.devices import RATE, at_rest, times, write_simulated, write_text

from imugap.io.formats.gnss_ins_sim import files
from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import AXES, GYRO, LogError

COUNT = 500
SAMPLES = at_rest(COUNT, up=(0, 0, -1))


def same(found):
    assert tuple(found.log) == AXES
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-12)
    np.testing.assert_allclose(found.log.index, times(COUNT), rtol=1e-12)


@pytest.mark.parametrize("prefix", ["", "ride_"])
def test_the_folder_or_any_of_its_three_files_is_one_log(tmp_path, prefix):
    folder = write_simulated(tmp_path / "run", SAMPLES, prefix)
    three = ["time.csv", "accel-0.csv", "gyro-0.csv"]
    for path in (folder, *(folder / f"{prefix}{name}" for name in three)):
        found = read(path)
        same(found)
        assert f"{', '.join(prefix + name for name in three)} read as one" in found.recognised
        assert {one.name for one in files(path)} == {prefix + name for name in three}


def test_a_log_is_read_in_parts_of_files_of_different_width(tmp_path):
    folder = write_simulated(tmp_path / "run", at_rest(60 * COUNT, up=(0, 0, -1)))
    parts = list(stream(folder)[1])
    assert len(parts) > 2
    assert sum(map(len, parts)) == 60 * COUNT


def test_one_of_several_runs_is_asked_for_or_given(tmp_path):
    folder = write_simulated(tmp_path / "run", SAMPLES, runs=("0", "1"))
    with pytest.raises(LogError, match=r"expected one run \(--topic decides\); found runs 0, 1$"):
        read(folder)
    with pytest.raises(LogError, match="runs 0, 1, not 2"):
        read(folder, RecordingSettings(topic="2"))
    same(read(folder, RecordingSettings(topic="1")))
    same(read(folder / "gyro-1.csv"))


def test_gyroscopes_alone_are_a_log(tmp_path):
    folder = write_simulated(tmp_path / "run", SAMPLES)
    (folder / "accel-0.csv").unlink()
    assert tuple(read(folder).log) == GYRO


def test_a_file_that_ends_before_the_others_is_refused(tmp_path):
    folder = write_simulated(tmp_path / "run", SAMPLES)
    lines = (folder / "gyro-0.csv").read_text().splitlines(keepends=True)
    (folder / "gyro-0.csv").write_text("".join(lines[:-100]))
    with pytest.raises(LogError, match=r"rows: expected as many in each file; found the end of gyro-0.csv after 400"):
        read(folder)


def test_a_fault_in_a_part_is_located_in_it(tmp_path):
    folder = write_simulated(tmp_path / "run", SAMPLES)
    path = folder / "accel-0.csv"
    path.write_text(path.read_text().replace("e+00\n", "e+x0\n", 1))
    with pytest.raises(LogError, match=r"accel-0.csv, line 2, column accel_z .*: expected a number; found '-9"):
        read(folder)


def test_files_of_other_loggers_with_such_names_are_read_alone(tmp_path):
    write_text(tmp_path / "time.csv", ["time"], times(COUNT)[:, None])
    write_text(tmp_path / "gyro-0.csv", ["time", *GYRO], np.column_stack([times(COUNT), SAMPLES[:, :3]]))
    found = read(tmp_path / "gyro-0.csv")
    assert tuple(found.log) == GYRO
    assert found.recognised == ()
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)
