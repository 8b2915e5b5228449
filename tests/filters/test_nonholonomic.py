"""Wheels that roll: what they tell is taken in as it should be, and they tell nothing where they skid."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.drives import navigation_error

from imugap.analysis.drive import RecordedDrive, navigate_drive
from imugap.analysis.drive_settings import SCHEMA, DriveSettings
from imugap.filters import nonholonomic
from imugap.filters.consistency import nees_band
from imugap.filters.error_state import ATTITUDE, NAVIGATION
from imugap.filters.error_state import VELOCITY as VELOCITY_ROWS
from imugap.filters.innovation_gate import NO_CONTROL, QualityControl
from imugap.filters.nonholonomic import SKID_SIGMA, SLOW_M_PER_S, WINDOW_S, WheelConstraint, quiet_epochs
from imugap.filters.sensor_states import SensorStates
from imugap.filters.smoother import SensorArrays, SmootherBlock
from imugap.io.configuration import configure
from imugap.kinematics.strapdown import VELOCITY
from imugap.log import ACCEL, AXES, GYRO
from imugap.navigation.drive.vehicle import DriveInputs, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.numerics.rotation import from_euler, mat_from_quat
from imugap.stream import stream

SEED = 141
RUNS = 40
OUTAGE = (150.0, 200.0)
"""In motion, with turns; the vehicle does not halt."""
OUTAGES = [(begin, begin + 50.0) for begin in (60.0, 120.0, 180.0, 240.0)]
"""On different parts of the way: the slip is the same in all runs of one part."""
AXLE = (-1.3, 0.2, 0.4)


@pytest.fixture(scope="module")
def rolling(lap, assumptions):
    axle = lap.axle
    return replace(assumptions, nonholonomic_std=axle.std_m_per_s, nonholonomic_s=axle.correlation_s, axle_m=axle.arm_m)


def drive(lap, assumptions, run, quality=NO_CONTROL, outage=OUTAGE, smooth=False):
    record, fixes = lap.record(run, SEED), lap.fixes(run, SEED)
    begin = align(DriveInputs(record, fixes, lap.model, lap.ellipsoid, assumptions))
    if outage:
        fixes = fixes[(fixes.index <= outage[0]) | (fixes.index > outage[1])]
    inputs = DriveInputs(record, fixes, lap.model, lap.ellipsoid, assumptions, quality)
    return navigate(inputs, begin, smooth)


def state(model, speed, sigma):
    """Return what the kernel needs of a vehicle that goes so fast, by its axle in ``b``, known to sigma."""
    states = SensorStates.of(model, (1e-3, 1e-3), np.inf)
    size = NAVIGATION + len(states)
    quat = from_euler(np.array([0.05, -0.1, 2.0])).as_quat()
    rate = np.array([0.02, -0.03, 0.3])
    velocity = Rotation.from_quat(quat).apply(np.array(speed) - np.cross(rate, AXLE))
    root = stream(SEED, "state").standard_normal((size, size)) / np.sqrt(size)
    scale = np.repeat([1.0, sigma, 1e-4, 1e-5, 1e-5], [3, 3, 3, 6, size - 15])
    covariance = scale[:, None] * (root @ root.T) * scale
    nav = (0.0, 0.0, 0.0), tuple(map(float, velocity)), tuple(map(float, quat))
    return nav, tuple(map(float, rate)), covariance, np.zeros(len(states)), SensorArrays.of(states)


def rolled(model, speed, sigma, still, interval=0.05, std=0.1):
    """Return navigation in ``b`` at the axle and covariance, before and after."""
    nav, rate, covariance, estimates, sensors = state(model, speed, sigma)
    size, gain = len(covariance), np.where(sensors.scale, 0.3, 1.0)
    before, row = covariance.copy(), np.zeros(size)
    after = nonholonomic.apply_wheel_constraint(
        WheelConstraint(std, 1.0, AXLE), still, interval, nav, rate, covariance, estimates, sensors, gain, row,
        np.empty(size), np.empty(size), SmootherBlock.empty(0, size), 0, 0,
    )[0:3]  # fmt: skip
    assert not row.any()
    turn = Rotation.from_quat(after[2]).inv()
    return turn.apply(after[1]) + np.cross(rate, AXLE), before, covariance


@pytest.mark.slow
def test_without_wheels_nothing_changes(lap, assumptions):
    """To the bit, whatever arm and correlation time are."""
    one = drive(lap, assumptions, 1, QualityControl())
    other = drive(lap, replace(assumptions, nonholonomic_s=7.0, axle_m=AXLE), 1, QualityControl())
    for name in ("navigation", "errors", "variances", "cross"):
        np.testing.assert_array_equal(getattr(one.history, name), getattr(other.history, name))
    np.testing.assert_array_equal(one.covariances, other.covariances)


@pytest.mark.parametrize("component", range(3))
def test_the_slope_is_that_of_the_velocity_of_the_axle(lap, component):
    """Against difference quotients in velocity, attitude and the errors of the gyroscopes."""
    nav, rate, covariance, _, sensors = state(lap.model, (8.0, 0.2, -0.1), 0.1)
    gain, row = np.where(sensors.scale, np.tile(rate, 4)[: len(sensors.axis)], 1.0), np.zeros(len(covariance))

    def slide(velocity, quat, rate):
        mat = mat_from_quat(quat)
        return nonholonomic.axle_velocity(component, (nav[0], velocity, quat), mat, rate, sensors, gain, AXLE, row)

    middle, step = slide(nav[1], nav[2], rate), 1e-6
    assert middle == pytest.approx((8.0, 0.2, -0.1)[component], abs=1e-9)
    told = row.copy()
    for m in range(3):
        pushed = tuple(np.array(nav[1]) + step * np.eye(3)[m])
        assert (slide(pushed, nav[2], rate) - middle) / step == pytest.approx(told[VELOCITY_ROWS + m], abs=1e-7)
        turned = Rotation.from_rotvec(step * np.eye(3)[m]) * Rotation.from_quat(nav[2])
        found = (slide(nav[1], tuple(turned.as_quat()), rate) - middle) / step
        assert found == pytest.approx(told[ATTITUDE + m], abs=1e-4)
    for s in np.flatnonzero(sensors.axis < 3):
        less = tuple(np.array(rate) - step * gain[s] * np.eye(3)[sensors.axis[s]])
        assert (slide(nav[1], nav[2], less) - middle) / step == pytest.approx(told[NAVIGATION + s], abs=1e-7)


def test_slip_is_taken_in_and_a_skid_is_left_out(lap):
    """Across and up fall towards zero; a component beyond what it may be is as if it had not been asked."""
    inside, before, after = rolled(lap.model, (8.0, 0.2, -0.15), 0.3, False)
    assert abs(inside[1]) < 0.2
    assert abs(inside[2]) < 0.15
    assert np.trace(after) < np.trace(before)
    assert np.linalg.eigvalsh(after).min() > -1e-12
    gone, before, after = rolled(lap.model, (8.0, 3.0, -3.0), 0.3, False)
    np.testing.assert_allclose(gone, (8.0, 3.0, -3.0), atol=1e-12)
    np.testing.assert_array_equal(before, after)
    sure, before, after = rolled(lap.model, (8.0, 1.02 * SKID_SIGMA * 0.1, 0.0), 1e-6, False)
    np.testing.assert_allclose(sure[1], 1.02 * SKID_SIGMA * 0.1)
    near = rolled(lap.model, (8.0, 0.98 * SKID_SIGMA * 0.1, 0.0), 1e-6, False)[2]
    assert np.trace(near) < np.trace(after) < np.trace(before)


def test_only_a_vehicle_that_is_surely_slow_may_stand(lap):
    """Quiet and slow: it stands. In motion, uncertain of its speed, or not quiet: nothing is said of it."""
    assert abs(rolled(lap.model, (0.3, 0.0, 0.0), 0.2, True)[0][0]) < 0.3
    for speed, sigma, still in ((0.3, 0.2, False), (1.2 * SLOW_M_PER_S, 0.2, True), (0.3, SLOW_M_PER_S, True)):
        told = [np.trace(rolled(lap.model, (speed, 0.0, 0.0), sigma, one)[2]) for one in (still, False)]
        assert told[0] == told[1]


def test_a_device_is_quiet_at_rest_engine_running_or_not(lap):
    """Shaken by an engine, and by the road the more the faster it goes."""
    speed = np.linalg.norm(lap.path[0][list(VELOCITY)].to_numpy(float), axis=1)
    record = lap.record(1, SEED)
    stamp, samples = record.index.to_numpy(), record[list(AXES)].to_numpy()
    engine = stream(SEED, "engine").standard_normal(samples.shape) * [0.02, 0.05, 0.01, 0.1, 0.1, 0.2]
    rest = (speed < 1e-3) & (stamp > 2 * WINDOW_S)
    for one, slowest in ((samples, 0.05), (samples + engine * (1 + speed[:, None]), 0.8)):
        found = quiet_epochs(one, stamp, stamp)
        assert found[rest].mean() > 0.9
        assert speed[found & (speed < SLOW_M_PER_S)].max() < slowest
        assert not found[: round(WINDOW_S * lap.rate_hz) - 1].any()
    assert not quiet_epochs(samples[:50], stamp[:50], stamp[:50]).any()


@pytest.fixture(scope="module")
def pairs(lap, assumptions, rolling):
    """Drives with an outage, without wheels and with: errors and deviations at its end, NEES at fixes, NIS."""
    found = {"plain": [], "rolling": []}
    for run in range(RUNS):
        outage = OUTAGES[run % len(OUTAGES)]
        for name, given in (("plain", assumptions), ("rolling", rolling)):
            one = drive(lap, given, run, outage=outage)
            row = int(np.searchsorted(one.time, outage[1]))
            off, fixes = navigation_error(lap, one, [row])[0], one.fix_row[60::25]
            some, told = navigation_error(lap, one, fixes), one.covariances[60::25, :NAVIGATION, :NAVIGATION]
            nees = np.einsum("ni,ni->n", some, np.linalg.solve(told, some[..., None])[..., 0])
            std = one.trajectory_std.iloc[row].to_numpy()
            found[name].append((off, std, off[:2] @ np.linalg.solve(one.horizontal[row], off[:2]), nees.mean(),
                                one.record.statistic.mean()))  # fmt: skip
    return {name: [np.array(column) for column in zip(*rows, strict=True)] for name, rows in found.items()}


@pytest.mark.slow
def test_heading_and_position_hold_in_an_outage(pairs):
    """By what is told and by what is so: the heading somewhat, the position and the height by far."""
    (off, std, *_), (off_plain, std_plain, *_) = pairs["rolling"], pairs["plain"]
    told = np.sqrt(np.square(std).mean(axis=0) / np.square(std_plain).mean(axis=0))
    true = np.sqrt(np.square(off).mean(axis=0) / np.square(off_plain).mean(axis=0))
    for ratio in (told, true):
        assert 0.5 < ratio[8] < 0.9
        assert 0.1 < np.hypot(*ratio[:2]) / np.sqrt(2) < 0.5
        assert 0.05 < ratio[2] < 0.5


@pytest.mark.slow
def test_a_filter_that_is_told_the_slip_as_it_is_knows_itself(pairs):
    """Slip is no white noise, and what is told of it only has its power; still NEES and NIS are near 1."""
    _, _, drift, nees, nis = pairs["rolling"]
    low, high = nees_band(2, RUNS, 0.999)
    assert 0.6 * low < drift.mean() < high
    low, high = nees_band(NAVIGATION, 4 * RUNS, 0.9999)
    assert 0.85 * low < nees.mean() < 1.1 * high
    assert abs(nis.mean() / 6 - 1) < 0.02


def test_longer_epochs_tell_the_same(lap, rolling):
    whole, fine = (drive(lap, replace(rolling, epoch_s=epoch), 6) for epoch in (0.05, 0.01))
    apart = np.abs(whole.history.navigation[whole.fix_row, :6] - fine.history.navigation[fine.fix_row, :6])
    std = np.sqrt(fine.history.variances[fine.fix_row, :6])
    assert (apart < 0.1 * std).all()
    np.testing.assert_allclose(whole.history.variances[whole.fix_row], fine.history.variances[fine.fix_row], rtol=0.05)


@pytest.mark.slow
def test_the_smoother_ends_where_the_filter_does_and_is_nearer_before(lap, rolling):
    sizes = {False: [], True: []}
    for run in range(12):
        ends = []
        for smooth in sizes:
            one = drive(lap, rolling, run, smooth=smooth)
            ends.append((one.history.navigation[-1], one.history.variances[-1]))
            rows = np.flatnonzero((one.time > OUTAGE[0]) & (one.time < OUTAGE[1]))[::100]
            off, std = navigation_error(lap, one, rows)[:, :3], np.sqrt(one.history.variances[rows, :3])
            sizes[smooth].append((off, off / std))
            assert (one.history.variances > 0).all()
        np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-9)
        np.testing.assert_allclose(ends[0][1], ends[1][1], rtol=1e-6)
    size = {smooth: np.sqrt(np.mean([np.square(off) for off, _ in found])) for smooth, found in sizes.items()}
    assert size[True] < 0.7 * size[False]
    for found in sizes.values():
        assert 0.4 < np.mean([np.square(share) for _, share in found]) < 1.6


@pytest.mark.slow
def test_a_device_that_is_mounted_askew_tells_the_same(lap):
    given = {
        "wheels": {"std_m_per_s": 0.05, "x_m": -1.3, "z_m": 0.4},
        "lever_arm": {"x_m": 0.4, "y_m": -0.3, "z_m": -1.2},
    }
    mounting = {"roll_deg": 180.0, "pitch_deg": 7.0, "heading_deg": -175.0}
    record, fixes = lap.record(2, SEED), lap.fixes(2, SEED)
    turn = from_euler(np.radians(list(mounting.values()))).inv()
    askew = record.copy()
    for triad in (GYRO, ACCEL):
        askew[list(triad)] = turn.apply(record[list(triad)].to_numpy(copy=True))
    settings = (DriveSettings.of(configure(one, SCHEMA), lap.model) for one in (given, given | {"mounting": mounting}))
    one, other = (
        navigate_drive(RecordedDrive(log, fixes, setting))
        for log, setting in zip((record, askew), settings, strict=True)
    )
    for name in ("filtered", "smoothed"):
        paths = getattr(one, name).history.navigation, getattr(other, name).history.navigation
        np.testing.assert_allclose(*paths, atol=1e-6)
    assert one.filtered.trajectory_std["heading"].iloc[-1] < 0.01
