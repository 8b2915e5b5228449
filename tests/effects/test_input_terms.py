from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.chance import mean_is
from tests.effects.simulated import conditions, held, inputs, moving

from imugap import log
from imugap.effects import (
    Conditions,
    GSensitivity,
    LeverArm,
    Misalignment,
    ScaleFactor,
    StanceMotion,
    TimeOffset,
    VibrationRectification,
)
from imugap.stream import stream


@pytest.mark.parametrize(("u", "expected"), [(2.0, 0.02 + 0.06 + 0.4), (-2.0, -0.02 + 0.06 + 0.4), (0.0, 0.0)])
def test_scale_factor_depends_on_the_own_input(u, expected):
    sequence = ScaleFactor(0.01, 0.03, 0.1).sample(held("gyro_y", gyro_y=u, gyro_x=5.0), stream(1))
    np.testing.assert_allclose(sequence, expected, rtol=1e-12, atol=1e-15)


def test_misalignment_takes_its_share_of_the_other_axes_of_the_triad():
    at = held("accel_y", accel_x=1.0, accel_y=50.0, accel_z=2.0, gyro_x=100.0)
    np.testing.assert_allclose(Misalignment(x=0.01, z=-0.02).sample(at, stream(1)), 0.01 - 0.04, rtol=1e-12)


def test_misalignment_to_the_own_axis_is_refused():
    with pytest.raises(ValueError, match=r"misalignment\.x: expected 0 on its own axis gyro_x; found 0\.1"):
        Misalignment(x=0.1).sample(held("gyro_x"), stream(1))


def test_misalignment_needs_only_the_axes_that_it_leans_to():
    at = inputs("gyro_x", gyro_x=np.zeros(5), gyro_y=np.ones(5))
    np.testing.assert_allclose(Misalignment(y=0.1).sample(at, stream(1)), 0.1)
    np.testing.assert_array_equal(Misalignment().sample(at, stream(1)), np.zeros(5))
    with pytest.raises(ValueError, match="misalignment: expected an error-free log with gyro_z; found none"):
        Misalignment(z=0.1).sample(at, stream(1))


def test_g_sensitivity_is_linear_in_the_specific_force():
    at = held("gyro_x", accel_x=1.0, accel_y=2.0, accel_z=-9.8)
    expected = 1e-3 - 2e-3 * 2 - 3e-3 * 9.8
    np.testing.assert_allclose(GSensitivity(1e-3, -2e-3, 3e-3).sample(at, stream(1)), expected, rtol=1e-12)


def test_vibration_rectification_is_the_coefficient_times_the_power_of_the_vibration():
    runs, count, std = 200, 401, np.array([0.5, 1.0, 2.0])
    found = np.empty((runs, count))
    for run in range(runs):
        force = std * stream(11, "vibration", run).standard_normal((count, 3)) + [0.0, 3.0, -9.8]
        at = inputs("accel_z", **dict(zip(log.ACCEL, force.T, strict=True)))
        found[run] = VibrationRectification(0.04).sample(at, stream(1))
    shares = np.array([50 / 51, 100 / 101, 50 / 51])  # centred: 50 samples on either side
    assert mean_is(found[:, [0, 200, -1]], 0.04 * np.sum(std**2) * shares, share=0.03)


def test_vibration_rectification_of_a_shock_lasts_for_its_window():
    shock = np.zeros(9)
    shock[4] = 1.0
    at = inputs("gyro_x", 0.25, accel_x=shock, accel_y=np.zeros(9), accel_z=np.full(9, -9.8))
    sequence = VibrationRectification(1.0).sample(at, stream(1))
    np.testing.assert_allclose(sequence, [0, 0, *[0.2 * 0.8] * 5, 0, 0], atol=1e-12)


def test_vibration_rectification_of_the_own_component_knows_no_other():
    at = moving(400, "accel_y")
    alone = at.ideal.assign(accel_x=0.0, accel_z=-9.8)
    own = VibrationRectification(0.04, own=1).sample(at, stream(1))
    np.testing.assert_allclose(own, VibrationRectification(0.04).sample(replace(at, ideal=alone), stream(1)))


@pytest.mark.parametrize("window", [1e4, 1e30])
def test_vibration_rectification_by_a_window_longer_than_the_log_is_that_of_the_log(window):
    at = moving(400, "accel_y")
    power = at.ideal[list(log.ACCEL)].var(ddof=0).sum()
    np.testing.assert_allclose(VibrationRectification(2.0, window).sample(at, stream(1)), 2 * power, rtol=1e-9)


def test_motion_slower_than_the_window_is_no_vibration():
    at = moving(400, "accel_y")
    buzz = stream(11, "buzz").standard_normal(400)
    shaken = replace(at, ideal=at.ideal.assign(accel_y=at.ideal["accel_y"] + buzz))
    still = replace(at, ideal=at.ideal.assign(accel_y=buzz))
    short = VibrationRectification(1.0, window=0.05, own=1)
    np.testing.assert_allclose(short.sample(shaken, stream(1)), short.sample(still, stream(1)), rtol=0.25)


def test_vibration_rectification_of_a_constant_force_is_zero():
    sequence = VibrationRectification(1.0).sample(held("gyro_x", accel_z=-9.8), stream(1))
    np.testing.assert_allclose(sequence, 0, atol=1e-12)


