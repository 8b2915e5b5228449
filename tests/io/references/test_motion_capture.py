import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from imugap import log
from imugap.io.references.motion_capture import Alignment, aligned, band_limited, ideal, track_of
from imugap.io.references.reference import MOVING, QUATERNION
from imugap.kinematics.strapdown import POSITION
from imugap.numerics.rotation import from_euler
from imugap.stream import stream

INTERVAL, DURATION_S, BAND_HZ = 0.004, 80.0, 10.0
GRAVITY = 9.81
TILT = Rotation.from_rotvec([0.004, -0.006, 0.0])
"""Turns north, east, down into the frame that the cameras take for it."""
FRAME = Rotation.from_rotvec([0.02, -0.01, 0.03])
LAG = 0.0031
RATES_HZ = np.array([[0.31, 0.83], [0.43, 0.71], [0.23, 0.97]])
ANGLES = np.array([[0.9, 0.3], [0.6, 0.3], [1.2, 0.4]])
METRES = np.array([[0.2, 0.05], [0.15, 0.08], [0.1, 0.05]])


def swings(size, time, order=0):
    """Sums of two sines along three axes at ``time``, or their derivative, shape (n, 3)."""
    pulse = 2 * np.pi * RATES_HZ
    angle = pulse * np.asarray(time)[:, None, None] + np.arange(3)[:, None] + order * np.pi / 2
    return np.sum(size * pulse**order * np.sin(angle), axis=-1)


def attitude(time):
    return TILT * from_euler(swings(ANGLES, time))


def truth(time):
    """Rate and specific force in the body frame of the track at ``time``, shape (n, 6)."""
    step = 1e-4
    rate = (attitude(time - step).inv() * attitude(time + step)).as_rotvec() / (2 * step)
    force = attitude(time).inv().apply(swings(METRES, time, 2) - TILT.apply([0.0, 0.0, GRAVITY]))
    return np.hstack([rate, force])


def means(time, nodes=4):
    """What the sensors read: means over the interval that ends at ``time``, by the rule of Gauss."""
    places, weights = np.polynomial.legendre.leggauss(nodes)
    return sum(w / 2 * truth(time - INTERVAL / 2 * (1 - x)) for x, w in zip(places, weights, strict=True))


def recorded(noise=0.0):
    """A track, and the log of a device whose frame and clock differ from those of the track."""
    time = INTERVAL * np.arange(round(DURATION_S / INTERVAL))
    seen = np.hstack([attitude(time).as_quat(), swings(METRES, time)])
    track = pd.DataFrame(seen, index=pd.Index(time, name="time"), columns=[*QUATERNION, *POSITION])
    at = means(time - LAG)
    turned = np.hstack([FRAME.apply(at[:, :3]), FRAME.apply(at[:, 3:])])
    turned += noise * stream(41, "optical").standard_normal(turned.shape)
    return log.from_samples(dict(zip(log.AXES, turned.T, strict=True)), INTERVAL), track


def lost(track, *spans):
    """The track with the device out of sight within spans [s]."""
    track = track.copy()
    for begin, end in spans:
        track.loc[begin:end] = np.nan
    return track


def reference_of(track):
    return track[list(QUATERNION)].dropna().assign(**{MOVING: True})


TRUE = Alignment(LAG, FRAME, TILT.apply([0.0, 0.0, GRAVITY]))


def test_a_track_is_known_where_its_attitude_and_its_position_are():
    _, track = recorded()
    positions = track[list(POSITION)].copy()
    positions.iloc[7] = np.nan
    found = track_of(reference_of(lost(track, (0.008, 0.012))), positions)
    assert found.index.equals(track.index)
    assert np.flatnonzero(found.isna().any(axis=1)).tolist() == [2, 3, 7]
    kept = found.dropna()
    pd.testing.assert_frame_equal(kept, track.loc[kept.index])


