"""Reference attitudes: errors with a known answer, gaps, and an alignment whose truth is built in."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from imugap import log
from imugap.io.references import reference
from imugap.numerics.rotation import from_euler, rate_from_euler
from imugap.stream import stream

STEP, INNER = 0.01, 20
LAG, FRAME, BIAS = 0.0043, np.array([0.004, -0.003, 0.002]), np.array([0.01, -0.02, 0.015])
SWING, SPEED = np.array([1.1, 0.7, 2.0]), np.array([1.3, 0.9, 0.6])


def euler(time):
    """Angles of a hand that turns the body every way [rad]."""
    return SWING * np.sin(np.outer(time, SPEED))


def rate(time):
    return rate_from_euler(euler(time), SWING * SPEED * np.cos(np.outer(time, SPEED)))


@pytest.fixture(scope="module")
def motion():
    """Return a reference over 60 s with noise, and a log whose clock, axes and biases are off by known amounts."""
    rng, time = stream(3, "motion"), STEP * np.arange(6001)
    noise = Rotation.from_rotvec(1e-4 * rng.standard_normal((len(time), 3)))
    known = reference.from_rotations(time, from_euler(euler(time)) * noise, time > 2)
    within = time[1:, None] - LAG - STEP * (np.arange(INNER) + 0.5) / INNER
    mean = rate(within.ravel()).reshape(-1, INNER, 3).mean(axis=1)
    measured = mean + np.cross(FRAME, mean) + BIAS + 1e-3 * rng.standard_normal(mean.shape)
    return known, log.from_samples(dict(zip(log.GYRO, measured.T, strict=True)), STEP, start_s=STEP)


def test_alignment_finds_lag_axes_and_biases(motion):
    known, measured = motion
    found = reference.alignment(measured, known)
    true = np.array([LAG, *FRAME, *BIAS])
    half = (found["high"] - found["low"]) / 2
    assert (np.abs(found["value"] - true) < 2.5 * half).all()
    assert found["value"].to_numpy() == pytest.approx(true, abs=1e-3)
    assert found.loc["lag", "value"] == pytest.approx(LAG, abs=1e-4)
    assert half["lag"] < 1e-4


def test_alignment_without_motion_is_refused(motion):
    known, measured = motion
    still = known.assign(moving=known.index > 50)
    with pytest.raises(ValueError, match="expected 3 blocks of 10 s in motion or more; found 1"):
        reference.alignment(measured, still)


@given(st.tuples(*[st.floats(-3, 3)] * 3), st.tuples(*[st.floats(-1, 1)] * 3))
def test_the_error_is_the_rotation_in_n_that_was_put_in(attitude, turn):
    time = np.array([0.0, 1.0, 2.0])
    true = Rotation.concatenate([from_euler(attitude)] * 3)
    known = reference.from_rotations(time, true, time >= 0)
    estimated = reference.from_rotations(time, Rotation.from_rotvec(turn) * true, time >= 0)
    found = reference.error(estimated, known)
    np.testing.assert_allclose(found[list(reference.ERROR)], np.tile(turn, (3, 1)), atol=1e-9)


def test_a_heading_error_is_that_of_the_angle_across_the_turn_of_the_circle():
    time = np.array([0.0, 1.0])
    known = reference.from_rotations(time, from_euler([[0.1, 0.2, 3.1]] * 2), time >= 0)
    found = reference.error(reference.from_rotations(time, from_euler([[0.1, 0.2, -3.1]] * 2), time >= 0), known)
    assert found["heading"].to_numpy() == pytest.approx(2 * np.pi - 6.2)
    assert found["down"].to_numpy() == pytest.approx(2 * np.pi - 6.2)
    assert found["roll"].to_numpy() == pytest.approx(0, abs=1e-12)


def test_a_lag_shifts_the_solution_and_a_gap_of_the_reference_says_nothing():
    time = 0.01 * np.arange(1000)
    spin = from_euler(np.column_stack([0 * time, 0 * time, 2 * time]))
    known = reference.from_rotations(time, spin, time >= 0)
    known = pd.concat([known.loc[:3.0], known.loc[5.0:]])
    later = reference.from_rotations(time + 0.0153, spin, time >= 0)
    corrected, raw = reference.error(later, known, 0.0153), reference.error(later, known)
    assert corrected["down"].abs().max() < 1e-9
    assert raw["down"].to_numpy() == pytest.approx(-2 * 0.0153)
    assert not len(corrected.loc[3.03:5.0])
    assert len(corrected) == len(known)


def test_rests_leave_the_margin_next_to_motion_out():
    time = 0.1 * np.arange(1000)
    known = reference.from_rotations(time, Rotation.identity(1000), (time > 30) & (time < 70))
    samples = log.from_samples({"gyro_x": np.zeros(1000)}, 0.1)
    first, last = reference.rests(samples, known, 2.0)
    assert first.index[-1] == pytest.approx(28.1)
    assert last.index[0] == pytest.approx(71.9)
