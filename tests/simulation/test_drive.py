"""The simulated drive: truth and ideal output are one under the navigator, and the antenna is where the arm has it."""

from dataclasses import replace

import numpy as np
import pytest

from imugap.io import gnss
from imugap.io.references import reference
from imugap.kinematics.strapdown import ATTITUDE, POSITION, VELOCITY, NavigationState, trajectory
from imugap.log import AXES, GYRO
from imugap.numerics.rotation import from_euler

SEED = 41


@pytest.mark.parametrize("rate_hz", [100, 20])
def test_the_navigator_drives_the_ideal_output_along_the_truth(lap, rate_hz):
    """Inverse mechanisation: what is left is rounding, at any rate."""
    truth, ideal = replace(lap, rate_hz=rate_hz).path
    start = NavigationState(attitude=tuple(truth[list(ATTITUDE)].iloc[0]))
    found = trajectory(ideal, start, lap.ellipsoid)
    linear = [*POSITION, *VELOCITY]
    assert np.abs(found[linear] - truth[linear]).to_numpy().max() < 1e-7
    turn = from_euler(found[list(ATTITUDE)].to_numpy()) * reference.rotations(truth).inv()
    assert np.abs(turn.as_rotvec()).max() < 1e-11


def test_the_drive_is_one_of_a_car(lap):
    """It rests, drives as fast as it is told, ends at rest, turns by one round, and stays within what tyres hold."""
    truth, ideal = lap.path
    speed = np.linalg.norm(truth[list(VELOCITY)], axis=1)
    assert speed.max() == pytest.approx(max(leg.speed_m_per_s for leg in lap.legs), rel=0.02)
    assert speed[[0, -1]].max() < 1e-4  # the body still settles
    assert 30 < np.mean(speed < 0.1) * lap.duration_s < 80
    heading = np.unwrap(truth["heading"])
    assert np.degrees(heading[-1] - heading[0]) == pytest.approx(sum(leg.turn_deg for leg in lap.legs), abs=1e-6)
    assert np.abs(ideal[["accel_x", "accel_y"]]).to_numpy().max() < 6
    assert ideal["accel_z"].mean() == pytest.approx(-9.81, abs=0.02)


def test_the_axle_goes_along_the_road_but_for_its_slip(lap):
    """In ``b``: outward by the slip angle in a turn, and nowhere else; the device itself swings out by its arm."""
    truth, ideal = lap.path
    rate = (ideal[list(GYRO)].to_numpy() + np.roll(ideal[list(GYRO)].to_numpy(), -1, axis=0)) / 2
    turn = reference.rotations(truth)
    own = turn.inv().apply(truth[list(VELOCITY)].to_numpy(float))
    axle = own + np.cross(rate - turn.inv().apply([4.9e-5, 0, -5.4e-5]), lap.axle.arm_m)
    slip = -lap.axle.slip * axle[:, 0] ** 2 * rate[:, 2]
    assert np.abs(axle[1:-1, 1] - slip[1:-1]).max() < 0.15 * np.abs(slip).max()
    assert np.abs(own[:, 1]).max() > 4 * np.abs(axle[:, 1]).max()
    assert 0.02 < np.sqrt(np.mean(axle[:, 1] ** 2)) < lap.axle.std_m_per_s
    assert 0.02 < np.sqrt(np.mean(axle[:, 2] ** 2)) < lap.axle.std_m_per_s
    straight = replace(lap, axle=replace(lap.axle, arm_m=(0.0, 0.0, 0.0), slip=0.0)).path[0]
    along = reference.rotations(straight).inv().apply(straight[list(VELOCITY)].to_numpy(float))
    assert np.abs(along[:, 1]).max() < 0.01


def test_the_antenna_moves_as_its_position_does(lap):
    """Measured velocity against central differences of the measured position, at ten times the rate."""
    fast = replace(lap, receiver=replace(lap.receiver, rate_hz=10))
    true = fast.antenna()
    place = true[["north", "east", "down"]].to_numpy()
    slope = (place[2:] - place[:-2]) / 0.2
    assert np.abs(slope - true[list(VELOCITY)].to_numpy()[1:-1]).max() < 0.02
    truth = fast.path[0].loc[true.index]
    apart = reference.rotations(truth).inv().apply(place - truth[list(POSITION)].to_numpy(float))
    np.testing.assert_allclose(apart, np.tile(lap.receiver.lever_m, (len(apart), 1)), atol=1e-9)


def test_fixes_scatter_as_they_say(lap):
    fixes, true = lap.fixes(1, SEED), lap.antenna()
    off = (gnss.local(fixes, lap.ellipsoid) - true.to_numpy()) / gnss.deviations(fixes, (1, 1, 1), (1, 1, 1))
    assert np.abs(off.mean(axis=0)).max() < 4 / np.sqrt(len(off))
    assert np.abs(off.var(axis=0) - 1).max() < 4 * np.sqrt(2 / len(off))
    assert not lap.fixes(2, SEED).equals(fixes)
    assert lap.fixes(1, SEED).equals(fixes)


def test_a_delay_is_in_the_stamps(lap):
    late = replace(lap, receiver=replace(lap.receiver, delay_s=0.2)).fixes(1, SEED)
    np.testing.assert_allclose(late.index + 0.2, lap.fixes(1, SEED).index)


def test_scale_factors_differ_from_run_to_run_as_they_are_told(lap):
    found = np.array([[lap.device(run, SEED)[axis].effects[-1].error for axis in AXES] for run in range(200)])
    ratio = found.reshape(-1, 2, 3) / np.array(lap.scale_std)[:, None]
    assert abs(np.mean(ratio**2) - 1) < 4 * np.sqrt(2 / ratio.size)
    record, ideal = lap.record(1, SEED), lap.path[1]
    assert list(record.columns) == list(ideal.columns)
    white = (record - ideal)[list(GYRO)].diff().std() / np.sqrt(2 * lap.rate_hz)
    assert np.abs(white / 1e-4 - 1).max() < 0.05
