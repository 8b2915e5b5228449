"""Gross errors: as many and as large as the recipe says, where it says, and the same for the same seed."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from imugap.io import gnss
from imugap.kinematics.strapdown import Ellipsoid
from imugap.simulation.gnss_faults import NO_INFORMATION_STD, OUTAGE, OUTLIER, RAMP, STRETCH, Faults, event_kinds

ROOT = Path(__file__).parents[2]
PLACE = Ellipsoid(0.8, 0.2, 500.0)
TIME = np.arange(1.0, 901.0)
STD = np.tile([1.5, 1.5, 3, 0.1, 0.1, 0.2], (len(TIME), 1))
LASTING = {STRETCH: "stretches", RAMP: "ramps", OUTAGE: "outages"}


@pytest.fixture(scope="module")
def faults():
    return Faults.read(ROOT / "data" / "drive.yaml")


@pytest.fixture(scope="module")
def fixes():
    return gnss.from_local(TIME, np.zeros((len(TIME), 6)), STD, PLACE)


def test_events_are_those_of_the_recipe(faults):
    for run in range(50):
        events = faults.draw(TIME, 1, run)
        for kind, name in (LASTING | {OUTLIER: "outliers"}).items():
            given, own = getattr(faults, name), [one for one in events if one.kind == kind]
            assert len(own) == given.number
            for one in own:
                assert given.duration_s[0] <= one.end - one.begin <= given.duration_s[1] + 1e-9
                size = np.hypot(*one.shift[:2])
                assert given.size[0] * (1 - 1e-9) <= size <= given.size[1] * (1 + 1e-9)
                assert abs(one.shift[2]) <= 0.5 * size
                assert one.begin >= faults.begin_s
        lasting = sorted((one.begin, one.end) for one in events if one.kind in LASTING)
        assert all(after[0] - before[1] > faults.gap_s for before, after in pairwise(lasting))
        alone = [one.begin for one in events if one.kind == OUTLIER]
        assert all(not begin <= t <= end for t in alone for begin, end in lasting)
        assert set(alone) <= set(TIME)


def test_directions_are_all_alike_and_sizes_even_on_a_logarithmic_scale(faults):
    events = [one for run in range(100) for one in faults.draw(TIME, 2, run) if one.kind == OUTLIER]
    shifts = np.array([one.shift for one in events])
    angle = np.arctan2(shifts[:, 1], shifts[:, 0])
    assert abs(np.exp(1j * angle).mean()) < 4 / np.sqrt(len(angle))
    low, high = np.log(faults.outliers.size)
    share = (np.log(np.hypot(shifts[:, 0], shifts[:, 1])) - low) / (high - low)
    assert abs(share.mean() - 0.5) < 4 * np.sqrt(1 / 12 / len(share))


def test_fixes_are_shifted_where_the_events_are_and_nowhere_else(faults, fixes):
    events = faults.draw(TIME, 3, 0)
    spoilt = faults.apply(fixes, events, PLACE, 3, 0)
    kinds = event_kinds(TIME, events)
    np.testing.assert_array_equal(spoilt.index, TIME[kinds != OUTAGE])
    off, left = gnss.local(spoilt, PLACE), kinds[kinds != OUTAGE]
    assert np.abs(off[left == ""]).max() < 1e-6
    for one in events:
        inside = (spoilt.index >= one.begin) & (spoilt.index <= one.end)
        if one.kind in (STRETCH, OUTLIER):
            np.testing.assert_allclose(off[inside, :3], np.tile(one.shift, (inside.sum(), 1)), atol=1e-6)
            assert np.abs(off[inside, 3:]).max() < 5 * faults.velocity_per_s * np.linalg.norm(one.shift)
        elif one.kind == RAMP:
            np.testing.assert_allclose(
                off[inside, :3], (spoilt.index[inside] - one.begin).to_numpy()[:, None] * one.shift, atol=1e-6
            )
            assert np.abs(off[inside, 3:]).max() < 1e-6


def test_an_oracle_knows_what_is_bad(faults, fixes):
    events = faults.draw(TIME, 4, 0)
    told = faults.with_true_deviations(faults.apply(fixes, events, PLACE, 4, 0), events)
    bad = event_kinds(told.index.to_numpy(), events) != ""
    np.testing.assert_array_equal(told["sd_n"] == NO_INFORMATION_STD, bad)
    ramp = event_kinds(told.index.to_numpy(), events) == RAMP
    assert (told["sd_vel_n"][ramp] == 0.1).all()
    assert (told["sd_vel_n"][bad & ~ramp] > 0.1).all()


def test_the_same_seed_draws_the_same_and_runs_differ(faults):
    assert faults.draw(TIME, 1, 5) == faults.draw(TIME, 1, 5) != faults.draw(TIME, 1, 6)


def test_a_drive_without_room_is_told(faults):
    crowded = replace(faults, stretches=replace(faults.stretches, number=40))
    with pytest.raises(ValueError, match="faults: expected room for events"):
        crowded.draw(TIME, 1, 1)
