"""Logs that cannot be of a foot in motion under gravity are refused by name; sound ones pass."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap.log import GYRO
from imugap.navigation.walk.pedestrian import WalkAssumptions, align
from imugap.navigation.walk.walk_physics import StanceFit, check_walk
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
    "as of stamps of twice the true interval": lambda log: stamped(log, 2.0),
    "as of rates 57.3 times too small": lambda log: log.assign(**{name: np.radians(log[name]) for name in GYRO}),
    "as of gyro_y of the opposite sign": lambda log: log.assign(gyro_y=-log["gyro_y"]),
    "as of gyro_x and gyro_y exchanged": lambda log: log.assign(gyro_x=log["gyro_y"], gyro_y=log["gyro_x"]),
    "as of rates of twice the turns": lambda log: log.assign(**{name: 2 * log[name] for name in GYRO}),
    "as of accel_x of the opposite sign": lambda log: log.assign(accel_x=-log["accel_x"]),
    "as of left-handed ones": lambda log: log.assign(gyro_y=-log["gyro_y"], accel_y=-log["accel_y"]),
}


@pytest.mark.parametrize(("words", "spoil"), SPOILT.items(), ids=SPOILT)
def test_wrong_physics_is_named(walk, words, spoil):
    with pytest.raises(ValueError, match=f"walk: expected .*; found .*{words}"):
        check(walk, spoil(walk.record(1, SEED)))


def test_a_wrong_gravity_is_refused(walk):
    with pytest.raises(ValueError, match=r"near 20 m/s\^2 \(--gravity\); found 9\.[78]"):
        check(walk, walk.record(1, SEED), 20.0)


def fit(walk, log):
    return StanceFit.of(align(log, walk.model, WalkAssumptions(gravity=walk.site.gravity, floor_std=0.01)))


@pytest.mark.parametrize("run", range(3))
def test_a_sound_walk_is_not_doubted(walk, run):
    assert str(fit(walk, walk.record(run, SEED))) == ""


def test_a_knock_makes_the_walk_less_certain(walk):
    log = walk.record(1, SEED)
    swing = int(np.linalg.norm(log[list(GYRO)], axis=1).argmax())
    log.iloc[swing : swing + 3, 3:] += 150.0
    found = fit(walk, log)
    assert found.factor > 2
    assert "less exactly than stated" in str(found)


def test_a_scale_that_lifts_every_stride_is_told_from_a_level_floor(walk):
    log = walk.record(1, SEED)
    found = fit(walk, log.assign(**{name: 1.15 * log[name] for name in GYRO}))
    assert found.climbs
    assert "not on the level of the last one" in str(found)
