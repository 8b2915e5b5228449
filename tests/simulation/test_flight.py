from pathlib import Path

import numpy as np
import pytest

from imugap import log
from imugap.io.references import reference
from imugap.kinematics import strapdown
from imugap.kinematics.strapdown import ATTITUDE, POSITION, VELOCITY, Local, NavigationState
from imugap.numerics.rotation import from_euler
from imugap.simulation.flight import Flight

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def flight():
    return Flight.read(ROOT / "data" / "flight.yaml")


def test_navigating_the_ideal_log_gives_the_truth_back(flight):
    """Rate and specific force are those of the one course: free-inertial navigation over 270 s closes on it."""
    truth, ideal = flight.truth(), flight.ideal()
    state = NavigationState(*(tuple(truth.iloc[0][list(names)]) for names in (POSITION, VELOCITY, ATTITUDE)))
    path = strapdown.trajectory(ideal, state, Local(flight.site.gravity))
    missed = (from_euler(path[list(ATTITUDE)].to_numpy()) * reference.rotations(truth).inv()).magnitude()
    assert missed.max() < 1e-6
    assert np.abs(path[list(VELOCITY)] - truth[list(VELOCITY)]).to_numpy().max() < 1e-3
    assert np.abs(path[list(POSITION)] - truth[list(POSITION)]).to_numpy().max() < 0.1
    assert truth[list(POSITION)].iloc[-1].abs().max() > 1000


def test_the_flight_rests_then_flies_with_a_disturbance_where_it_is_asked_for(flight):
    truth, ideal = flight.truth(), flight.ideal()
    rest = ideal.loc[: -flight.course.launch_s - 1]
    np.testing.assert_allclose(rest, np.tile(flight.site.ideal(), (len(rest), 1)), atol=1e-6)
    roll = np.degrees(truth["roll"])
    swing = roll.loc[100:120]
    assert np.ptp(swing) > 20
    assert np.ptp(roll.loc[85:99]) < 1
    assert np.ptp(roll.loc[121:135]) < 1
    assert reference.motion(truth) == pytest.approx((0, 200), abs=0.021)


def test_a_steady_turn_is_coordinated(flight):
    """The specific force has no component along the wing where neither gust nor swing has one."""
    turn = flight.ideal().loc[39:41]
    assert turn["accel_y"].abs().max() < 0.05
    assert np.degrees(flight.truth().loc[39:41, "roll"]).min() > 8


def test_runs_differ_and_are_repeatable(flight):
    first, again, other = (flight.static(run, 20.0, 3) for run in (1, 1, 2))
    assert first.equals(again)
    assert not np.allclose(first, other)
    assert log.axes(first) == log.AXES
