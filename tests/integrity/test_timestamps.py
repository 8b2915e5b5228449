"""Lost samples are put where they were; what is whole comes back as it is."""

import numpy as np
import pandas as pd
import pytest

from imugap.integrity.packet_clock import packet_slots
from imugap.integrity.timestamps import filled, stamps
from imugap.log import LogError, from_samples, interval
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


@pytest.mark.parametrize("rate", [260.0, 520.0, 666.7, 749.9, 800.0, 833.3, 952.0, 970.0, 1149.3, 1942.0, 2960.3])
@pytest.mark.parametrize("begin", [0.0, 1.7e9 + 0.4])
@pytest.mark.parametrize("count", [300, 4000])
def test_steps_of_a_clock_rounded_to_milliseconds_are_no_lost_samples(rate, begin, count):
    found = stamps(np.round(begin + np.arange(count) / rate, 3))
    assert found.interval == pytest.approx(1 / rate, abs=2e-3 / count)
    assert found.kept.all()
    assert not found.lost.any()


@pytest.mark.parametrize("share", [0.03, 0.1, 0.2, 0.3])
def test_steps_of_one_and_two_intervals_at_random_are_lost_samples(share):
    number = np.arange(4000)
    single = (stream(3, "single", share).random(4000) < share) & (number % 2 == 1)
    found = stamps(number[~single] / 1000)
    assert found.interval == pytest.approx(1e-3, rel=1e-9)
    assert found.lost.sum() == single[: number[~single][-1]].sum()


def test_losses_of_several_samples_are_found_between_coarse_stamps():
    number = np.setdiff1d(np.arange(4000), np.r_[500:504, 1800:1803, 3000:3020])
    found = stamps(np.round(number / 800, 3))
    assert found.interval == pytest.approx(1 / 800, rel=1e-6)
    np.testing.assert_array_equal(np.flatnonzero(~found.lost), number)


@pytest.mark.filterwarnings("error")
def test_stamps_that_are_all_alike_come_in_no_packets():
    assert packet_slots(np.full(400, 15.96)) is None


def test_rows_out_of_order_far_too_few_for_their_time_are_refused():
    time = 0.01 * np.arange(400)
    time[1::4], time[2::4] = time[2::4].copy(), time[1::4].copy()
    time[200:] += 1e4
    with pytest.raises(LogError, match="one recording without a pause of most of its time"):
        stamps(time)
