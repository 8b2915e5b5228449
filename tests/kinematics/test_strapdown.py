"""The navigator against motions with a known answer: closed forms, laws of error growth, a flight in inertial axes."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from imugap.kinematics import earth, strapdown
from imugap.kinematics.strapdown import Ellipsoid, Local, NavigationState
from imugap.log import ACCEL, GYRO, LogError, from_samples
from imugap.numerics import rotation

G = 9.81
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


def constant(vector, count):
    return np.tile(np.asarray(vector, dtype=float), (count, 1))


def interval_means(function, times):
    """SmoothTerms of a function of time, (m,) to (m, 3), over the intervals that end at ``times``."""
    steps = np.diff(times, prepend=2 * times[0] - times[1])
    inner = times[:, None] + 0.5 * steps[:, None] * (NODES - 1)
    values = function(inner.ravel()).reshape(len(times), len(NODES), 3)
    return 0.5 * np.einsum("j,kji->ki", WEIGHTS, values)


def turn_between(euler, other) -> float:
    """Angle [rad] between two attitudes (roll, pitch, heading)."""
    return (rotation.from_euler(euler).inv() * rotation.from_euler(other)).magnitude()


# Motions with a constant rate and specific force in the body frame


def test_constant_rate_is_exact_over_hundreds_of_turns():
    rate, dt, count = np.array([1.1, -0.7, 1.9]), 0.01, 100_001
    start = NavigationState(attitude=(0.2, -0.4, 2.0))
    path = strapdown.navigate(constant(rate, count), np.zeros((count, 3)), dt, start, Local(0.0), every=10_000)
    total = np.linalg.norm(rate) * dt * (count - 1)
    for k, row in enumerate(path):
        expected = rotation.from_euler(start.attitude) * Rotation.from_rotvec(rate * (dt * 10_000 * k))
        assert turn_between(row[6:], rotation.to_euler(expected)) <= 1e-12 * max(total, 1)
    assert total > 300 * 2 * np.pi


@pytest.mark.parametrize(
    ("step", "earth_model"), [(strapdown.local_step, G), (strapdown.ellipsoid_step, Ellipsoid(0.8, 0.0, 0.0).origin)]
)
def test_the_quaternion_keeps_its_length(step, earth_model):
    """Left alone, it would lose 5e-17 every time that this rotation vector is applied: 1e-12 here."""
    position, velocity, quat = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    for _ in range(20_000):
        position, velocity, quat = step(
            position, velocity, quat, (0.011, -0.007, 0.019), (0.0, 0.0, 0.0), 1e-3, earth_model
        )
    assert np.linalg.norm(quat) == pytest.approx(1, rel=0, abs=1e-15)


@pytest.mark.parametrize("dt", [0.001, 0.05, 0.4])
def test_a_circle_is_exact_in_velocity_and_trapezoidal_in_position(dt):
    """Rate about down with a force to the right: a circle. 0.4 s turns by more than 1 rad: beyond the series."""
    rate, force, duration = 3.0, 2.0, 12.0
    count = round(duration / dt) + 1
    path = strapdown.navigate(
        constant([0, 0, rate], count), constant([0, force, -G], count), dt, NavigationState(), Local(G)
    )
    angle = rate * dt * np.arange(count)
    speed = force / rate
    velocity = np.column_stack([speed * (np.cos(angle) - 1), speed * np.sin(angle), 0 * angle])
    np.testing.assert_allclose(path[:, 3:6], velocity, rtol=0, atol=1e-12 * speed * count**0.5)
    north = speed * (np.sin(angle) / rate - dt * np.arange(count))
    acceleration = -force * np.sin(angle)
    missed = path[-1, 0] - north[-1]
    leading = dt**2 / 12 * (acceleration[-1] - acceleration[0])
    assert missed == pytest.approx(leading, rel=0.1, abs=1e-11)


def test_halving_the_interval_changes_nothing_for_constant_input():
    rate, force = [0.4, -0.3, 0.8], [1.0, 2.0, -9.0]
    start = NavigationState(velocity=(1.0, 2.0, 3.0), attitude=(0.1, 0.2, 0.3))
    coarse = strapdown.navigate(constant(rate, 1001), constant(force, 1001), 0.02, start, Local(G))
    fine = strapdown.navigate(constant(rate, 2001), constant(force, 2001), 0.01, start, Local(G), every=2)
    np.testing.assert_allclose(fine[:, 3:], coarse[:, 3:], rtol=0, atol=1e-11)
    assert 0 < np.abs(fine[:, :3] - coarse[:, :3]).max() < 1e-3


# Growth of errors on a flat Earth


def test_accelerometer_bias_grows_as_time_and_its_square():
    bias, dt, count = np.array([1e-3, -2e-3, 3e-3]), 0.01, 6001
    path = strapdown.navigate(np.zeros((count, 3)), constant(bias - [0, 0, G], count), dt, NavigationState(), Local(G))
    time = dt * np.arange(count)[:, None]
    np.testing.assert_allclose(path[:, 3:6], bias * time, rtol=0, atol=1e-11)
    np.testing.assert_allclose(path[:, :3], 0.5 * bias * time**2, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("axis", "tilt", "channel", "sign"), [(0, "roll", "east", 1), (1, "pitch", "north", -1)])
def test_gyro_bias_tilts_and_gravity_carries_the_position_away(axis, tilt, channel, sign):
    """Tilt ~ t, velocity ~ g t^2/2, position ~ g t^3/6: backwards with the nose up, right with the right wing down."""
    bias, dt, count = 1e-6, 0.01, 10_001
    rate = np.zeros(3)
    rate[axis] = bias
    path = strapdown.navigate(
        constant(rate, count), constant([0, 0, -G], count), dt, NavigationState(), Local(G), every=count - 1
    )
    end, duration = pd.Series(path[-1], strapdown.COLUMNS), dt * (count - 1)
    assert end[tilt] == pytest.approx(bias * duration, rel=1e-9)
    assert end[f"vel_{channel[0]}"] == pytest.approx(sign * G * bias * duration**2 / 2, rel=1e-6)
    assert end[channel] == pytest.approx(sign * G * bias * duration**3 / 6, rel=1e-6)


def test_vertical_gyro_bias_turns_the_heading_only():
    path = strapdown.navigate(
        constant([0, 0, 1e-3], 1001), constant([0, 0, -G], 1001), 0.1, NavigationState(), Local(G)
    )
    assert path[-1, 8] == pytest.approx(0.1, rel=1e-12)
    assert np.abs(path[:, :8]).max() < 1e-9


# A smooth motion with a known answer, on a flat Earth


def smooth_euler(time):
    phases = np.outer(time, [1.1, 0.7, 0.4])
    rates = np.array([1.1, 0.7, 0.4]) * np.array([0.5, 0.4, 1.0])
    return np.array([0.5, 0.4, 1.0]) * np.sin(phases) + [0, 0.1, 0.2], rates * np.cos(phases)


def smooth_gyro(time):
    """Body rate of the Euler angles (Groves 2013, eq. 2.58)."""
    (roll, pitch, _), (droll, dpitch, dheading) = (part.T for part in smooth_euler(time))
    across = dpitch * np.cos(roll) + dheading * np.cos(pitch) * np.sin(roll)
    downward = -dpitch * np.sin(roll) + dheading * np.cos(pitch) * np.cos(roll)
    return np.column_stack([droll - dheading * np.sin(pitch), across, downward])


SWAY, SWAY_RATE = np.array([3.0, -2.0, 1.0]), np.array([0.9, 1.3, 0.6])


def smooth_accel(time):
    acceleration = -SWAY * SWAY_RATE**2 * np.sin(np.outer(time, SWAY_RATE))
    return rotation.from_euler(smooth_euler(time)[0]).inv().apply(acceleration - [0, 0, G])


def smooth_run(times):
    """Navigated path and true end (position, velocity, attitude) of the smooth motion sampled at ``times``."""
    gyro, accel = interval_means(smooth_gyro, times), interval_means(smooth_accel, times)
    start = NavigationState((0, 0, 0), tuple(SWAY * SWAY_RATE), tuple(smooth_euler(times[:1])[0][0]))
    dt = np.diff(times, prepend=2 * times[0] - times[1])
    path = strapdown.navigate(gyro, accel, dt, start, Local(G))
    end = times[-1]
    position, velocity = SWAY * np.sin(SWAY_RATE * end), SWAY * SWAY_RATE * np.cos(SWAY_RATE * end)
    return path, (position, velocity, smooth_euler(times[-1:])[0][0]), (gyro, accel, dt, start)


def apart(row, position, velocity, attitude):
    """Distances of a row of a path from a position [m], a velocity [m/s] and an attitude [rad]."""
    return np.linalg.norm(row[:3] - position), np.linalg.norm(row[3:6] - velocity), turn_between(row[6:], attitude)


def smooth_errors(times):
    path, end, _ = smooth_run(times)
    return apart(path[-1], *end)


def regular(count):
    return np.linspace(0, 20, count)


def irregular(count):
    """Steps that alternate between one and two units."""
    steps = np.tile([1.0, 2.0], (count - 1) // 2)
    return 20 * np.concatenate([[0], np.cumsum(steps)]) / steps.sum()


@pytest.mark.parametrize("sampling", [regular, irregular])
def test_smooth_motion_is_followed_with_the_order_of_the_corrections(sampling):
    """Third order in attitude and velocity thanks to coning and sculling, second in position (trapezoid)."""
    coarse, fine = smooth_errors(sampling(2001)), smooth_errors(sampling(4001))
    assert (np.array(coarse) < [5e-5, 5e-7, 1e-8]).all()
    assert 3.4 < coarse[0] / fine[0] < 4.6
    assert 7 < coarse[1] / fine[1] < 9
    assert 7 < coarse[2] / fine[2] < 9


def test_time_reversal_leads_back_to_the_start():
    """Backwards in time the rate and the velocity change sign and the specific force does not."""
    misses = []
    for count in (2001, 4001):
        path, _, (gyro, accel, dt, start) = smooth_run(regular(count))
        turned = NavigationState(tuple(path[-1, :3]), tuple(-path[-1, 3:6]), tuple(path[-1, 6:]))
        gyro, accel = (np.concatenate([data[-1:], data[:0:-1]]) for data in (-gyro, accel))
        back = strapdown.navigate(gyro, accel, dt, turned, Local(G))[-1]
        misses.append(apart(back, start.position, -np.array(start.velocity), start.attitude))
    assert (np.array(misses[0]) < [1e-4, 1e-5, 1e-6]).all()
    assert (np.divide(*misses) > 3.4).all()


@settings(deadline=None, max_examples=25)
@given(st.tuples(*[st.floats(-3, 3)] * 3))
def test_the_choice_of_body_axes_does_not_matter(rotvec):
    path, _, (gyro, accel, dt, start) = smooth_run(regular(201))
    mount = Rotation.from_rotvec(rotvec)
    attitude = rotation.to_euler(rotation.from_euler(start.attitude) * mount.inv())
    other = NavigationState(start.position, start.velocity, tuple(attitude))
    turned = strapdown.navigate(mount.apply(gyro), mount.apply(accel), dt, other, Local(G))
    np.testing.assert_allclose(turned[:, :6], path[:, :6], rtol=0, atol=1e-10)
    expected = rotation.to_euler(rotation.from_euler(path[-1, 6:]) * mount.inv())
    assert turn_between(turned[-1, 6:], expected) < 1e-12


@settings(deadline=None, max_examples=25)
@given(st.floats(-3, 3))
def test_turning_the_start_turns_the_trajectory(heading):
    path, _, (gyro, accel, dt, start) = smooth_run(regular(201))
    turn = Rotation.from_rotvec([0, 0, heading])
    other = NavigationState(
        (0, 0, 0), tuple(turn.apply(start.velocity)), (*start.attitude[:2], start.attitude[2] + heading)
    )
    turned = strapdown.navigate(gyro, accel, dt, other, Local(G))
    np.testing.assert_allclose(turned[:, :3], turn.apply(path[:, :3]), rtol=0, atol=1e-10)
    np.testing.assert_allclose(turned[:, 3:6], turn.apply(path[:, 3:6]), rtol=0, atol=1e-10)
    np.testing.assert_allclose(turned[:, 6:8], path[:, 6:8], rtol=0, atol=1e-12)


# Coning and sculling


CONE, FREQUENCY = 0.02, 2 * np.pi * 5


def coning_rate(time):
    """Body rate while the axis of a rotation by the angle ``CONE`` runs round in the x-y plane at ``FREQUENCY``."""
    phase = FREQUENCY * time
    swing = FREQUENCY * np.sin(CONE)
    spin = 2 * FREQUENCY * np.sin(CONE / 2) ** 2
    return np.column_stack([-swing * np.sin(phase), swing * np.cos(phase), -spin + 0 * phase])


def coning_drift(interval, corrected):
    """Drift about z [rad/s] over 10 s, after which the attitude is the first again."""
    count = round(10 / interval) + 1
    gyro = interval_means(coning_rate, interval * np.arange(count))
    start = Rotation.from_rotvec([CONE, 0, 0])
    if corrected:
        state = NavigationState(attitude=tuple(rotation.to_euler(start)))
        end = strapdown.navigate(gyro, 0 * gyro, interval, state, Local(0.0))[-1, 6:]
        missed = rotation.from_euler(end) * start.inv()
    else:
        missed = start
        for rotvec in Rotation.from_rotvec(gyro[1:] * interval):
            missed = missed * rotvec
        missed = missed * start.inv()
    return missed.as_rotvec()[2] / 10


@pytest.mark.parametrize("interval", [0.01, 0.005])
def test_coning_drift_is_what_theory_leaves(interval):
    """Per interval (e^2/2)(x - sin x) uncorrected; the correction takes (e^2/2)(2/3) sin^2(x/2) sin x off, x = w T.

    Ignagni 1996, Savage 1998 part 1: what is left is (e^2/2) x^5/30 to the lowest order, x^2/5 of the uncorrected.
    """
    x, scale = FREQUENCY * interval, CONE**2 / 2 / interval
    uncorrected, corrected = coning_drift(interval, False), coning_drift(interval, True)
    defect = x - np.sin(x)
    assert abs(uncorrected) == pytest.approx(scale * defect, rel=5e-3)
    assert abs(corrected) == pytest.approx(scale * (defect - 2 / 3 * np.sin(x / 2) ** 2 * np.sin(x)), rel=2e-2)
    assert corrected / uncorrected == pytest.approx(x**2 / 5, rel=0.05)


def sculling_drift(interval):
    """Vertical velocity drift [m/s^2] against the closed form, for roll and side force in phase."""
    swing, force, duration = 0.01, 2.0, 10.0
    count = round(duration / interval) + 1
    times = interval * np.arange(count)
    gyro = interval_means(lambda t: np.outer(swing * FREQUENCY * np.cos(FREQUENCY * t), [1, 0, 0]), times)
    accel = interval_means(lambda t: np.outer(force * np.sin(FREQUENCY * t), [0, 1, 0]), times)
    end = strapdown.navigate(gyro, accel, interval, NavigationState(), Local(0.0))[-1]
    phase = 2 * np.pi * (np.arange(2000) + 0.5) / 2000
    true = force * np.mean(np.sin(phase) * np.sin(swing * np.sin(phase)))
    return end[5] / duration - true, true


@pytest.mark.parametrize("interval", [0.01, 0.005])
def test_sculling_drift_is_what_theory_leaves(interval):
    """The algebra of coning: without a correction 1 - sin x/x of the true drift is missed, with it x^2/5 of that."""
    x = FREQUENCY * interval
    missed, true = sculling_drift(interval)
    assert true == pytest.approx(0.01, rel=1e-3)
    assert abs(missed) / (true * (1 - np.sin(x) / x)) == pytest.approx(x**2 / 5, rel=0.05)


# The rotating Earth


HOME = Ellipsoid(latitude=0.86, longitude=-1.2, height=250.0)


def at_rest(place, state, count):
    """Ideal samples of a body at rest on the Earth."""
    inverse = rotation.from_euler(state.attitude).inv()
    gyro = inverse.apply(earth.earth_rate_n(place.latitude))
    accel = inverse.apply([0, 0, -earth.normal_gravity(place.latitude, place.height)])
    return constant(gyro, count), constant(accel, count)


def test_a_body_at_rest_stays_and_the_flat_mechanisation_drifts_as_the_earth_turns():
    """An hour at rest: the horizontal stays; the vertical shows what the step neglects, g (w cos(lat) dt)^2/12.

    The vertical channel is unstable and lets a constant acceleration grow as cosh(t sqrt(2 g/R)) - 1.
    """
    state, dt, count = NavigationState(attitude=(0.3, -0.2, 2.5)), 0.1, 36_001
    gyro, accel = at_rest(HOME, state, count)
    path = strapdown.navigate(gyro, accel, dt, state, HOME, every=600)
    assert np.abs(path[:, [0, 1, 3, 4]]).max() < 1e-4
    assert np.abs(path[:, 6:] - path[0, 6:]).max() < 1e-10
    instability = 2 / 6371e3 * G
    neglected = G / 12 * (earth.ROTATION_RATE * np.cos(HOME.latitude) * dt) ** 2
    growth = (np.cosh(3600 * np.sqrt(instability)) - 1) / instability
    assert abs(path[-1, 2]) == pytest.approx(neglected * growth, rel=0.05)
    gravity = earth.normal_gravity(HOME.latitude, HOME.height)
    flat = strapdown.navigate(gyro[:1001], accel[:1001], dt, state, Local(gravity))[-1]
    rate_north = earth.ROTATION_RATE * np.cos(HOME.latitude)
    assert flat[1] == pytest.approx(gravity * rate_north * 100**3 / 6, rel=1e-2)


@pytest.mark.parametrize(
    ("attitude", "push"), [((0.0, 1e-5, 0.0), 0.0), ((0.0, 0.0, 0.0), 1e-4), ((0.0, 0.0, np.pi), -1e-4)]
)
def test_errors_swing_with_the_period_of_schuler(attitude, push):
    """At the equator the north channel is an oscillator of frequency^2 = g/M + w^2: 84.4 min less the Earth's turn.

    A pendulum as long as the meridian radius; the Earth's turn couples tilt and heading and adds its own square.
    """
    place, dt, count = Ellipsoid(0.0, 0.3, 0.0), 1.0, 11_001
    gyro, accel = at_rest(place, NavigationState(attitude=(0.0, 0.0, attitude[2])), count)
    path = strapdown.navigate(gyro, accel + np.array([push, 0, 0]), dt, NavigationState(attitude=attitude), place)
    speed = path[1:, 3]
    crossings = np.flatnonzero(speed[1:] * speed[:-1] < 0)
    assert len(crossings) == 4
    period = dt * (crossings[2:] - crossings[:-2]).mean()
    gravity, meridian = earth.normal_gravity(0.0, 0.0), earth.curvature_radii(0.0)[0]
    assert period == pytest.approx(2 * np.pi / np.sqrt(gravity / meridian + earth.ROTATION_RATE**2), rel=2e-3)
    assert period / 60 == pytest.approx(84.4, abs=0.4)


def test_accelerometer_bias_swings_about_the_tilt_that_balances_it():
    """Position between 0 and 2 b M/g: bounded, while the flat mechanisation runs away."""
    place, bias, count = Ellipsoid(0.0, 0.3, 0.0), 1e-4, 5_001
    gyro, accel = at_rest(place, NavigationState(), count)
    north = strapdown.navigate(gyro, accel + np.array([bias, 0, 0]), 1.0, NavigationState(), place)[:, 0]
    extent = 2 * bias * earth.curvature_radii(0.0)[0] / earth.normal_gravity(0.0, 0.0)
    assert north.max() == pytest.approx(extent, rel=0.01)
    assert -0.01 * extent < north.min() <= 0
    assert 0.5 * bias * 5000**2 > 9 * extent


class Flight:
    """A flight in inertial axes: latitude, longitude, height and Euler angles swing slowly; nothing rotates with it.

    Rate and specific force come from turning and differentiating in inertial space, so they know nothing of transport
    rate, Coriolis acceleration or radii of curvature.
    """

    OMEGA = np.array([0, 0, earth.ROTATION_RATE])

    def geodetic(self, time):
        swing = np.sin(np.outer(time, [0.020, 0.015, 0.03]))
        return np.array([0.86, -1.2, 1000.0]) + swing * [1e-3, 2.5e-3, 300.0]

    def euler(self, time):
        return np.array([0.4, 0.2, 1.5]) * np.sin(np.outer(time, [0.06, 0.05, 0.02])) + [0.0, 0.05, 1.0]

    def mat_in(self, time):
        latitude, longitude, _ = self.geodetic(time).T
        angles = np.column_stack([longitude + earth.ROTATION_RATE * time, -(np.pi / 2 + latitude)])
        return Rotation.from_euler("ZY", angles)

    def mat_ib(self, time):
        return self.mat_in(time) * rotation.from_euler(self.euler(time))

    def place(self, time):
        latitude, longitude, height = self.geodetic(time).T
        longitude = longitude + earth.ROTATION_RATE * time
        reduced = np.arctan2(earth.SEMI_MINOR_AXIS * np.sin(latitude), earth.SEMI_MAJOR_AXIS * np.cos(latitude))
        equatorial = earth.SEMI_MAJOR_AXIS * np.cos(reduced) + height * np.cos(latitude)
        polar = earth.SEMI_MINOR_AXIS * np.sin(reduced) + height * np.sin(latitude)
        return np.column_stack([equatorial * np.cos(longitude), equatorial * np.sin(longitude), polar])

    def velocity(self, time, step=0.5):
        """Velocity relative to the Earth in ``n``: the inertial one without the turn of the Earth."""
        near, far = (self.place(time + k * step) - self.place(time - k * step) for k in (1, 2))
        inertial = (8 * near - far) / (12 * step)
        return self.mat_in(time).inv().apply(inertial - np.cross(self.OMEGA, self.place(time)))

    def gyro(self, time, step=0.05):
        near, far = ((self.mat_ib(time - k * step).inv() * self.mat_ib(time + k * step)).as_rotvec() for k in (1, 2))
        return (8 * near - far) / (12 * step)

    def accel(self, time, step=0.5):
        middle = self.place(time)
        near, far = (self.place(time + k * step) + self.place(time - k * step) - 2 * middle for k in (1, 2))
        acceleration = (16 * near - far) / (12 * step**2)
        latitude, _, height = self.geodetic(time).T
        down = np.column_stack([0 * height, 0 * height, earth.normal_gravity(latitude, height)])
        attraction = self.mat_in(time).apply(down) + np.cross(self.OMEGA, np.cross(self.OMEGA, middle))
        return self.mat_ib(time).inv().apply(acceleration - attraction)


def flight_errors(interval):
    """Largest errors of position [m], velocity [m/s] and attitude [rad] along 10 min of flight, and the last row."""
    flight, times = Flight(), np.arange(0, 600 + interval / 2, interval)
    first = flight.geodetic(times[:1])[0]
    place = Ellipsoid(*first)
    state = NavigationState(velocity=tuple(flight.velocity(times[:1])[0]), attitude=tuple(flight.euler(times[:1])[0]))
    samples = np.hstack([interval_means(flight.gyro, times), interval_means(flight.accel, times)])
    log = from_samples(dict(zip(GYRO + ACCEL, samples.T, strict=True)), interval)
    table = strapdown.trajectory(log, state, place)
    metres = np.array([*earth.metres_per_radian(*first[[0, 2]]), 1.0])
    position = (table[list(strapdown.GEODETIC)].to_numpy() - flight.geodetic(times)) * metres
    velocity = table[list(strapdown.VELOCITY)].to_numpy() - flight.velocity(times)
    found = rotation.from_euler(table[list(strapdown.ATTITUDE)].to_numpy())
    attitude = rotation.from_euler(flight.euler(times)).inv() * found
    flat = strapdown.trajectory(log, state, Local(earth.normal_gravity(*first[[0, 2]])))
    return np.abs(position).max(), np.abs(velocity).max(), attitude.magnitude().max(), table, flat


def test_a_flight_in_inertial_axes_is_recovered_on_the_ellipsoid():
    """The flat mechanisation is kilometres off; halving the interval shows the third order."""
    position, velocity, attitude, table, flat = flight_errors(0.1)
    assert position < 0.01
    assert velocity < 5e-5
    assert attitude < 1e-8
    assert np.hypot(table["vel_n"], table["vel_e"]).max() > 150
    assert (flat[["north", "east"]] - table[["north", "east"]]).iloc[-1].abs().max() > 1000
    assert 5 < flight_errors(0.2)[0] / position < 9


def test_positions_on_the_ellipsoid_are_counted_from_its_origin():
    state = NavigationState(position=(1000.0, -2000.0, 50.0))
    gyro, accel = at_rest(HOME, NavigationState(), 3)
    log = from_samples(dict(zip(GYRO + ACCEL, np.hstack([gyro, accel]).T, strict=True)), 0.01)
    table = strapdown.trajectory(log, state, HOME)
    assert list(table.columns) == [*strapdown.COLUMNS, *strapdown.GEODETIC]
    first = table.iloc[0]
    north, east = earth.metres_per_radian(HOME.latitude, HOME.height)
    assert (first["latitude"] - HOME.latitude) * north == pytest.approx(1000, rel=1e-9)
    assert (first["longitude"] - HOME.longitude) * east == pytest.approx(-2000, rel=1e-9)
    assert first["height"] == 200.0


# The door: tables, storage, checks


def test_every_keeps_the_epochs_it_says_and_runs_are_navigated_one_by_one():
    rng = np.random.default_rng(1)
    gyro, accel = rng.normal(0, 0.3, (2, 3, 101, 3)), rng.normal(0, 3, (2, 3, 101, 3))
    state = NavigationState((1, 2, 3), (4, 5, 6), (0.1, 0.2, 0.3))
    for mechanisation in (Local(G), HOME):
        full = strapdown.navigate(gyro, accel, 0.01, state, mechanisation)
        assert full.shape == (2, 3, 101, 9)
        np.testing.assert_allclose(full[1, 2, 0], [1, 2, 3, 4, 5, 6, 0.1, 0.2, 0.3], rtol=1e-15)
        single = strapdown.navigate(gyro[1, 2], accel[1, 2], np.full(101, 0.01), state, mechanisation)
        assert np.array_equal(single, full[1, 2])
        for every in (7, 100, 101, 500):
            sparse = strapdown.navigate(gyro, accel, 0.01, state, mechanisation, every)
            assert np.array_equal(sparse, full[..., ::every, :])


def test_trajectory_has_the_times_of_the_log():
    times = irregular(201)
    gyro, accel = interval_means(smooth_gyro, times), interval_means(smooth_accel, times)
    log = pd.DataFrame(np.hstack([gyro, accel]), index=pd.Index(times + 100, name="time"), columns=list(GYRO + ACCEL))
    path, _, (_, _, _, start) = smooth_run(times)
    table = strapdown.trajectory(log, start, Local(G), every=3)
    assert list(table.columns) == list(strapdown.COLUMNS)
    assert table.index.equals(log.index[::3])
    assert table.index.name == "time"
    np.testing.assert_allclose(table.to_numpy(), path[::3], rtol=0, atol=1e-9)


@settings(deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_levelling_finds_the_tilt_and_the_levelled_body_stays(roll, pitch, heading):
    force = rotation.from_euler([roll, pitch, heading]).inv().apply([0, 0, -G])
    samples = np.hstack([np.zeros((100, 3)), constant(force, 100)])
    samples[50:, 3:] += 5.0
    log = from_samples(dict(zip(GYRO + ACCEL, samples.T, strict=True)), 0.01)
    state = strapdown.align(log, 0.5, heading)
    assert state.attitude == pytest.approx((roll, pitch, heading), rel=0, abs=1e-12)
    rest = strapdown.trajectory(log.iloc[:50], state, Local(G))
    assert np.abs(rest[list(strapdown.POSITION + strapdown.VELOCITY)].to_numpy()).max() < 1e-11


RATE, FORCE = np.zeros((5, 3)), constant([0, 0, -G], 5)
BAD = np.array([[0, 0, 0], [0, 0, 0], [0, np.nan, 0], [0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("gyro", "accel", "dt", "message"),
    [
        (RATE + BAD, FORCE, 0.1, "gyro: expected finite"),
        (RATE, FORCE + BAD, 0.1, "accel: expected finite"),
        (RATE, np.where(np.isnan(BAD), np.inf, FORCE), 0.1, "accel: expected finite"),
        (RATE[:-1], FORCE, 0.1, "expected equal shapes"),
        (RATE[:, :2], FORCE[:, :2], 0.1, "expected equal shapes"),
        (RATE[:1], FORCE[:1], 0.1, "expected equal shapes"),
        (RATE[0], FORCE[0], 0.1, "expected equal shapes"),
        (RATE, FORCE, 0.0, "dt: expected"),
        (RATE, FORCE, np.nan, "dt: expected"),
        (RATE, FORCE, [0.1, 0.1, -0.1, 0.1, 0.1], "dt: expected"),
        (RATE, FORCE, [0.1, 0.1], "dt: expected one number or shape"),
    ],
)
def test_bad_samples_are_turned_away(gyro, accel, dt, message):
    with pytest.raises(ValueError, match=message):
        strapdown.navigate(gyro, accel, dt, NavigationState(), Local(G))


def test_bad_settings_are_turned_away():
    with pytest.raises(ValueError, match="every"):
        strapdown.navigate(RATE, FORCE, 0.1, NavigationState(), Local(G), every=0)
    with pytest.raises(ValueError, match="velocity: expected 3 finite"):
        NavigationState(velocity=(0, np.nan, 0))
    with pytest.raises(ValueError, match="attitude: expected 3 finite"):
        NavigationState(attitude=(0, 0))
    with pytest.raises(ValueError, match="gravity"):
        Local(-G)
    for latitude in (48.0, np.pi / 2, np.nan):
        with pytest.raises(ValueError, match="origin"):
            Ellipsoid(latitude, 0.0, 0.0)
    with pytest.raises(ValueError, match="other than zero"):
        strapdown.level(np.zeros(3))


def test_bad_logs_are_turned_away():
    log = from_samples(dict(zip(GYRO + ACCEL, np.hstack([RATE, FORCE]).T, strict=True)), 0.1)
    with pytest.raises(LogError, match="no gyro_z"):
        strapdown.trajectory(log.drop(columns="gyro_z"), NavigationState(), Local(G))
    for duration_s in (0.0, 0.5, np.nan):
        with pytest.raises(ValueError, match="duration_s"):
            strapdown.align(log, duration_s, 0.0)
