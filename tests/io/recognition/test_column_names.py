import pytest

from imugap.io.recognition.column_names import assign, chosen, meaning, unread
from imugap.log import ACCEL, AXES, GYRO

XYZ = "XYZ"


def triad(pattern):
    return [pattern.format(axis, axis.lower(), k) for k, axis in enumerate(XYZ)]


HEADERS = {
    "ASL": (["#timestamp [ns]", *triad("w_RS_S_{1} [rad s^-1]"), *triad("a_RS_S_{1} [m s^-2]")], "rad/s", "m/s^2"),
    "Kalibr": (["timestamp", *triad("omega_{1}"), *triad("alpha_{1}")], None, None),
    "rostopic": (
        ["%time", "field.header.stamp", *triad("field.orientation.{1}"), *triad("field.angular_velocity.{1}"),
         "field.angular_velocity_covariance0", *triad("field.linear_acceleration.{1}")],
        None, None,
    ),
    "x-io": (
        ["Time (s)", *triad("Gyroscope {0} (deg/s)"), *triad("Accelerometer {0} (g)"), *triad("Magnetometer {0} (uT)")],
        "deg/s", "g",
    ),
    "MTi": (
        ["PacketCounter", "SampleTimeFine", *triad("Acc_{0}"), "FreeAcc_E", "FreeAcc_N", "FreeAcc_U", *triad("Gyr_{0}"),
         *triad("Mag_{0}"), *triad("VelInc_{0}"), "Roll", "Pitch", "Yaw"],
        None, None,
    ),
    "PX4": (
        ["timestamp", *triad("gyro_rad[{2}]"), "gyro_integral_dt", "accelerometer_timestamp_relative",
         *triad("accelerometer_m_s2[{2}]"), "accelerometer_integral_dt"],
        "rad/s", "m/s^2",
    ),
    "ArduPilot": (["TimeUS", "I", *triad("Gyr{0}"), *triad("Acc{0}"), "EG", "EA", "GH", "AH"], None, None),
    "AndroSensor": (
        [*triad("ACCELEROMETER {0} (m/s²)"), *triad("GRAVITY {0} (m/s²)"), *triad("LINEAR ACCELERATION {0} (m/s²)"),
         *triad("GYROSCOPE {0} (rad/s)"), "Time since start in ms "],
        "rad/s", "m/s^2",
    ),
    "DeviceMotion": (
        ["timeStamp", *triad("acceleration.{1}"), *triad("accelerationIncludingGravity.{1}"),
         *(f"rotationRate.{letter}" for letter in ("alpha", "beta", "gamma"))],
        "deg/s", None,
    ),
    "flight dynamics": (
        ["time", *(f"{angle}Rate" for angle in ("Roll", "Pitch", "Yaw")), *triad("Accel{0}"), "Roll", "Pitch", "Yaw"],
        None, None,
    ),
    "NaveGo": (["imu.t", *triad("imu.fb_{1}"), *triad("imu.wb_{1}")], None, None),
    "Physics Toolbox": (["time", *triad("gF{1}"), *triad("w{1}")], None, None),
    "Arduino": (["t", *triad("a{1}"), *triad("g{1}"), *triad("m{1}")], None, None),
    "rocket": (
        ["timestamp_seconds", *triad("raw_acceleration_{1}_gs"), *triad("raw_rotated_acceleration_{1}_gs"),
         *triad("raw_angular_rate_{1}_deg_per_s"), "est_velocity_z_meters_per_s", "update_timestamp_ns"],
        "deg/s", "g",
    ),
    "letters": (
        [*triad("a_{1} [g]"), *triad("ar_{1} [rad/s]"), "Filtered ts [s]", *triad("m_{1} [G]")],
        "rad/s", "g",
    ),
    "flight controller": (["loopIteration", "time (us)", *triad("gyroADC[{2}]"), *triad("accSmooth[{2}]")], None, None),
    "suffixes": (["time_ms", *triad("gyro_{1}_dps"), *triad("acc_{1}_mg")], "deg/s", "mg"),
}  # fmt: skip


@pytest.mark.parametrize("name", HEADERS)
def test_the_header_of_every_common_logger_gives_six_axes_their_time_and_their_units(name):
    names, gyro, accel = HEADERS[name]
    found = assign(names)
    assert tuple(found.columns) == AXES
    assert found.units == {key: unit for key, unit in (("gyro", gyro), ("accel", accel)) if unit}
    assert found.times
    assert not found.contract
    assert not found.free


