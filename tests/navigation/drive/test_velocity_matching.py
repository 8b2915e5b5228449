"""The attitude by velocity matching: that of the device, wherever it points, as exactly as it says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.drives import true_state

from imugap.log import GYRO
from imugap.navigation.drive.vehicle import DriveInputs
from imugap.navigation.drive.vehicle_alignment import align, velocity_pair

SEED = 57
TURN = Rotation.from_euler("z", 130, degrees=True)


def inputs(lap, assumptions, run, turn=None):
    record = lap.record(run, SEED)
    if turn is not None:
        record = record.copy()
        for triad in (list(GYRO), ["accel_x", "accel_y", "accel_z"]):
            record[triad] = turn.inv().apply(record[triad].to_numpy(copy=True))
    return DriveInputs(record, lap.fixes(run, SEED), lap.model, lap.ellipsoid, assumptions)


def test_the_attitude_is_as_exact_as_it_says(lap, assumptions):
    errors = []
    for run in range(20):
        pair = velocity_pair(inputs(lap, assumptions, run))
        for at in (25.0, 75.0, 185.0):
            found = pair.match(at)
            _, turn = true_state(lap, at)
            off = (found.rotation * turn[0].inv()).as_rotvec()
            errors.append(off**2 / np.diag(found.covariance))
            assert found.residual < 0.3 * found.change
    assert 0.2 < np.mean(errors) < 2.0


@pytest.mark.parametrize("turn", [None, TURN])
def test_a_device_that_does_not_point_along_the_course_starts_where_it_points(lap, assumptions, turn):
    """Mounted askew: the heading is that of the device, and not the course of the vehicle."""
    given = inputs(lap, replace(assumptions, lever_m=(0.0, 0.0, 0.0)), 1, turn)
    found = align(given)
    _, true = true_state(lap, found.time)
    off = (Rotation.from_quat(found.navigation[6:]) * (true[0] * (turn or Rotation.identity())).inv()).as_rotvec()
    std = np.sqrt(np.diag(found.covariance)[6:9])
    assert (np.abs(off) < 4 * std).all()
    assert std[2] < 0.3


def test_too_few_fixes_give_no_attitude(lap, assumptions):
    pair = velocity_pair(inputs(lap, assumptions, 1))
    assert replace(pair, time=pair.time[:4], velocity=pair.velocity[:4], std=pair.std[:4]).match(3.0) is None
