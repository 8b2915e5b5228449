"""What the tools of ROS print of messages."""

import numpy as np
import pytest
from tests.io.devices import at_rest

from imugap.io.recording import RecordingSettings, read
from imugap.log import LogError

COUNT = 300
START_NS = 1_600_000_000_003_456_789
AS_IS = RecordingSettings(frame="as-is")
PARTS = ("sec", "nanosec"), ("secs", "nsecs")


def stamps(k):
    return divmod(START_NS + k * 10_000_000, 10**9)


def record(k, values, parts, lists):
    """One message as it is printed, covariances as lists in one line or in lines."""
    zeros = " [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]" if lists else "".join(["\n- 0.0"] * 9)
    stamp = "".join(f"    {name}: {value}\n" for name, value in zip(parts, stamps(k), strict=True))
    yield f"header:\n  stamp:\n{stamp}  frame_id: imu\norientation:\n  x: 0.0\n  y: 0.0\n  z: 0.0\n  w: 1.0\n"
    yield f"orientation_covariance:{zeros}\n"
    for name, part in (("angular_velocity", values[:3]), ("linear_acceleration", values[3:])):
        axes = "".join(f"  {axis}: {value!r}\n" for axis, value in zip("xyz", part, strict=True))
        yield f"{name}:\n{axes}{name}_covariance:{zeros}\n"
    yield "---\n"


def printed(path, parts, lists):
    messages = ("".join(record(k, values, parts, lists)) for k, values in enumerate(at_rest(COUNT).tolist()))
    path.write_text("".join(messages))
    return path


@pytest.mark.parametrize("parts", PARTS)
@pytest.mark.parametrize("lists", [True, False])
def test_printed_messages_are_read_with_the_units_of_their_definition(tmp_path, parts, lists):
    found = read(printed(tmp_path / "imu.txt", parts, lists), AS_IS)
    np.testing.assert_array_equal(found.log.to_numpy(), at_rest(COUNT))
    np.testing.assert_allclose(np.diff(found.log.index), 0.01, atol=1e-6)
    assert {"gyro rad/s from the header", "accel m/s^2 from the header"} < set(found.recognised)


def test_a_message_that_is_cut_off_is_left_out(tmp_path):
    path = printed(tmp_path / "imu.txt", *PARTS[:1], lists=True)
    path.write_text(path.read_text()[:-60])
    assert len(read(path, AS_IS).log) == COUNT - 1


def test_a_message_with_other_fields_is_refused(tmp_path):
    path = printed(tmp_path / "imu.txt", *PARTS[:1], lists=True)
    path.write_text(
        path.read_text().replace("angular_velocity:\n  x", "angular_velocity:\n  q", 5).replace("  q:", "  x:", 4)
    )
    with pytest.raises(LogError, match=r"message 4: expected the fields of the first .*found angular_velocity\.q"):
        read(path, AS_IS)


def test_csv_without_a_header_has_the_fields_of_the_message(tmp_path):
    path = tmp_path / "imu.csv"
    zeros = ["0.0"] * 9
    lines = (
        ",".join(map(str, [*stamps(k), "imu_link", 0.0, 0.0, 0.0, 1.0, *zeros, *one[:3], *zeros, *one[3:], *zeros]))
        for k, one in enumerate(at_rest(COUNT).tolist())
    )
    path.write_text("\n".join([*lines, ""]))
    found = read(path, AS_IS)
    np.testing.assert_array_equal(found.log.to_numpy(), at_rest(COUNT))
    np.testing.assert_allclose(np.diff(found.log.index), 0.01, atol=1e-6)