@pytest.mark.parametrize("name", HEADERS)
def test_axes_keep_their_letters_and_their_sensor(name):
    names, _, _ = HEADERS[name]
    columns = assign(names).columns
    for axes in (GYRO, ACCEL):
        read = [meaning(columns[axis]) for axis in axes]
        assert [one.axis for one in read] == [0, 1, 2]
        assert len({one.stem for one in read}) == 1
        assert {one.quantity for one in read} == {axes[0].split("_")[0]}


def test_canonical_names_are_the_contract():
    assert assign(["time", *AXES, "temperature"]).contract
    assert not assign(["time", *GYRO, "acc_x", "acc_y", "acc_z"]).contract


def test_increments_are_known_by_their_names():
    found = assign(["timestamp", *triad("delta_angle[{2}]"), *triad("delta_velocity[{2}]"), "delta_angle_dt"])
    assert found.units == {"gyro": "rad", "accel": "m/s"}
    assert tuple(found.columns) == AXES


@pytest.mark.parametrize(
    ("angles", "velocities"),
    [("dAng{0}", "dVel{0}"), ("DelAng{0}", "DelVel{0}"), ("delta_angle_{1}", "delta_velocity_{1}"),
     ("dtheta_{1}", "dv_{1}"), ("delang_{1}", "delvel_{1}"), ("dTheta{0}", "dV{0}"), ("dang{1}", "dvel{1}"),
     ("DeltaTheta{0}", "DeltaV{0}"), ("imu.delAng[{2}]", "imu.delVel[{2}]"), ("AngInc_{0}", "VelInc_{0}")],
)  # fmt: skip
def test_increments_have_many_names(angles, velocities):
    found = assign(["time", *triad(angles), *triad(velocities)])
    assert list(found.columns.values()) == [*triad(angles), *triad(velocities)]
    assert found.units == {"gyro": "rad", "accel": "m/s"}
    stated = assign(["time", *triad(angles + " [deg]"), *triad(velocities + " [m/s]")])
    assert stated.units == {"gyro": "deg", "accel": "m/s"}


def test_names_that_look_like_the_missing_axes_are_found():
    forces = [f"{axis} acceleration [g]" for axis in ("Longitudinal", "Lateral", "Vertical")]
    names = ["time", *triad("gyro_{1} [rad/s]"), *forces, "sample rate", "Vertical speed"]
    assert unread(names, assign(names)) == {"accel": forces}
    assert not unread(names[:5], assign(names[:5]))
    assert not unread([*names, *triad("acc_{1}")], assign([*names, *triad("acc_{1}")]))
    names = ["time", "gyro_x", "gyro_y", "gyro_vertical", *triad("acc_{1}")]
    assert unread(names, assign(names)) == {"gyro": ["gyro_vertical"]}


@pytest.mark.parametrize("names", [triad("FreeAcc_{0}"), triad("userAcceleration{0}(G)")])
def test_accelerations_without_gravity_are_known_by_their_names(names):
    assert assign(["time", *names]).free


@pytest.mark.parametrize(
    ("name", "unit"),
    [(f"accel_x [{unit}]", unit) for unit in ("V", "foo", "0.1 g", "dam/s^2", "1e-3 m/s^2", "kgf", "ugal")]
    + [(f"gyro_x ({unit})", unit) for unit in ("mV", "Hz", "0.01 deg/s", "kdps", "volts")]
    + [("gyro_x_mV", "mV"), ("gyro x, mV", "mV"), ("mV_gyro_x_mV", "mV"), ("accel_z (mGal)", "mGal"),
       ("fx_mGal", "mGal"), ("accel x [milli-g]", "mg")],
)  # fmt: skip
def test_a_text_that_is_written_as_a_unit_is_kept(name, unit):
    assert meaning(name).unit == unit


@pytest.mark.parametrize(
    "words", ["[x]", "(calibrated)", "[calibrated]", "(body)", "[FLU]", "[imu]", "(IMU 1)", "(16g)", "[left]", "(b)",
              "[NED]", "(200g)", "[2]"],
)  # fmt: skip
def test_words_in_brackets_that_are_no_unit_are_none(words):
    assert [meaning(f"{name}_y {words}").unit for name in ("gyro", "accel")] == [None, None]


def test_a_temperature_in_a_unit_that_is_not_known_is_left_out():
    assert meaning("Temp [0.01 degC]") is None
    assert meaning("Temp [°C]").unit == "degC"


def test_of_two_sensors_neither_is_taken():
    with pytest.raises(ValueError, match=r"--columns decides.*imu0_gyro_x.* or imu1_gyro_x"):
        assign(["time", *triad("imu0_gyro_{1}"), *triad("imu1_gyro_{1}")])


