"""Accelerations as phones state them: gravity in columns of its own, and gravity that points down."""

import numpy as np
import pytest
from tests.io.devices import at_rest, times, turned, write_text

from imugap.io.recognition.units import given_units
from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import LogError
from imugap.units import STANDARD_GRAVITY

SENSORLOG = [
    "accelerometerTimestamp_sinceReboot(s)", *(f"accelerometerAcceleration{axis}(G)" for axis in "XYZ"),
    "gyroTimestamp_sinceReboot(s)", *(f"gyroRotation{axis}(rad/s)" for axis in "XYZ"),
    "motionTimestamp_sinceReboot(s)", *(f"motionRotationRate{axis}(rad/s)" for axis in "XYZ"),
    *(f"motionUserAcceleration{axis}(G)" for axis in "XYZ"), *(f"motionGravity{axis}(G)" for axis in "XYZ"),
]  # fmt: skip
"""Columns of SensorLog on a phone of Apple."""
AS_IS = RecordingSettings(frame="as-is")


def apart(samples):
    """Gravity and what is left of the specific force [g], as Core Motion states them."""
    gravity = np.tile([0.6, 0.0, -0.8], (len(samples), 1))
    return -samples[:, 3:] / STANDARD_GRAVITY - gravity, gravity


@pytest.mark.parametrize("device", [at_rest, turned])
@pytest.mark.parametrize("first", [0, 8])
def test_the_specific_force_of_core_motion_points_up_at_rest(tmp_path, device, first):
    samples, time = device(), times()[:, None]
    user, gravity = apart(samples)
    columns = np.hstack([time, user + gravity, time, samples[:, :3], time, samples[:, :3], user, gravity])
    path = write_text(tmp_path / "phone.csv", SENSORLOG[first:], columns[:, first:], form="{:.12g}")
    found = read(path, AS_IS)
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-9, atol=1e-8)
    assert any("the sign from the names of Core Motion: gravity points down" in one for one in found.recognised)
    streamed = np.vstack([part.to_numpy() for part in stream(path, AS_IS)[1]])
    np.testing.assert_allclose(streamed, samples, rtol=1e-9, atol=1e-8)


def test_accelerations_of_core_motion_in_another_unit_are_refused_and_read_by_the_option(tmp_path):
    samples = turned()
    parts = [one * STANDARD_GRAVITY for one in apart(samples)]
    names = ["time", *(f"{name}.{axis}" for name in ("rotationRate", "userAcceleration", "gravity") for axis in "xyz")]
    path = write_text(tmp_path / "phone.csv", names, np.column_stack([times(), samples[:, :3], *parts]), form="{:.12g}")
    with pytest.raises(LogError, match=r"g by the names of Core Motion \(--units accel=m/s\^2, or accel=-m/s\^2"):
        read(path)
    found = read(path, RecordingSettings(units=given_units(["accel=-m/s^2"]), frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-9, atol=1e-8)


def test_linear_accelerations_and_gravity_are_added_where_their_sum_is_not_there(tmp_path):
    samples = at_rest()
    gravity = np.tile([0.0, 0.0, STANDARD_GRAVITY], (len(samples), 1))
    names = [f"{name}_{axis}" for name in ("gyro", "linear_acceleration", "gravity", "accel") for axis in "xyz"]
    columns = np.hstack([samples[:, :3], samples[:, 3:] - gravity, gravity, samples[:, 3:]])
    for count in (9, 12):
        path = write_text(
            tmp_path / "phone.csv", ["time", *names[:count]], np.column_stack([times(), columns[:, :count]]),
            form="{:.12g}",
        )  # fmt: skip
        found = read(path, AS_IS)
        np.testing.assert_allclose(found.log.to_numpy(), samples, rtol=1e-9, atol=1e-8)
        assert ("accel linear_acceleration_x + gravity_x and so on" in found.recognised) == (count == 9)
