from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from imugap.kinematics.strapdown import COLUMNS, POSITION
from imugap.numerics.rotation import from_euler
from imugap.simulation.camera_track import compare_with_cameras
from imugap.stream import stream

SEED = 51
ARM, LAG, HEADING, ORIGIN = np.array([0.1, -0.03, 0.05]), 0.012, 2.1, np.array([3.0, -7.0, 1.0])


def path(time):
    """A figure of eight with swings of pitch, as a foot has them: positions and Euler angles."""
    angle, swing = 2 * np.pi * time / 30, np.sin(2 * np.pi * time / 1.1)
    position = np.column_stack([4 * np.sin(angle), 2 * np.sin(2 * angle), 0.05 * swing])
    heading = np.unwrap(np.arctan2(4 * np.cos(2 * angle), 4 * np.cos(angle)))
    return position, np.column_stack([0.1 * np.sin(time), 0.5 * swing, heading])


def solution(rate=100.0):
    time = np.arange(round(30 * rate)) / rate
    position, euler = path(time)
    table = pd.DataFrame(0.0, index=pd.Index(time, name="time"), columns=list(COLUMNS))
    table[list(POSITION)], table[["roll", "pitch", "heading"]] = position, euler
    return SimpleNamespace(trajectory=table)


def sighting(noise=0.0):
    """What cameras saw, at another rate, with stamps that are late."""
    time = np.arange(20, 2960) / 99.0
    position, euler = path(time)
    c, s = np.cos(HEADING), np.sin(HEADING)
    marker = (position + from_euler(euler).apply(ARM)) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + ORIGIN
    marker += noise * stream(SEED, "marker").standard_normal(marker.shape)
    return pd.DataFrame(marker, index=pd.Index(time + LAG, name="time"), columns=list(POSITION))


def test_where_the_marker_sits_and_how_the_frames_lie_is_found():
    found = compare_with_cameras(solution(), sighting())
    assert found.heading == pytest.approx(HEADING, abs=1e-4)
    assert found.lag == pytest.approx(LAG, abs=1e-4)
    np.testing.assert_allclose(found.arm, ARM, atol=1e-3)
    assert max(found.rmse()) < 1e-3
    assert max(map(abs, found.end())) < 2e-3
    assert found.reach()[0] == pytest.approx(found.reach()[1], abs=1e-3)


def test_noise_of_the_cameras_is_the_error_that_is_left():
    """Two thirds of its variance, which a straight line between samples has in the mean."""
    horizontal, vertical = compare_with_cameras(solution(), sighting(0.02)).rmse()
    assert horizontal == pytest.approx(0.02 * np.sqrt(2 * 2 / 3), rel=0.07)
    assert vertical == pytest.approx(0.02 * np.sqrt(2 / 3), rel=0.1)


def test_a_scale_is_not_fitted_away():
    one = solution()
    one.trajectory[list(POSITION)] *= 1.02
    found = compare_with_cameras(one, sighting())
    assert found.reach()[0] / found.reach()[1] == pytest.approx(1.02, abs=0.004)
    strides = pd.DataFrame({"start": np.arange(2.0, 27.0), "end": np.arange(2.0, 27.0) + 1.1})
    lengths = found.strides(strides)
    assert len(lengths) == len(strides)
    assert (lengths["found"] / lengths["seen"]).mean() == pytest.approx(1.02, abs=0.004)


def test_what_cameras_lost_does_not_count():
    """A marker that freezes and one that jumps, each for half a second; strides that end there are left out."""
    seen = sighting()
    seen.iloc[500:550] = seen.iloc[500].to_numpy()
    seen.iloc[1500:1550] += [0.8, 0.0, 0.0]
    seen.iloc[1501:1550] = seen.iloc[1501].to_numpy()
    found = compare_with_cameras(solution(), seen)
    assert max(found.rmse()) < 2e-3
    assert 0.02 < np.isnan(found.seen[:, 0]).mean() < 0.06
    assert len(found.strides(pd.DataFrame({"start": [1.0, 4.0], "end": [2.0, 5.5]}))) == 1


def test_a_marker_taken_for_the_device_leaves_its_arm_in_the_error():
    rigid, loose = (compare_with_cameras(solution(), sighting(), stiff=stiff) for stiff in (True, False))
    assert not loose.arm.any()
    assert loose.rmse()[0] > 10 * rigid.rmse()[0]
