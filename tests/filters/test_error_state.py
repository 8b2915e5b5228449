"""The transition against finite differences of the navigator itself, the update and the smoother against algebra."""

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from imugap.filters.error_state import (
    NAVIGATION,
    adjoint_measurement,
    adjoint_transition,
    correct_navigation,
    innovation_variance,
    joseph_update,
    predict,
    propagate,
    scalar_update,
)
from imugap.kinematics.strapdown import increments, local_step
from imugap.numerics.rotation import mat_from_quat
from imugap.stream import stream

AXIS = np.array([0, 1, 2, 3, 4, 5, 2, 4])
GAIN = np.array([1.0, 1, 1, 1, 1, 1, 0.7, -9.0])
HOLD = np.array([1.0, 0.9, 1, 1, 0.8, 1, 1, 1])
ARMS = 3
SIZE = NAVIGATION + len(AXIS) + ARMS


def mat(quat):
    return tuple(tuple(row) for row in Rotation.from_quat(quat).as_matrix().tolist())


def transition(quat, force, dt):
    work, room = np.zeros((SIZE, SIZE)), np.zeros((6, SIZE))
    propagate(np.eye(SIZE), work, SIZE, mat(quat), tuple(force), dt, AXIS, GAIN, HOLD, room)
    return work.T


def covariance(*labels):
    root = stream(4, "covariance", *labels).standard_normal((SIZE, SIZE))
    return root @ root.T / SIZE


def step(quat, position, velocity, gyro, accel, dt):
    rotvec, push = increments(tuple(gyro), tuple(accel), tuple(gyro), tuple(accel), dt, dt)
    return local_step(tuple(position), tuple(velocity), tuple(quat), rotvec, push, dt, 9.81)


def apart(one, other):
    """Return the error of one navigation state against another: position, velocity, rotation vector in ``n``."""
    turn = (Rotation.from_quat(one[2]) * Rotation.from_quat(other[2]).inv()).as_rotvec()
    return np.concatenate([np.subtract(one[0], other[0]), np.subtract(one[1], other[1]), turn])


def test_the_transition_is_the_derivative_of_the_navigator():
    """Errors of state and sensors of 1e-6, carried by the navigator itself; what is left is of the order dt^2."""
    rng = stream(4, "derivative")
    gyro, accel = rng.standard_normal(3), 5 * rng.standard_normal(3)
    quat = Rotation.random(rng=rng).as_quat()
    position, velocity = rng.standard_normal((2, 3))
    misses = []
    for dt in (0.004, 0.002):
        true = step(quat, position, velocity, gyro, accel, dt)
        force = Rotation.from_quat(quat).apply(accel)
        columns = []
        for k in range(NAVIGATION + len(AXIS)):
            error, sensors = np.zeros(NAVIGATION), np.zeros(6)
            if k < NAVIGATION:
                error[k] = 1e-6
            else:
                sensors[AXIS[k - NAVIGATION]] = GAIN[k - NAVIGATION] * 1e-6
            begin = (Rotation.from_rotvec(error[6:]) * Rotation.from_quat(quat)).as_quat()
            found = step(
                begin, position + error[:3], velocity + error[3:6], gyro - sensors[:3], accel - sensors[3:], dt
            )
            columns.append(apart(found, true) / 1e-6)
        columns = np.array(columns).T
        own = transition(quat, force, dt)[:NAVIGATION, : NAVIGATION + len(AXIS)]
        misses.append(np.abs(own - columns).max())
    assert misses[0] < 2e-4
    assert misses[1] < 0.3 * misses[0]


def test_the_states_of_sensors_and_constants_only_decay():
    own = transition([0, 0, 0, 1.0], [0, 0, -9.81], 0.01)
    np.testing.assert_array_equal(own[NAVIGATION:, :NAVIGATION], 0)
    np.testing.assert_array_equal(own[NAVIGATION:, NAVIGATION:], np.diag([*HOLD, 1, 1, 1]))


def test_the_prediction_is_the_transition_on_both_sides_and_the_noise():
    """White noise is that of the attitude and the velocity, and of the position by the trapezoidal rule."""
    rng = stream(4, "prediction")
    quat, force, dt = Rotation.random(rng=rng).as_quat(), 9 * rng.standard_normal(3), 0.01
    white, drive = rng.uniform(0.1, 1, 6), rng.uniform(0.1, 1, len(AXIS))
    before = covariance("prediction")
    after, work, room = before.copy(), np.zeros((SIZE, SIZE)), np.zeros((6, SIZE))
    predict(after, work, mat(quat), tuple(force), dt, AXIS, GAIN, HOLD, drive, white, room)
    own, turn = transition(quat, force, dt), Rotation.from_quat(quat).as_matrix()
    pushed = np.zeros((SIZE, 6))
    pushed[6:9, :3], pushed[3:6, 3:], pushed[:3, 3:] = turn, turn, dt / 2 * turn
    noise = pushed @ np.diag(white * dt) @ pushed.T
    noise += block_diag(np.zeros((NAVIGATION, NAVIGATION)), np.diag(drive), np.zeros((ARMS, ARMS)))
    np.testing.assert_allclose(after, own @ before @ own.T + noise, atol=1e-12)
    np.testing.assert_allclose(after, after.T, atol=1e-14)


