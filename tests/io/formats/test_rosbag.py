import sys

import numpy as np
import pytest
from tests.io.devices import RATE, at_rest, times

import imugap as ig
from imugap.io.fixes import reading
from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, GYRO, LogError

rosbag1 = pytest.importorskip("rosbags.rosbag1")
rosbag2 = pytest.importorskip("rosbags.rosbag2")
from rosbags.typesys import Stores, get_typestore  # noqa: E402

COUNT = 500
START_S = 1_700_000_000
ENDINGS = {"bag": ".bag", "db3": "", "mcap": ""}


def write_bag(path, kind, topics, stamped=True, others=()):
    """Write samples, shape (n, 6), of each topic as messages sensor_msgs/Imu, and other messages.

    ``others`` are topic, type, and a function from the types to pairs of a time [s] and the fields of a message.
    """
    store = get_typestore(Stores.ROS1_NOETIC if kind == "bag" else Stores.ROS2_HUMBLE)
    known = store.types
    vector, header = known["geometry_msgs/msg/Vector3"], known["std_msgs/msg/Header"]
    imu, stamp = known["sensor_msgs/msg/Imu"], known["builtin_interfaces/msg/Time"]
    level = known["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    if kind == "bag":
        writer, serialize = rosbag1.Writer(path), store.serialize_ros1
    else:
        plugin = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer, serialize = rosbag2.Writer(path, version=9, storage_plugin=plugin), store.serialize_cdr
    none = np.zeros(9)

    def head(time, k):
        second, rest = divmod(time if stamped else 0, 10**9)
        extra = {"seq": k} if kind == "bag" else {}
        return header(stamp=stamp(sec=second, nanosec=rest), frame_id="imu", **extra)

    with writer:
        for topic, samples in topics.items():
            connection = writer.add_connection(topic, imu.__msgtype__, typestore=store)
            for k, row in enumerate(samples):
                time = START_S * 10**9 + round(k / RATE * 1e9)
                rate, force = (vector(*map(float, part)) for part in (row[:3], row[3:]))
                message = imu(head(time, k), level, none, rate, none, force, none)
                writer.write(connection, time + 1_000_000, serialize(message, imu.__msgtype__))
        for topic, name, made in others:
            connection = writer.add_connection(topic, name, typestore=store)
            for k, (second, fields) in enumerate(made(known)):
                time = START_S * 10**9 + round(second * 1e9)
                writer.write(connection, time, serialize(known[name](header=head(time, k), **fields), name))
    return path


@pytest.fixture(params=ENDINGS)
def kind(request):
    return request.param


def test_a_bag_of_either_version_gives_its_samples(tmp_path, kind):
    samples = at_rest(COUNT, up=(0, 0, -1))
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/imu": samples})
    found = read(path)
    np.testing.assert_array_equal(found.log.to_numpy(), samples)
    np.testing.assert_allclose(found.log.index, START_S + times(COUNT), atol=3e-7, rtol=0)
    assert "topic /imu" in found.recognised
    assert "stamps ns -> s from the header" in found.recognised
    if kind != "bag":
        (part,) = path.glob(f"*.{kind}")
        np.testing.assert_array_equal(read(part).log.to_numpy(), samples)


def test_of_two_topics_one_is_asked_for(tmp_path, kind):
    slow, fast = at_rest(COUNT, seed=1), at_rest(COUNT, seed=2)
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/camera/imu": slow, "/imu": fast})
    with pytest.raises(LogError, match=r"--topic decides\); found /camera/imu, /imu$"):
        read(path)
    found = read(path, RecordingSettings(topic="/imu", frame="as-is"))
    np.testing.assert_array_equal(found.log.to_numpy(), fast)
    with pytest.raises(LogError, match="found /camera/imu, /imu, not /gyro"):
        read(path, RecordingSettings(topic="/gyro"))


def test_without_stamps_in_the_headers_those_of_the_recorder_are_taken(tmp_path, kind):
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/imu": at_rest(COUNT)}, stamped=False)
    assert read(path).log.index[0] == pytest.approx(START_S + 0.001, abs=3e-7)


def thermometer(begin, per_second):
    """Return messages of a thermometer, one each half second."""
    return lambda known: [
        (0.5 * k, {"temperature": begin + per_second * 0.5 * k, "variance": 0.0})
        for k in range(int(2 * COUNT / RATE) + 2)
    ]


def test_a_file_for_kalibr_has_the_topic_of_the_bag(tmp_path, kind):
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/camera/imu": at_rest(20 * COUNT)})
    text = ig.estimate(path, terms=["white_noise", "random_walk"]).export("kalibr")
    assert "rostopic: /camera/imu\n" in text


def test_the_temperature_of_a_bag_is_interpolated_at_the_samples(tmp_path, kind):
    others = [
        ("/imu/temperature", "sensor_msgs/msg/Temperature", thermometer(25.0, 0.4)),
        ("/room/temperature", "sensor_msgs/msg/Temperature", thermometer(20.0, 0.0)),
    ]
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/imu/data": at_rest(COUNT)}, others=others)
    found = read(path)
    np.testing.assert_allclose(found.log["temperature"], 25 + 0.4 * times(COUNT), atol=1e-6)
    assert "temperature of /imu/temperature" in found.recognised


def fixes(known):
    """Return fixes of a receiver that goes east at 10 m/s, one a second."""
    status = known["sensor_msgs/msg/NavSatStatus"](status=0, service=1)
    east = 10 / (np.radians(1) * 6378137 * np.cos(np.radians(48)))
    place = {"status": status, "latitude": 48.0, "altitude": 500.0, "position_covariance": np.diag([4.0, 1, 9]).ravel()}
    return [(k, place | {"longitude": 11.5 + k * east, "position_covariance_type": 2}) for k in range(8)]


def twists(east, north):
    """Return velocities a hundredth of a second behind the fixes."""

    def made(known):
        vector = known["geometry_msgs/msg/Vector3"]
        twist = known["geometry_msgs/msg/Twist"](linear=vector(east, north, 0.5), angular=vector(0.0, 0.0, 0.0))
        return [(k + 0.01, {"twist": twist}) for k in range(7)]

    return made


def test_the_velocity_of_the_receiver_belongs_to_its_fixes_and_a_command_does_not(tmp_path, kind):
    others = [
        ("/fix", "sensor_msgs/msg/NavSatFix", fixes),
        ("/cmd_vel", "geometry_msgs/msg/TwistStamped", twists(0.0, 10.0)),
        ("/vel", "geometry_msgs/msg/TwistStamped", twists(10.0, 0.0)),
    ]
    found = reading.read(write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {}, others=others))
    np.testing.assert_array_equal(found.fixes[["vel_n", "vel_e", "vel_d"]][:7], [[0.0, 10.0, -0.5]] * 7)
    assert found.fixes["vel_e"].isna().tolist() == [False] * 7 + [True]
    np.testing.assert_allclose(found.fixes[["sd_n", "sd_e", "sd_d"]], [[1.0, 2.0, 3.0]] * 8)
    assert "velocity of /vel in east, north, up" in found.recognised
    assert "left out /cmd_vel" in found.recognised


