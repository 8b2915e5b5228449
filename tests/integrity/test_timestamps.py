"""Lost samples are put where they were; what is whole comes back as it is."""

import numpy as np
import pandas as pd

from imugap.integrity.timestamps import filled
from imugap.log import from_samples, interval
from imugap.stream import stream


def line(count=600):
    """A log whose columns are straight lines in time."""
    number = np.arange(count)
    return from_samples({"gyro_x": 0.01 * number, "accel_z": 5 - 0.02 * number}, 0.0025)


def test_lost_samples_come_back_on_the_line_between_their_neighbours():
    whole = line()
    lost = stream(1, "filled").choice(np.arange(1, 599), 60, replace=False)
    found = filled(whole.drop(whole.index[lost]))
    pd.testing.assert_frame_equal(found, whole, check_exact=False, rtol=1e-9)


def test_stamps_of_a_jittering_clock_stay_and_the_grid_follows_them():
    whole = line()
    jitter = 0.0002 * stream(2, "filled").uniform(-1, 1, 600)
    whole.index = pd.Index(whole.index + jitter, name="time")
    found = filled(whole.drop(whole.index[[100, 101, 300]]))
    assert len(found) == 600
    kept = np.setdiff1d(np.arange(600), [100, 101, 300])
    np.testing.assert_array_equal(found.index[kept], whole.index[kept])
    assert np.abs(found.index[[100, 101, 300]] - whole.index[[100, 101, 300]]).max() < 0.0004
    assert interval(found) < 1.01 * interval(whole)


def test_a_whole_log_comes_back_as_it_is():
    whole = line()
    assert filled(whole) is whole