def test_differences_of_a_smooth_track_are_the_means_of_rate_and_force():
    _, track = recorded()
    found = ideal(track, Alignment(0.0, Rotation.identity(), TRUE.gravity)).iloc[1:-1]
    difference = found.to_numpy() - means(found.index.to_numpy())
    assert np.abs(difference[:, :3]).max() < 2e-4
    assert np.abs(difference[:, 3:]).max() < 2e-3


def test_a_log_without_errors_is_its_ideal_within_the_band():
    device, track = recorded()
    pair = band_limited(device, track, TRUE, BAND_HZ)
    difference = (pair.log - pair.ideal).to_numpy()[20:-20]
    assert np.abs(difference[:, :3]).max() < 2e-4
    assert np.abs(difference[:, 3:]).max() < 2e-3
    assert not pair.unseen.any()
    assert log.rate(pair.log) == pytest.approx(2 * BAND_HZ, rel=0.05)


def test_frame_and_lag_and_vertical_are_recovered():
    device, track = recorded(noise=1e-3)
    device = device.add(np.array([0.01, -0.02, 0.005, 0.1, -0.05, 0.2]))
    found = aligned(device, track, reference_of(track), GRAVITY)
    assert found.lag == pytest.approx(LAG, abs=2e-5)
    assert (found.rotation * FRAME.inv()).magnitude() < 1e-4
    assert np.linalg.norm(found.gravity) == pytest.approx(GRAVITY)
    np.testing.assert_allclose(found.gravity, TRUE.gravity, atol=2e-3)


def test_an_arm_and_glimpses_far_off_do_not_tilt_the_vertical():
    device, track = recorded(noise=1e-3)
    rate = device[list(log.GYRO)].to_numpy()
    change, arm = np.gradient(rate, INTERVAL, axis=0), [0.02, -0.01, 0.03]
    device[list(log.ACCEL)] += np.cross(rate, np.cross(rate, arm)) + np.cross(change, arm)
    track.loc[30.0:30.02, "north"] += 0.05
    found = aligned(device, track, reference_of(track), GRAVITY)
    np.testing.assert_allclose(found.gravity, TRUE.gravity, atol=5e-3)


def test_an_error_of_the_sensor_is_what_remains():
    device, track = recorded()
    wrong = device.assign(gyro_y=device["gyro_y"] * 1.01, accel_z=device["accel_z"] + 0.3)
    pair = band_limited(wrong, track, TRUE, BAND_HZ)
    difference = (pair.log - pair.ideal).iloc[20:-20]
    np.testing.assert_allclose(difference["gyro_y"], 0.01 * pair.ideal["gyro_y"].iloc[20:-20], atol=3e-4)
    np.testing.assert_allclose(difference["accel_z"], 0.3, atol=3e-3)


def test_where_the_cameras_lose_the_device_nothing_is_said():
    device, track = recorded()
    wrong = device.assign(gyro_x=device["gyro_x"] + 0.2)
    pair = band_limited(wrong, lost(track, (20.0, 20.1), (50.0, 50.02), (0.0, 5.0)), TRUE, BAND_HZ)
    assert pair.log.index[0] > 5.0
    stamps = pair.log.index[pair.unseen] - LAG
    assert all(np.any((stamps > begin) & (stamps < end)) for begin, end in ((19.95, 20.15), (49.95, 50.1)))
    assert 0 < pair.unseen.mean() < 0.02
    difference = (pair.log - pair.ideal).iloc[20:-20]
    np.testing.assert_allclose(difference["gyro_x"], 0.2, atol=5e-4)
    np.testing.assert_allclose(difference["accel_y"], 0.0, atol=0.05)


def test_white_noise_of_the_log_keeps_its_density():
    device, track = recorded()
    noise = 0.1 * stream(41, "white").standard_normal(len(device))
    difference = band_limited(device.assign(gyro_z=device["gyro_z"] + noise), track, TRUE, BAND_HZ)
    left = (difference.log - difference.ideal)["gyro_z"].to_numpy()
    expected = 0.1**2 * INTERVAL * log.rate(difference.log)
    assert np.var(left) == pytest.approx(expected, rel=4 * np.sqrt(2 / len(left)))