def test_rates_in_degrees_against_the_definition_of_the_message_are_refused(tmp_path):
    samples = at_rest(COUNT, up=(0, 0, -1))
    samples[:, :3] = np.degrees(samples[:, :3])
    path = write_bag(tmp_path / "run.bag", "bag", {"/imu": samples})
    with pytest.raises(LogError, match=r"gyro=deg/s decides.*is it in deg/s\?"):
        read(path)


def test_a_damaged_bag_is_an_error_and_a_missing_package_is_named(tmp_path, monkeypatch):
    path = write_bag(tmp_path / "run.bag", "bag", {"/imu": at_rest(50)})
    (tmp_path / "half.bag").write_bytes(path.read_bytes()[:2000])
    with pytest.raises(LogError, match=r"half\.bag: file: expected a whole file"):
        read(tmp_path / "half.bag")
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    with pytest.raises(LogError, match=r"expected the package rosbags \(pip install 'imugap\[ros\]'\); found none"):
        read(path)


def test_rates_and_forces_of_two_topics_become_one_log(tmp_path, kind):
    samples = at_rest(COUNT, up=(0, 0, -1))
    rates, forces = samples.copy(), samples.copy()
    rates[:, 3:], forces[:, :3] = 0, 0
    topics = {"/camera/accel/sample": forces[::2], "/camera/gyro/sample": rates}
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, topics)
    found = read(path)
    assert "topic /camera/gyro/sample and /camera/accel/sample" in found.recognised
    for axis, one in found.regular.samples.items():
        own = rates if axis.startswith("gyro") else forces[::2]
        np.testing.assert_array_equal(one.values, own[:, list(AXES).index(axis)])
    alone = read(path, RecordingSettings(topic="/camera/gyro/sample")).regular
    assert set(alone.samples) == set(GYRO)


def test_two_topics_with_rates_and_forces_each_are_refused(tmp_path, kind):
    samples = at_rest(COUNT)
    path = write_bag(tmp_path / f"run{ENDINGS[kind]}", kind, {"/imu/data": samples, "/imu/data_raw": samples + 0.1})
    with pytest.raises(LogError, match=r"--topic decides\); found /imu/data, /imu/data_raw"):
        read(path)
