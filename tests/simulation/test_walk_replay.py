from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.effects import Misalignment, ScaleFactor
from imugap.effects.effect import AxisModel
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import navigate
from imugap.simulation.matched_walk import AT_REST, DeviceClass
from imugap.simulation.walk import Walk, WalkCourse
from imugap.simulation.walk_replay import Replay
from imugap.study.walk.walk_compensation import known_assumptions

ROOT = Path(__file__).parents[2]
SEED = 73


@pytest.fixture(scope="module")
def loop():
    walk = Walk.read(ROOT / "data" / "walk.yaml")
    return replace(walk, rate_hz=100, course=WalkCourse.loop(30), gait=replace(walk.gait, drift_m_per_s=0.0))


@pytest.fixture(scope="module")
def replay(loop):
    return Replay.of(loop.record(1, SEED), loop.model, known_assumptions(loop), seen=False)


def of(effect, axis="accel_x"):
    return ErrorModel({axis: AxisModel((effect,))})


def test_without_errors_the_end_stays(replay):
    assert np.array_equal(replay.end(ErrorModel({}), replay.still(), SEED), np.zeros(3))


def test_an_error_moves_the_end_in_proportion(replay):
    once, twice = (replay.end(of(Misalignment(z=size)), replay.still(), SEED) for size in (0.002, 0.004))
    assert np.linalg.norm(once) > 0.001
    assert np.linalg.norm(twice - 2 * once) < 0.1 * np.linalg.norm(twice)


def test_the_replay_of_a_log_with_errors_is_that_of_the_walk_without(loop, replay):
    """An error does to a log with errors what it does to one without."""
    clean = Replay.of(loop.ideal(1, SEED), loop.model, known_assumptions(loop), seen=False)
    for effect, axis in ((ScaleFactor(error=0.005), "gyro_y"), (Misalignment(x=0.01), "gyro_z")):
        ends = [one.end(of(effect, axis), one.still(), SEED) for one in (clean, replay)]
        assert np.linalg.norm(ends[0] - ends[1]) < 0.2 * np.linalg.norm(ends[0])


def test_a_foot_that_sinks_makes_the_height_rise_like_that_of_a_gait_that_drifts(loop):
    """The filter takes the foot for still: what it sinks at stance it is thought not to have."""
    replay = Replay.of(loop.ideal(1, SEED), loop.model, known_assumptions(loop), seen=False)
    velocity = replay.sink(0.01)
    assert set(np.unique(velocity[:, 2])) == {0.0, 0.01}
    down = replay.end(ErrorModel({}), velocity, SEED)[2]
    told = navigate(replay.log, loop.model, known_assumptions(loop), velocity=velocity).trajectory["down"].iloc[-1]
    assert down < -0.02
    assert np.isclose(down, -(told - replay.solution.trajectory["down"].iloc[-1]), rtol=0.05)


def test_slips_are_drawn_for_each_stance(replay):
    velocity = replay.slip(0.01, np.random.default_rng(1))
    stance = np.any(velocity != 0, axis=1)
    runs = np.split(velocity[stance], np.flatnonzero(np.diff(np.flatnonzero(stance)) > 1) + 1)
    assert len(runs) >= 30
    assert all(np.ptp(run, axis=0).max() == 0 for run in runs)
    assert 0.007 < np.std([run[0] for run in runs]) < 0.013


def test_as_cameras_see_it_heading_and_origin_do_not_count(loop):
    """A turn of the whole walk is no error of its end once the heading is fitted."""
    plain, fitted = (
        Replay.of(loop.record(1, SEED), loop.model, known_assumptions(loop), seen=one) for one in (False, True)
    )
    error = of(ScaleFactor(error=0.01), "gyro_z")
    assert np.array_equal(plain.solution.trajectory[list(POSITION)], fitted.solution.trajectory[list(POSITION)])
    assert np.abs(fitted.end(ErrorModel({}), fitted.still(), SEED)).max() < 1e-6
    ends = [np.hypot(*one.end(error, one.still(), SEED)[:2]) for one in (plain, fitted)]
    assert ends[1] != ends[0]


def test_a_log_at_rest_knows_a_part_of_the_kind():
    kind = DeviceClass.read(ROOT / "data" / "foot.yaml")
    rest = kind.only(AT_REST)
    assert set(rest.errors) == set(kind.errors)
    assert {name for _, name in rest.names()} == set(AT_REST)
    assert {name for _, name in kind.names()} > set(AT_REST)