def test_lever_arm_is_the_acceleration_of_the_point_that_turns_with_the_body():
    interval, axis, arm = 1e-3, np.array([1.0, -2.0, 2.0]) / 3, np.array([0.1, -0.2, 0.3])
    time = interval * np.arange(2000)
    angle = 0.8 * np.sin(3 * time)
    rate = 0.8 * 3 * np.cos(3 * time)[:, None] * axis
    turns = Rotation.from_rotvec(angle[:, None] * axis)
    acceleration = np.gradient(np.gradient(turns.apply(arm), time, axis=0), time, axis=0)
    expected = turns.inv().apply(acceleration)
    columns = dict(zip(log.GYRO, rate.T, strict=True)) | {name: np.zeros(len(time)) for name in log.ACCEL}
    ideal = log.from_samples(columns, interval)
    for k, name in enumerate(log.ACCEL):
        at = Conditions(time, interval, None, name, ideal)
        found = LeverArm(*arm).sample(at, stream(1))
        np.testing.assert_allclose(found[5:-5], expected[5:-5, k], atol=1e-4)


def test_lever_arm_on_a_turntable_is_centripetal():
    sampled = {name: LeverArm(0.2, 0.0, 0.1).sample(held(name, gyro_z=3.0), stream(1)) for name in log.ACCEL}
    np.testing.assert_allclose(sampled["accel_x"], -(3.0**2) * 0.2, rtol=1e-12)
    np.testing.assert_allclose(sampled["accel_y"], 0.0, atol=1e-14)
    np.testing.assert_allclose(sampled["accel_z"], 0.0, atol=1e-14)


@pytest.mark.parametrize("offset", [0.0034, -0.0127])
def test_time_offset_delays_the_input(offset):
    at = moving(1000, "gyro_y")
    moved = TimeOffset(offset).sample(at, stream(1)) + at.ideal["gyro_y"].to_numpy()
    expected = 0.3 + 2 * np.sin(2 * np.pi * 0.4 * (at.time - offset) + 1)
    np.testing.assert_allclose(moved[5:-5], expected[5:-5], atol=1e-6)


def test_time_offset_of_whole_samples_shifts_and_holds_the_end():
    at = moving(50, "accel_x")
    input = at.ideal["accel_x"].to_numpy()
    late = TimeOffset(0.03).sample(at, stream(1)) + input
    np.testing.assert_allclose(late, np.r_[np.full(3, input[0]), input[:-3]], atol=1e-9)
    early = TimeOffset(-0.03).sample(at, stream(1)) + input
    np.testing.assert_allclose(early, np.r_[input[3:], np.full(3, input[-1])], atol=1e-9)


def test_misalignment_has_no_slope_to_its_own_axis():
    assert set(Misalignment().slopes(moving(9, "accel_y"))) == {"x", "z"}


def test_a_delay_has_no_slope_where_the_input_is_held():
    slope = TimeOffset(0.03).slopes(moving(50, "accel_x"))["offset"]
    np.testing.assert_array_equal(slope[:3], 0.0)
    assert np.all(slope[3:] != 0)


def test_stance_motion_leaves_the_log_alone():
    values = stream(1).standard_normal(9)
    np.testing.assert_array_equal(StanceMotion(0.1, 0.2).apply(values, conditions(9), stream(1)), values)


MOVED = ScaleFactor(0.1), Misalignment(x=0.1), GSensitivity(0.1, 0.1, 0.1), LeverArm(0.1, 0.1, 0.1), TimeOffset(0.1)


@pytest.mark.parametrize("effect", MOVED, ids=lambda effect: effect.name)
def test_an_effect_of_the_input_says_what_it_misses(effect):
    axis = "accel_z" if effect.name == "lever_arm" else "gyro_z"
    with pytest.raises(ValueError, match=rf"{effect.name}: expected conditions with an axis; found none"):
        effect.sample(conditions(9), stream(1))
    with pytest.raises(ValueError, match=rf"{effect.name}: expected conditions with an error-free log; found none"):
        effect.sample(Conditions(np.arange(9.0), 1.0, None, axis), stream(1))
    with pytest.raises(ValueError, match=rf"{effect.name}: expected an error-free log with .*; found none"):
        effect.sample(inputs(axis, accel_y=np.zeros(9)), stream(1))


def test_vibration_rectification_needs_all_three_components():
    poor = inputs("gyro_x", accel_x=np.zeros(9), accel_y=np.zeros(9))
    with pytest.raises(
        ValueError, match=r"vibration_rectification: expected an error-free log with accel_z; found none"
    ):
        VibrationRectification(1.0).sample(poor, stream(1))


@pytest.mark.parametrize(
    ("effect", "others"),
    [(GSensitivity(0.0, 0.0, 0.0), ("accel_x", "time")), (LeverArm(0.0, 0.0, 0.0), ("gyro_x", "time"))],
    ids=["g_sensitivity of gyroscopes", "lever_arm of accelerometers"],
)
def test_an_effect_of_one_sensor_is_refused_on_other_axes(effect, others):
    own = log.GYRO if effect.name == "g_sensitivity" else log.ACCEL
    for axis in others:
        with pytest.raises(ValueError, match=rf"{effect.name}: expected one of {', '.join(own)}; found {axis}"):
            effect.check_axis(axis)
