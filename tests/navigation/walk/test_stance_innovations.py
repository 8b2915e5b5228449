from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.effects import Misalignment
from imugap.model import ErrorModel
from imugap.navigation.walk.stance_innovations import bonferroni_limit, candidate_errors, stance_test
from imugap.simulation.walk import Walk, WalkCourse
from imugap.study.walk.walk_compensation import known_assumptions

ROOT = Path(__file__).parents[3]
SEED = 71


@pytest.fixture(scope="module")
def loop():
    return replace(Walk.read(ROOT / "data" / "walk.yaml"), rate_hz=100, course=WalkCourse.loop(40))


def test_the_limit_is_that_of_a_normal_deviate_shared_among_the_trials():
    assert bonferroni_limit(0.05, 1) == pytest.approx(1.95996, abs=1e-4)
    assert bonferroni_limit(0.05, 20) > bonferroni_limit(0.05, 2) > bonferroni_limit(0.05, 1)


def test_suspects_are_all_different():
    names = [(one.name, one.axes, one.parameter) for one in candidate_errors()]
    assert len(set(names)) == len(names) == 6 + 12 + 9 + 1


@pytest.mark.parametrize("run", [1, 2])
def test_a_device_as_its_model_has_it_gets_no_name(loop, run):
    said = stance_test(loop.record(run, SEED), loop.model, known_assumptions(loop))
    assert said.named(0.01).empty
    assert np.isfinite(said.table["deviate"]).all()


def test_a_leaning_accelerometer_is_seen_and_its_angle_is_right(loop):
    leaning = ErrorModel(dict(loop.model.axes) | {"accel_x": loop.model["accel_x"] + Misalignment(z=0.02)})
    log = leaning.simulate(loop.ideal(1, SEED), SEED, "leaning")
    said = stance_test(log, loop.model, known_assumptions(loop))
    assert not said.named(0.01).empty
    table = said.table.set_index(["name", "axis", "parameter"])
    one = table.loc[("misalignment", "accel_x", "z")]
    assert abs(one["value"] - 0.02) < 3 * one["std"]
    assert abs(one["deviate"]) > bonferroni_limit(0.01, len(table))
