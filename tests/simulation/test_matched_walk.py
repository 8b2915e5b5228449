from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.analysis.walk import DEFAULT_MODEL
from imugap.effects import ScaleFactor, TimeOffset
from imugap.kinematics.strapdown import POSITION, VELOCITY
from imugap.log import ACCEL, GYRO
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import WalkAssumptions, navigate
from imugap.simulation.matched_walk import DeviceClass, matched_walk, simulated_walk, without
from imugap.simulation.walk import Walk, WalkCourse, WalkLeg

ROOT = Path(__file__).parents[2]
SEED = 61


@pytest.fixture(scope="module")
def walk():
    recipe = Walk.read(ROOT / "data" / "walk.yaml")
    legs = (WalkLeg(6), WalkLeg(3, turn_deg=30.0), WalkLeg(4, rise_m=0.15, share=0.5))
    return replace(recipe, course=WalkCourse(4.0, legs, 1.0), rate_hz=100)


@pytest.fixture(scope="module")
def kind():
    return DeviceClass.read(ROOT / "data" / "foot.yaml")


def shrunk(given):
    """Return parameters of an error a tenth of the size."""
    return {key: shrunk(value) if isinstance(value, dict) else value / 10 for key, value in given.items()}


def of(model, axis, effect):
    return next(one for one in model[axis] if isinstance(one, effect))


def test_devices_spread_as_their_kind_does(kind):
    drawn = [kind.draw(SEED, run) for run in range(300)]
    scales = np.array([[of(one, axis, ScaleFactor).error for axis in (*GYRO, *ACCEL)] for one in drawn])
    np.testing.assert_allclose(scales.std(axis=0), 3e-3, rtol=4 / np.sqrt(600))
    np.testing.assert_allclose(np.corrcoef(scales.T) - np.eye(6), 0, atol=4 / np.sqrt(300))
    delays = np.array([[of(one, axis, TimeOffset).offset for axis in GYRO] for one in drawn])
    assert (delays == delays[:, :1]).all()
    assert kind.draw(SEED, 3).to_mapping() == drawn[3].to_mapping()


def test_a_device_without_an_error_has_all_others(kind):
    whole = kind.draw(SEED, 1)
    for triad, name in kind.names():
        left, spared = without(whole, triad, name), GYRO if triad == "gyro" else ACCEL
        for axis in (*GYRO, *ACCEL):
            gone = set(whole[axis]) - set(left[axis])
            assert {one.name for one in gone} == ({name} if axis in spared else set())


def test_the_twin_of_a_walk_goes_its_strides(walk):
    solution = navigate(walk.ideal(0, SEED), ErrorModel({}), WalkAssumptions(gravity=walk.site.gravity), smooth=True)
    other = matched_walk(solution, walk)
    strides = list(other.course.strides())
    assert len(strides) == 13
    assert other.rate_hz == pytest.approx(walk.rate_hz)
    assert other.gait.length_m == pytest.approx(walk.gait.length_m, abs=0.02)
    assert other.gait.stride_s == pytest.approx(walk.gait.stride_s, abs=0.02)
    np.testing.assert_allclose([one.turn_deg for one in strides], [0] * 6 + [30] * 3 + [0] * 4, atol=2)
    np.testing.assert_allclose([one.rise_m for one in strides], [0] * 9 + [0.15] * 4, atol=0.03)
    assert other.duration_s == pytest.approx(walk.duration_s, abs=0.5)
    ends = [one.truth(0, SEED)[list(POSITION)].iloc[-1].to_numpy(float) for one in (walk, other)]
    assert np.abs(ends[0] - ends[1]).max() < 0.3


@pytest.mark.slow
def test_what_single_errors_do_to_the_end_adds_up(walk, kind):
    """While errors are small: all at once, or the sum of the differences that leaving one out makes."""
    loop = replace(walk, course=WalkCourse.loop(20), gait=replace(walk.gait, drift_m_per_s=0.0))
    ideal, assumptions = loop.ideal(0, SEED), WalkAssumptions(gravity=loop.site.gravity)

    def end(model, run):
        found = navigate(model.simulate(ideal, SEED, "log", run), DEFAULT_MODEL, assumptions).trajectory
        return found[["north", "east"]].iloc[-1].to_numpy()

    small = DeviceClass(
        {triad: {name: shrunk(given) for name, given in of.items()} for triad, of in kind.errors.items()}
    )
    for run in range(3):
        device = small.draw(SEED, run)
        every, none = end(device, run), end(ErrorModel({}), run)
        parts = sum(every - end(without(device, *name), run) for name in kind.names())
        assert np.abs(every - none - parts).max() < 0.1 * np.abs(every - none).max() + 1e-4


def test_the_measured_velocity_is_that_of_a_point_of_the_foot(walk):
    """With an arm of no length it is the velocity of the device, with noise of the assumed density."""
    assumptions = WalkAssumptions(arm_std=0.0)
    _, velocity = simulated_walk(walk, assumptions, 0, SEED)
    noise = velocity - walk.truth(0, SEED)[list(VELOCITY)].to_numpy(float)
    expected = np.sqrt(2 * assumptions.velocity_std**2 * assumptions.correlation_s * walk.rate_hz)
    np.testing.assert_allclose(noise.std(axis=0), expected, rtol=4 / np.sqrt(2 * len(noise)))
