import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from imugap import log
from imugap.kinematics.error_free import POSITION, QUATERNION, VELOCITY, error_free_log

G = 9.81
STEP = 0.01
TIME = np.arange(4000) * STEP
INNER = slice(50, -50)


def attitude(time):
    """A tumbling attitude, body to world."""
    return Rotation.from_euler("ZYX", np.column_stack([0.8 * time, 0.5 * np.sin(1.3 * time), 0.4 * np.cos(0.9 * time)]))


def true_rate(time, step=1e-5):
    """The angular rate in the body by a difference of attitudes over 20 us."""
    return (attitude(time - step).inv() * attitude(time + step)).as_rotvec() / (2 * step)


def position(time):
    return np.column_stack([2 * np.sin(0.7 * time), np.cos(1.1 * time), 0.3 * np.sin(2 * time)])


def acceleration(time):
    return np.column_stack([-0.98 * np.sin(0.7 * time), -1.21 * np.cos(1.1 * time), -1.2 * np.sin(2 * time)])


def poses(time=TIME, sign=1.0):
    """Poses with quaternions of any sign."""
    columns = dict(zip(QUATERNION, (sign * attitude(time).as_quat().T), strict=True))
    return pd.DataFrame(columns | dict(zip(POSITION, position(time).T, strict=True)), index=pd.Index(time, name="time"))


@pytest.mark.parametrize("sign", [1.0, np.where(np.arange(4000) % 3 == 0, -1.0, 1.0)])
def test_the_rate_is_the_derivative_of_the_attitude_in_the_body(sign):
    found = error_free_log(poses(sign=sign), TIME[INNER] + 0.3 * STEP, -G)
    assert np.abs(found[list(log.GYRO)] - true_rate(TIME[INNER] + 0.3 * STEP)).max().max() < 1e-5


@pytest.mark.parametrize("gravity", [-G, G])
def test_the_specific_force_is_acceleration_less_gravity_in_the_body(gravity):
    found = error_free_log(poses(), TIME[INNER], gravity)
    true = attitude(TIME[INNER]).inv().apply(acceleration(TIME[INNER]) - [0, 0, gravity])
    assert np.abs(found[list(log.ACCEL)] - true).max().max() < 2e-4


def test_a_device_at_rest_in_a_world_whose_third_axis_points_up_senses_gravity_upwards():
    still = pd.DataFrame(0.0, index=pd.Index(TIME, name="time"), columns=[*QUATERNION, *VELOCITY]).assign(quat_w=1.0)
    found = error_free_log(still, TIME, -G)
    np.testing.assert_allclose(found.to_numpy(), np.tile([0, 0, 0, 0, 0, G], (len(TIME), 1)), atol=1e-12)


def test_without_positions_there_are_gyroscopes_alone():
    found = error_free_log(poses()[list(QUATERNION)], TIME, -G)
    assert list(found) == list(log.GYRO)


def test_nothing_is_known_in_a_gap_between_poses_and_beyond_them():
    gone = (TIME > 10) & (TIME < 11)
    found = error_free_log(poses()[~gone], np.arange(-100, 4500) * STEP, -G)
    assert found.index[0] == 0.0
    assert found.index[-1] == pytest.approx(TIME[-1])
    assert not ((found.index > 10.005) & (found.index < 10.995)).any()