def test_a_counter_is_no_time():
    found = assign(["n_samples", *triad("gyr_{1}")])
    assert not found.times
    assert found.counters == ("n_samples",)


def test_columns_are_named_from_left_to_right_by_pairs_or_by_choice():
    nameless = ("", "", "", "")
    assert chosen(nameless, ["time", "-", "gyro_x", "gyro_y"]) == ("time", "-", "gyro_x", "gyro_y")
    names = ("time", "rate", "wx", "wy")
    assert chosen(names, ["gyro_z=rate", "time=time"]) == ("time", "gyro_z", "-", "-")
    assert chosen(names, ["time", "gyro_x"]) == ("time", "-", "wx", "-")
    with pytest.raises(ValueError, match=r"found 'wz' \(did you mean w"):
        chosen(names, ["time", "wz"])
    with pytest.raises(ValueError, match="expected 4 names, one for each column; found 2"):
        chosen(nameless, ["time", "gyro_x"])


def test_p_q_and_r_are_body_rates_where_there_are_all_three():
    found = assign(["flight.time", "flight.p", "flight.q", "flight.r", "flight.ax", "flight.ay", "flight.az"]).columns
    assert [found[axis] for axis in GYRO] == ["flight.p", "flight.q", "flight.r"]
    assert not set(GYRO) & set(assign(["time", "p", "q", "ax", "ay", "az"]).columns)
    assert assign(["time", "p", "q", "r", "wx", "wy", "wz"]).columns["gyro_x"] == "wx"
    assert assign(["t", "p (deg/s)", "q (deg/s)", "r (deg/s)"]).units == {"gyro": "deg/s"}
    assert not assign(["t", "p (Pa)", "q (deg/s)", "r (deg/s)"]).columns


@pytest.mark.parametrize("pattern", ["imu 1: {}.{} 1", "{}{}_2", "{}[{}] sensor 0"])
def test_a_number_beside_a_letter_is_no_axis(pattern):
    columns = assign(["t", *(pattern.format(name, axis) for name in ("GYRO", "ACC") for axis in XYZ)]).columns
    assert [columns[axis] for axis in AXES] == [pattern.format(name, axis) for name in ("GYRO", "ACC") for axis in XYZ]


@pytest.mark.parametrize("first", [0, 1])
def test_numbered_axes_count_from_zero_or_one(first):
    names = [f"{name}_{first + k}" for name in ("AngularVelocity", "Acceleration") for k in range(3)]
    assert list(assign(["Time", *names]).columns.values()) == names


def test_the_axis_may_stand_first():
    names = ["xgyro", "ygyro", "zgyro", "xacc", "yacc", "zacc"]
    assert list(assign(["time_boot_ms", *names, "xmag", "ymag", "zmag"]).columns.values()) == names


@pytest.mark.parametrize("name", ["Accel X (LSB)", "Accel X [counts]", "accel_x_lsb", "accel x (raw)"])
def test_counts_are_no_unit(name):
    assert meaning(name).unit == "counts"


def test_a_unit_that_is_not_known_is_kept_and_one_of_another_quantity_is_of_no_sensor():
    assert meaning("Gyro X [furlong/h]").unit == "furlong/h"
    assert meaning("Gyro X (left)").unit is None
    assert meaning("Accel X [deg/s]") is None


@pytest.mark.parametrize("name", ["GpsTow", "SOW", "iTOW", "Zeit", "X_Value"])
def test_times_of_a_week_and_of_other_languages_are_times(name):
    assert assign([name, *AXES]).times == (name,)


def test_forces_in_g_are_no_rates():
    assert set(assign(["time", *triad("gForce{0}"), *triad("rot{0}")]).columns) == set(ACCEL)


def test_of_accelerations_with_and_without_gravity_those_with_it_are_taken():
    found = assign(["t", *triad("acceleration.{1}"), *triad("accelerationIncludingGravity.{1}")])
    assert found.columns["accel_x"] == "accelerationIncludingGravity.x"
    assert found.unsigned
    assert not found.free


def test_letters_without_a_rate_are_angles():
    assert set(assign(["t", "alpha", "beta", "gamma", *triad("acc{0}")]).columns) == set(ACCEL)


@pytest.mark.parametrize("form", ["{}rate", "{}_rate", "{}Rate", "{}rate_rad_s", "gyro {} rate [rad/s]"])
def test_rates_are_named_by_the_angle_that_they_turn(form):
    found = assign(["time", *(form.format(one) for one in ("roll", "pitch", "yaw")), "roll", "pitch", "yaw"])
    assert found.columns == {axis: form.format(one) for axis, one in zip(GYRO, ("roll", "pitch", "yaw"), strict=True)}
