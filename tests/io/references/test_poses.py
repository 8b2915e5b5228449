import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from imugap.io.references.poses import read_biases, read_poses
from imugap.kinematics.error_free import POSITION, QUATERNION, VELOCITY
from imugap.log import AXES, LogError
from imugap.stream import stream

COUNT = 20
TIME = 1.4e9 + 0.005 * np.arange(COUNT)
XYZW = Rotation.from_rotvec(stream(1, "poses").normal(size=(COUNT, 3))).as_quat()
PLACE, SPEED = stream(2, "poses").normal(size=(2, COUNT, 3))
WXYZ = XYZW[:, [3, 0, 1, 2]]


def rows(*columns, separator=",", form="%.9f"):
    return "\n".join(separator.join(form % value for value in row) for row in np.column_stack(columns)) + "\n"


def nanoseconds(*columns):
    """Rows of an ASL table: the stamps are whole numbers."""
    stamps = [f"{round(time * 1e9)}" for time in TIME]
    return "".join(f"{a},{b}\n" for a, b in zip(stamps, rows(*columns).splitlines(), strict=True))


ASL = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []"
FILES = {
    "asl": f"{ASL}, v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]\n" + nanoseconds(PLACE, WXYZ, SPEED),
    "asl without a header": nanoseconds(PLACE, WXYZ, SPEED, np.zeros((COUNT, 6))),
    "tum": "# timestamp tx ty tz qx qy qz qw\n" + rows(TIME, PLACE, XYZW, separator=" "),
    "tum without a header": rows(TIME, PLACE, XYZW, separator=" "),
    "header, scalar first": "time;qw;qx;qy;qz;px;py;pz\n" + rows(TIME, WXYZ, PLACE, separator=";"),
    "header, scalar last": "Time (s)\tpos_x\tpos_y\tpos_z\tquat_x\tquat_y\tquat_z\tquat_w\n"
    + rows(TIME, PLACE, XYZW, separator="\t"),
}


@pytest.mark.parametrize("name", FILES)
def test_poses_are_recognised_by_their_content(tmp_path, name):
    path = tmp_path / "poses.csv"
    path.write_text(FILES[name])
    found = read_poses(path)
    np.testing.assert_allclose(found.index, TIME, atol=1e-6)
    np.testing.assert_allclose(found[list(QUATERNION)], XYZW, atol=1e-8)
    np.testing.assert_allclose(found[list(POSITION)], PLACE, atol=1e-8)
    if name.startswith("asl"):
        np.testing.assert_allclose(found[list(VELOCITY)], SPEED, atol=1e-8)


def test_the_biases_of_the_publisher_follow_the_velocities(tmp_path):
    path = tmp_path / "poses.csv"
    biases = stream(3, "biases").normal(size=(COUNT, 6))
    path.write_text(nanoseconds(PLACE, WXYZ, SPEED, biases))
    found = read_biases(path)
    assert list(found) == list(AXES)
    np.testing.assert_allclose(found, biases, atol=1e-8)
    path.write_text(nanoseconds(PLACE, WXYZ, SPEED))
    with pytest.raises(LogError, match="expected the 17 columns of an ASL table with biases; found 11"):
        read_biases(path)


def test_attitudes_alone_are_poses(tmp_path):
    path = tmp_path / "poses.csv"
    path.write_text("t,q_w,q_x,q_y,q_z\n" + rows(TIME, WXYZ))
    assert list(read_poses(path)) == list(QUATERNION)


def test_rows_without_a_number_are_left_out(tmp_path):
    path = tmp_path / "poses.csv"
    lines = FILES["header, scalar first"].splitlines()
    lines[5] = "1400000000.02;nan;nan;nan;nan;nan;nan;nan"
    lines[6] = lines[6].rsplit(";", 1)[0] + ";inf"
    path.write_text("\n".join(lines) + "\n")
    assert len(read_poses(path)) == COUNT - 2


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", "line 1: expected a header and rows of numbers; found an empty file"),
        (rows(TIME, PLACE), "4 columns"),
        (rows(TIME, PLACE, 2 * XYZW, separator=" "), "norm 2"),
        (rows(TIME[::-1], PLACE, XYZW, separator=" "), "1400000000.0"),
        (rows(TIME, PLACE, XYZW, separator=" ") + "1 2 3\n", "line 21: expected 8 values .*; found 3"),
        (rows(TIME, 1e300 * PLACE, XYZW, separator=" "), r"pose 0, column x: expected a number of at most 1e\+12"),
        ("time,px,py,pz,a,b,c,d\n" + rows(TIME, PLACE, XYZW), "line 1: expected names of a time and a quaternion"),
    ],
)
def test_what_is_no_table_of_poses_is_refused_in_one_line(tmp_path, text, found):
    path = tmp_path / "poses.csv"
    path.write_text(text)
    with pytest.raises(LogError, match=found):
        read_poses(path)
