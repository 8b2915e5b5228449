import numpy as np
import pytest

from imugap.interchange.start_bias import known_biases, start_bias
from imugap.kinematics.earth import ROTATION_RATE
from imugap.log import ACCEL, GYRO

GRAVITY = 9.8


def accel(*force):
    found = start_bias(dict(zip(ACCEL, force, strict=True)), GRAVITY)
    return np.array([[found[axis][0].value, found[axis][1].std] for axis in ACCEL])


def test_gyroscopes_start_at_their_level_and_are_as_uncertain_as_the_largest():
    found = start_bias(dict(zip(GYRO, (1e-3, -5e-3, 0.0), strict=True)), GRAVITY)
    assert [found[axis][0].value for axis in GYRO] == [1e-3, -5e-3, 0.0]
    assert [found[axis][1].std for axis in GYRO] == [5e-3] * 3
    assert start_bias({"gyro_x": 1e-9}, GRAVITY)["gyro_x"][1].std == ROTATION_RATE


def test_accelerometers_show_the_bias_along_gravity_and_a_level_across_it():
    found = accel(0.1, -0.05, -9.7)
    assert found[2, 0] == pytest.approx(0.1, abs=2e-3)
    assert np.abs(found[:2, 0]).max() < 2e-3
    assert found[:, 1] == pytest.approx(0.1, rel=1e-6)


def test_the_known_biases_are_those_of_the_gyroscopes_and_along_gravity():
    levels = {"gyro_y": 1e-3, **dict(zip(ACCEL, (0.1, -0.05, -9.7), strict=True))}
    assert known_biases(levels, GRAVITY) == {"gyro_y": 1e-3, "accel": pytest.approx(-0.0994, abs=1e-3)}
    assert known_biases({"accel_z": -9.7}, GRAVITY) == {}


def test_a_device_that_is_not_level_is_as_uncertain_as_gravity():
    assert accel(5.0, 0.0, -np.sqrt(GRAVITY**2 - 25))[:, 1] == pytest.approx(0.043)


def test_accelerometers_whose_gravity_was_removed_show_no_bias():
    levels = dict(zip((*GYRO, *ACCEL), (1e-3, 0.0, 0.0, 0.02, 0.0, -0.1), strict=True))
    assert set(known_biases(levels, GRAVITY)) == set(start_bias(levels, GRAVITY)) == {*GYRO}
