"""Lines with a label before each number."""

import numpy as np
import pytest
from tests.io.devices import at_rest

from imugap.io.recording import RecordingSettings, read
from imugap.log import LogError

COUNT = 600
AS_IS = RecordingSettings(frame="as-is")
NO_STAMPS = RecordingSettings(frame="as-is", rate_hz=100.0)
BY_LINE = "t={t} ax={3:.7f} ay={4:.7f} az={5:.7f} gx={0:.7f} gy={1:.7f} gz={2:.7f}\n"
SEVERAL = (
    "Acceleration X: {3:.7f}, Y: {4:.7f}, Z: {5:.7f} m/s^2\n"
    "Rotation X: {0:.7f}, Y: {1:.7f}, Z: {2:.7f} rad/s\nTemperature: 25.31 degC\n\n"
)
PLOTTER = "aX:{3:.7f},aY:{4:.7f},aZ:{5:.7f},gX:{0:.7f},gY:{1:.7f},gZ:{2:.7f}\n"


def written(path, form, before=""):
    lines = (form.format(*values, t=10 * k) for k, values in enumerate(at_rest(COUNT).tolist()))
    path.write_text(before + "".join(lines))
    return path


@pytest.mark.parametrize(("form", "settings"), [(BY_LINE, AS_IS), (PLOTTER, NO_STAMPS), (SEVERAL, NO_STAMPS)])
def test_labels_are_the_names_of_columns(tmp_path, form, settings):
    found = read(written(tmp_path / "run.txt", form, "MPU6050 Found!\n"), settings)
    np.testing.assert_allclose(found.log.iloc[:, :6].to_numpy(), at_rest(COUNT), atol=1e-7)
    assert found.regular.interval == pytest.approx(0.01)


def test_the_unit_behind_a_line_is_that_of_its_labels(tmp_path):
    found = read(written(tmp_path / "run.txt", SEVERAL), NO_STAMPS)
    assert {"gyro rad/s from the header", "accel m/s^2 from the header"} < set(found.recognised)
    assert found.log["temperature"].iloc[0] == 25.31


def test_stamps_are_asked_for(tmp_path):
    with pytest.raises(LogError, match=r"labels: expected stamps .*--rate HZ"):
        read(written(tmp_path / "run.txt", PLOTTER))


def test_a_line_with_other_labels_is_refused_with_its_number(tmp_path):
    path = written(tmp_path / "run.txt", BY_LINE)
    lines = path.read_text().splitlines(keepends=True)
    lines[400] = lines[400].replace("ay=", "ayy=")
    path.write_text("".join(lines))
    with pytest.raises(LogError, match=r"line 401: expected the labels t, ax, ay"):
        read(path, AS_IS)


def test_messages_may_stand_between_the_records(tmp_path):
    found = read(written(tmp_path / "run.txt", f"Calibration status: sys 3, gyro 3, accel 0\n{BY_LINE}"), AS_IS)
    np.testing.assert_allclose(found.log.iloc[:, :6].to_numpy(), at_rest(COUNT), atol=1e-7)


def test_a_text_of_messages_alone_is_refused_with_the_first(tmp_path):
    path = tmp_path / "run.txt"
    path.write_text("Calibration status: sys 3, gyro 3\nready, waiting\n" * 9)
    with pytest.raises(LogError, match=r"line 2: expected rows of numbers, .* found 'ready, waiting'"):
        read(path)
