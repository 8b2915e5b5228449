"""GPS time and UTC, on dates for which their difference is published (IERS Bulletin C)."""

from datetime import UTC, datetime

import numpy as np
import pytest

from imugap.io.fixes.gps_time import GPS_EPOCH_S, utc


@pytest.mark.parametrize(
    ("date", "leap"),
    [
        ((1980, 1, 6), 0),
        ((1999, 6, 1), 13),
        ((2008, 12, 31), 14),
        ((2009, 1, 2), 15),
        ((2016, 6, 1), 17),
        ((2024, 5, 1), 18),
    ],
)
def test_utc_is_behind_by_the_leap_seconds_of_the_date(date, leap):
    due = datetime(*date, tzinfo=UTC).timestamp()
    assert utc(np.array([due + leap])) == due


def test_the_clocks_differ_by_a_further_second_after_a_leap_second():
    due = datetime(2017, 1, 1, tzinfo=UTC).timestamp()
    assert list(utc(due + np.array([16.0, 18.0]))) == [due - 1, due]


def test_gps_time_begins_with_utc():
    assert utc(np.array([float(GPS_EPOCH_S)])) == GPS_EPOCH_S
