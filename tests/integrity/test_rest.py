"""A device at rest is called so whatever its noise and drift, and one that is moved is not."""

import numpy as np
import pandas as pd
import pytest

from imugap.integrity.rest import motion, vertical
from imugap.log import AXES, TIME
from imugap.stream import stream

GRADES = {"tactical": (1e-5, 1e-4), "good": (2e-4, 2e-3), "cheap": (1e-3, 1e-2)}
SIZES = np.repeat([1.0, 3.0], 3)


def at_rest(rate, densities, seconds=400):
    values = stream(7, "rest", rate).standard_normal((round(rate * seconds), 6))
    values *= np.repeat(densities, 3) * np.sqrt(rate)
    values[:, 5] -= 9.80665
    return pd.DataFrame(values, columns=list(AXES), index=pd.Index(np.arange(len(values)) / rate, name=TIME))


@pytest.fixture(params=[25.0, 100.0, 400.0])
def rate(request):
    return request.param


@pytest.fixture(params=GRADES)
def still(request, rate):
    return at_rest(rate, GRADES[request.param])


def test_noise_drift_vibration_and_a_knock_are_no_motion(still, rate):
    time = still.index.to_numpy()
    assert motion(still, 1 / rate).at_rest
    assert motion(still + np.linspace(0, 0.05, len(still))[:, None] * SIZES, 1 / rate).at_rest
    assert motion(still + 0.02 * np.sin(2 * np.pi * 11.3 * time)[:, None] * SIZES, 1 / rate).at_rest
    knocked = still.copy()
    knocked.iloc[len(still) // 2] += 20
    assert motion(knocked, 1 / rate).at_rest


def test_a_log_that_is_shaken_for_a_while_is_not_at_rest(still, rate):
    time = still.index.to_numpy()
    moved = ((time >= 200) & (time < 215))[:, None] * np.sin(2 * np.pi * 1.3 * time[:, None] + np.arange(6)) * SIZES
    found = motion(still + moved, 1 / rate)
    assert not found.at_rest
    assert not found.mostly
    assert found.stretches == [(pytest.approx(200, abs=1.01), pytest.approx(215, abs=1.01))]
    assert found.longest_rest == (0.0, pytest.approx(200, abs=1.01)) or found.longest_rest[0] >= 214


def test_gaps_are_no_motion(still, rate):
    holed = still.copy()
    holed.iloc[len(still) // 3 : len(still) // 2] = np.nan
    assert motion(holed, 1 / rate).at_rest


def test_a_gap_is_no_rest_to_cut_a_log_to(still, rate):
    second = round(rate)
    moved = still + (np.arange(len(still)) > 300 * second)[:, None] * np.sin(np.arange(len(still)) / rate)[:, None]
    moved.iloc[10 * second : 280 * second] = np.nan
    found = motion(moved, 1 / rate)
    assert found.mostly
    np.testing.assert_allclose(found.longest_rest, (280, 300), atol=2)


def test_a_log_in_motion_throughout_is_one(rate):
    log = at_rest(rate, GRADES["good"])
    swing = np.sin(2 * np.pi * 0.9 * log.index.to_numpy()[:, None] + np.arange(6)) * SIZES
    assert motion(log + swing, 1 / rate).mostly


@pytest.mark.parametrize(
    ("axis", "value", "down"), [("accel_z", -9.8, "+z"), ("accel_z", 9.8, "-z"), ("accel_x", 9.8, "-x")]
)
def test_gravity_is_opposite_to_the_specific_force(axis, value, down):
    log = at_rest(100.0, GRADES["good"], 10) * 0.01
    log["accel_z"] = 0.0
    log[axis] = value
    direction, angle = vertical(log)
    assert direction == down
    assert angle < 0.01


def test_the_vertical_needs_three_accelerometers_and_gravity():
    weightless = at_rest(100.0, GRADES["good"], 10)
    weightless["accel_z"] += 9.7
    assert vertical(weightless) is None
    assert vertical(at_rest(100.0, GRADES["good"], 10)[["gyro_x", "accel_z"]]) is None
