"""Logs that cannot be of a foot in motion under gravity are refused by name; sound ones pass."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap.log import GYRO
from imugap.navigation.walk.pedestrian import WalkAssumptions
from imugap.navigation.walk.walk_physics import check_walk
from imugap.simulation.walk import Walk, WalkCourse

ROOT = Path(__file__).parents[3]
SEED = 32


@pytest.fixture(scope="module")
def walk():
    recipe = Walk.read(ROOT / "data" / "walk.yaml")
    return replace(recipe, course=WalkCourse.out_and_back(8, stand_s=4.0))


def check(walk, log, gravity=None):
    check_walk(log, walk.model, WalkAssumptions(gravity=gravity or walk.site.gravity))


def stamped(log, factor):
    return log.set_index(pd.Index(factor * log.index.to_numpy(), name="time"))


@pytest.mark.parametrize("run", range(3))
def test_a_sound_walk_passes_from_a_short_stand_too(walk, run):
    log = walk.record(run, SEED)
    check(walk, log)
    moving = np.linalg.norm(log[list(GYRO)], axis=1) > 1.0
    begin = log.index[np.argmax(moving)]
    check(walk, log.loc[begin - 0.45 :])


SPOILT = {
    "constant 0": lambda log: log.assign(accel_z=0.0),
    "as of stamps of twice the interval": lambda log: stamped(log, 2.0),
    "as of angular rates 57.3 times too small": lambda log: log.assign(
        **{name: np.radians(log[name]) for name in GYRO}
    ),
}


@pytest.mark.parametrize(("words", "spoil"), SPOILT.items(), ids=SPOILT)
def test_wrong_physics_is_named(walk, words, spoil):
    with pytest.raises(ValueError, match=f"walk: expected .*; found .*{words}"):
        check(walk, spoil(walk.record(1, SEED)))


def test_a_wrong_gravity_is_refused(walk):
    with pytest.raises(ValueError, match=r"near 20 m/s\^2 \(--gravity\); found 9\.[78]"):
        check(walk, walk.record(1, SEED), 20.0)
