"""Time scales of receivers, in seconds since 1970: GPS time, and UTC, which stays behind it by the leap seconds.

Source: IERS Bulletin C, all leap seconds of UTC since the beginning of GPS time.
"""

from collections.abc import Callable

import numpy as np

GPS_EPOCH_S = 315_964_800
"""Begin of GPS time in seconds since 1970."""
WEEK_S, DAY_S = 604_800, 86_400
LEAP_DATES = (
    "1981-07", "1982-07", "1983-07", "1985-07", "1988-01", "1990-01", "1991-01", "1992-07", "1993-07", "1994-07",
    "1996-01", "1997-07", "1999-01", "2006-01", "2009-01", "2012-07", "2015-07", "2017-01",
)  # fmt: skip
"""Months on whose first day UTC falls behind by a further second."""


def utc(gps: np.ndarray) -> np.ndarray:
    """Convert GPS time to UTC, both in seconds since 1970, shape (n,)."""
    dates = np.array(LEAP_DATES, "datetime64[s]").astype(float)
    behind = np.arange(1, len(dates) + 1)
    return gps - np.searchsorted(dates + behind, gps, "right")


def since_1980(time: float) -> float:
    """Return GPS time in seconds since its begin of UTC in seconds since 1970."""
    dates = np.array(LEAP_DATES, "datetime64[s]").astype(float)
    return time - GPS_EPOCH_S + float(np.searchsorted(dates, time, "right"))


SCALES: dict[str, Callable[[float], float]] = {
    "seconds of GPS time against seconds since 1970": since_1980,
    "seconds of the GPS week against seconds since 1970": lambda time: since_1980(time) % WEEK_S,
    "seconds of the GPS week against those of GPS time": lambda time: time % WEEK_S,
    "seconds of the day against seconds since 1970": lambda time: time % DAY_S,
}
"""Scales of stamps that receivers and loggers use, and the second of each in the first."""
