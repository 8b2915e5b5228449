"""Logs in JSON."""

import json

import numpy as np
import pytest
from tests.io.devices import at_rest, times, turned

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

COUNT = 600
SAMPLES = at_rest(COUNT, up=(0, 0, -1))
START_NS = 1_700_000_000_123_456_789
RAD = RecordingSettings(units={"gyro": "rad/s"}, frame="as-is")


def rows():
    return [{"t": k / 100, **dict(zip(AXES, SAMPLES[k].tolist(), strict=True))} for k in range(COUNT)]


def nested(k):
    stamp = {"secs": (START_NS + 10**7 * k) // 10**9, "nsecs": (START_NS + 10**7 * k) % 10**9}
    values = SAMPLES[k].tolist()
    return {
        "header": {"stamp": stamp, "frame_id": "imu"}, "angular_velocity": dict(zip("xyz", values[:3], strict=True)),
        "linear_acceleration": dict(zip("xyz", values[3:], strict=True)), "valid": True,
    }  # fmt: skip


FORMS = {
    "lines": lambda: "".join(json.dumps(one) + "\n" for one in rows()),
    "array": lambda: json.dumps(rows(), indent=1),
    "inner array": lambda: json.dumps({"version": 1, "data": rows()}),
    "arrays by name": lambda: json.dumps({name: [one[name] for one in rows()] for name in ("t", *AXES)}),
    "arrays of axes": lambda: json.dumps(
        {"t": times(COUNT).tolist(), "gyro": SAMPLES[:, :3].tolist(), "accel": SAMPLES[:, 3:].tolist()}
    ),
    "nested": lambda: "".join(json.dumps(nested(k)) + "\n" for k in range(COUNT)),
    "axes as arrays": lambda: json.dumps(
        [{"t": k / 100, "gyro": SAMPLES[k, :3].tolist(), "acc": SAMPLES[k, 3:].tolist()} for k in range(COUNT)]
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_objects_and_arrays_are_columns(tmp_path, form):
    path = tmp_path / "run.json"
    path.write_text(FORMS[form]())
    found = read(path, RAD)
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-12)
    np.testing.assert_allclose(found.log.index - found.log.index[0], times(COUNT), atol=1e-6)


def of_sensors(samples, platform):
    """Records of Sensor Logger: all of one sensor, then all of the next, numbers as texts."""
    yield {"sensor": "Metadata", "platform": platform, "version": "3"}
    for sensor, axes in (("Gyroscope", samples[:, :3]), ("AccelerometerUncalibrated", samples[:, 3:])):
        for k, values in enumerate(axes.tolist()):
            stamps = {"time": str(START_NS + 10**7 * k), "seconds_elapsed": str(k / 100)}
            yield {"sensor": sensor, **stamps, **{axis: repr(values["xyz".index(axis)]) for axis in "zyx"}}


@pytest.mark.parametrize(("platform", "sign"), [("android", 1), ("ios", -1)])
def test_records_of_sensor_logger_are_one_log(tmp_path, platform, sign):
    path = tmp_path / "phone.json"
    path.write_text(json.dumps(list(of_sensors(SAMPLES * [1, 1, 1, sign, sign, sign], platform))))
    found = read(path, RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-12)
    assert "records Gyroscope, AccelerometerUncalibrated" in found.recognised


def test_records_of_two_devices_are_taken_by_the_topic(tmp_path):
    path = tmp_path / "two.json"
    pairs = [{"device": name, **one} for one in rows() for name in ("left", "right")]
    path.write_text(json.dumps(pairs))
    with pytest.raises(LogError, match="column device: expected one device, or --topic with one of them: left, right"):
        read(path, RAD)
    found = read(path, RecordingSettings(units={"gyro": "rad/s"}, frame="as-is", topic="left"))
    np.testing.assert_allclose(found.log.to_numpy(), SAMPLES, rtol=1e-12)


def test_a_line_that_is_no_object_is_named_and_an_unended_one_left_out(tmp_path):
    path = tmp_path / "run.jsonl"
    text = FORMS["lines"]()
    path.write_text(text + '{"t": 6.0, "gyro_x"')
    assert any("left out the last line" in one for one in read(path, RAD).recognised)
    path.write_text(text + '{"t": 6.0, "gyro_x"\n' + text)
    with pytest.raises(LogError, match=f"line {COUNT + 1}: expected an object in JSON"):
        read(path, RAD)


@pytest.mark.parametrize(
    "text", ["[[1, 2, 3], [4, 5, 6]]", '{"name": "imu", "version": 1}', '[{"a": "b"}, {"a": "c"}]']
)
def test_other_json_is_refused(tmp_path, text):
    path = tmp_path / "run.json"
    path.write_text(text)
    with pytest.raises(LogError, match="expected"):
        read(path)


def device_motion(samples):
    """Events of W3C DeviceMotion of a browser on Android: accelerations, and rates in deg/s."""
    for k, values in enumerate(samples.tolist()):
        rates = np.degrees(values[:3]).tolist()
        yield {
            "timeStamp": 10.0 * k, "interval": 10, "acceleration": {"x": 0.01, "y": 0.0, "z": -0.02},
            "accelerationIncludingGravity": dict(zip("xyz", values[3:], strict=True)),
            "rotationRate": dict(zip(("alpha", "beta", "gamma"), rates, strict=True)),
        }  # fmt: skip


def test_events_of_a_browser_have_gravity_and_degrees_and_their_sign_is_asked_for(tmp_path):
    path = tmp_path / "motion.json"
    samples = turned(COUNT * 2)
    path.write_text(json.dumps(list(device_motion(samples))))
    with pytest.raises(LogError, match=r"accel=m/s\^2, or accel=-m/s\^2 of iOS, decides"):
        read(path)
    for unit, sign in (("m/s^2", 1), ("-m/s^2", -1)):
        found = read(path, RecordingSettings(units={"accel": unit}, frame="as-is"))
        np.testing.assert_allclose(found.log.to_numpy(), samples * [1, 1, 1, sign, sign, sign], rtol=1e-9)
        assert "gyro deg/s -> rad/s from the header" in found.recognised


def test_rates_of_a_browser_about_z_x_and_y_are_refused(tmp_path):
    path = tmp_path / "motion.json"
    path.write_text(json.dumps(list(device_motion(turned(COUNT * 2)[:, [2, 0, 1, 3, 4, 5]]))))
    with pytest.raises(LogError, match="gravity turns as with gyro_y, gyro_z, gyro_x"):
        read(path, RecordingSettings(units={"accel": "m/s^2"}))


def test_a_file_that_memory_may_not_hold_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "run.json"
    with path.open("wb") as file:
        file.write(b'[{"t": 0')
        file.truncate((1 << 29) + 1)
    with pytest.raises(LogError, match=r"JSON of at most 512 MB.*write CSV or Parquet"):
        read(path)