@pytest.mark.parametrize("share", [0.3, 1.0, 1.7])
def test_the_update_is_that_of_joseph_for_any_weight(share):
    rng = stream(4, "update")
    row, spread, noise = rng.standard_normal(SIZE), np.empty(SIZE), 0.4
    row[::3] = 0
    before = covariance("update")
    after = before.copy()
    variance = innovation_variance(before, row, noise, spread)
    assert variance == pytest.approx(row @ before @ row + noise)
    weight = share * spread / variance
    joseph_update(after, spread, weight, variance)
    left = np.eye(SIZE) - np.outer(weight, row)
    np.testing.assert_allclose(after, left @ before @ left.T + noise * np.outer(weight, weight), atol=1e-12)


def test_the_best_weight_is_the_best():
    row, spread = stream(4, "best").standard_normal(SIZE), np.empty(SIZE)
    traces = []
    for share in (0.9, 1.0, 1.1):
        after = covariance("best")
        variance = innovation_variance(after, row, 0.4, spread)
        joseph_update(after, spread, share * spread / variance, variance)
        traces.append(np.trace(after))
    assert traces[1] < min(traces[0], traces[2])


def test_a_correction_takes_the_error_off():
    rng = stream(4, "correction")
    quat, error = Rotation.random(rng=rng), 0.3 * rng.standard_normal(NAVIGATION)
    wrong = (Rotation.from_rotvec(error[6:]) * quat).as_quat()
    found = correct_navigation(tuple(error[:3] + 1), tuple(error[3:6] + 2), tuple(wrong), error)
    np.testing.assert_allclose(apart(found, (np.ones(3), np.full(3, 2.0), quat.as_quat())), 0, atol=1e-12)
    assert mat_from_quat(found[2])[0][0] == pytest.approx(quat.as_matrix()[0, 0])


def test_the_smoother_is_that_of_rauch_tung_and_striebel():
    """Two predictions and measurements, forward and back; the smoothed first error against the joint Gaussian."""
    rng = stream(4, "smoother")
    first, noise = covariance("first"), 0.3
    own = [transition(Rotation.random(rng=rng).as_quat(), 9 * rng.standard_normal(3), 0.1) for _ in range(2)]
    rows, seen = rng.standard_normal((2, SIZE)), rng.standard_normal(2)
    cov, block, mean = first.copy(), [], np.zeros(SIZE)
    for phi, row, value in zip(own, rows, seen, strict=True):
        cov, mean = phi @ cov @ phi.T, phi @ mean
        spread = cov @ row
        variance = row @ spread + noise
        residual = value - row @ mean
        block.append((phi, row, spread / variance, residual, variance))
        mean = mean + spread / variance * residual
        cov = cov - np.outer(spread, spread) / variance
    adjoint, information, work = np.zeros(SIZE), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for phi, row, weight, residual, variance in reversed(block):
        adjoint_measurement(adjoint, information, row, weight, residual, variance, work[0])
        adjoint_transition(adjoint, information, np.ascontiguousarray(phi.T), work)
    together = np.array([rows[0] @ own[0], rows[1] @ own[1] @ own[0]])
    gain = first @ together.T @ np.linalg.inv(together @ first @ together.T + noise * np.eye(2))
    np.testing.assert_allclose(-first @ adjoint, gain @ seen, atol=1e-10)
    np.testing.assert_allclose(first - first @ information @ first, first - gain @ together @ first, atol=1e-10)


def test_measurements_one_after_the_other_are_one_of_all():
    """Two rows in turn give covariance, feedback and chi-square statistic of the vector measurement."""
    rng = stream(4, "measure")
    rows = rng.standard_normal((2, SIZE))
    seen, noise = np.array([2e-5, -1e-5]), np.array([0.3, 0.5])
    before = covariance("measure")
    after, errors, spread, weight = before.copy(), np.zeros(SIZE - NAVIGATION), np.empty(SIZE), np.empty(SIZE)
    nav, statistic, taken = ((0.0,) * 3, (0.0,) * 3, (0.0, 0.0, 0.0, 1.0)), 0.0, np.zeros(SIZE)
    for row, value, variance in zip(rows, seen, noise, strict=True):
        residual = value + row @ taken
        nav, found = scalar_update(after, errors, row, residual, variance, spread, weight, nav, True)
        statistic += residual**2 / found
        taken = np.concatenate([nav[0], nav[1], Rotation.from_quat(nav[2]).as_rotvec(), errors])
    together = rows @ before @ rows.T + np.diag(noise)
    gain = before @ rows.T @ np.linalg.inv(together)
    np.testing.assert_allclose(taken, -gain @ seen, atol=1e-4 * np.abs(gain @ seen).max())
    np.testing.assert_allclose(after, before - gain @ rows @ before, atol=1e-12)
    assert statistic == pytest.approx(seen @ np.linalg.solve(together, seen), rel=1e-4)
