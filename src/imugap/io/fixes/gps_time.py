"""Time scales of receivers, in seconds since 1970: GPS time, and UTC, which stays behind it by the leap seconds.

Source: IERS Bulletin C, all leap seconds of UTC since the beginning of GPS time.
"""

import numpy as np

GPS_EPOCH_S = 315_964_800
"""Begin of GPS time in seconds since 1970."""
WEEK_S = 604_800
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
