"""Clipped gyroscopes are found by the shape of their largest rates; smooth and pointed motions are not clipped."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from imugap.integrity.clipping import ALPHA, full_scale
from imugap.log import GYRO
from imugap.simulation.walk import Walk, WalkCourse

ROOT = Path(__file__).parents[2]
SEED = 5


@pytest.fixture(scope="module")
def walk():
    return replace(Walk.read(ROOT / "data" / "walk.yaml"), course=WalkCourse.loop(30), rate_hz=200)


@pytest.mark.parametrize("share", [0.5, 0.7, 0.85])
def test_the_full_scale_of_a_runner_is_found_behind_noise_and_calibration(walk, share):
    """Clipped first, then turned by misaligned axes, as a device does."""
    rates = walk.record(1, SEED)[list(GYRO)].to_numpy()
    limit = share * np.abs(rates).max()
    rng = np.random.default_rng(SEED)
    calibrated = np.clip(rates, -limit, limit) @ (np.eye(3) + 0.01 * rng.standard_normal((3, 3)))
    assert full_scale(calibrated + 0.005 * rng.standard_normal(rates.shape)) == pytest.approx(limit, rel=0.05)


@pytest.mark.parametrize("run", range(3))
@pytest.mark.parametrize("rate_hz", [100, 200])
def test_a_walk_within_the_full_scale_has_none(walk, run, rate_hz):
    log = replace(walk, rate_hz=rate_hz, gait=replace(walk.gait, push_deg=40 + 10 * run)).record(run, SEED)
    assert full_scale(log[list(GYRO)].to_numpy()) == np.inf


def test_a_swing_a_saw_and_a_rest_are_not_clipped():
    time = np.arange(4000) / 200
    for one in (np.sin(7 * time), np.abs(np.mod(time, 1.7) - 0.85), np.zeros_like(time)):
        assert full_scale(one[:, None]) == np.inf


def test_nothing_is_found_in_random_motion_more_often_than_the_level_allows():
    """500 logs of band-limited noise; flat tops occur in them by chance."""
    rng = np.random.default_rng(SEED)
    found = sum(
        np.isfinite(full_scale(gaussian_filter1d(rng.standard_normal((6000, 3)), 8, axis=0))) for _ in range(500)
    )
    assert found <= 500 * ALPHA + 3 * np.sqrt(500 * ALPHA)
