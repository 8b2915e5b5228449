"""Drift over outages: from a drive itself, by fixes that are withheld.

The filter runs once with all fixes. From its state at the begin of a window it then predicts without any, and the fix
at the end of the window says by how much the prediction errs. Windows of a length follow each other as the drive has
room for them, from one good fix to another: one that passes the global test of the filter with all fixes.

The error has the noise of the fix at the end in it, and so has what the filter states. Its normalised square is a
two-sided check of the filter: 1 on average, whatever the shape of the covariance.

Source: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section
5.4.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.filters.consistency import nees_band
from imugap.navigation.drive.drive_error_search import CONTROL, solve
from imugap.navigation.drive.vehicle import DriveInputs, DriveSolution, InitialState, navigate

LENGTHS_S = 10.0, 30.0, 60.0
"""Lengths of the windows [s]."""
SETTLING_S = 45.0
"""Time before the first window, in which the filter settles [s]."""
SHORTER = 0.1
"""Share by which a window may be shorter than its length, for a good fix at its end."""
FALSE_ALARM = 1e-6
"""Probability that the test of a consistent filter fails."""
LARGEST = 4.0
"""Mean normalised square of a drift up to which it is not named, however sure it is."""


class Outage(NamedTuple):
    """Window without fixes.

    Attributes
    ----------
    length_s
        Nominal length [s].
    begin, end
        Stamps of the fixes at both ends, as in their log [s].
    north_m, east_m
        Prediction less the fix at the end [m].
    drift_m, stated_m
        Horizontal distance of both, and its root mean square as the filter states it [m].
    square
        Normalised square over its two degrees of freedom.
    """

    length_s: float
    begin: float
    end: float
    north_m: float
    east_m: float
    drift_m: float
    stated_m: float
    square: float


@dataclass(frozen=True, eq=False)
class Outages:
    """Windows of a drive without fixes, a row each (:class:`Outage`)."""

    windows: pd.DataFrame

    @property
    def drifts(self) -> pd.DataFrame:
        """Drift by length: number of windows, median, 95th percentile and root mean square [m], and what is stated.

        ``ratio`` is the drift over the stated one; ``ratio_low`` and ``ratio_high`` hold that of 95 % of consistent
        filters.
        """
        rows = []
        for length, own in self.windows.groupby("length_s"):
            low, high = np.sqrt(np.array(nees_band(2, len(own))) / 2)
            rows.append({
                "length_s": length, "windows": len(own), "median_m": own["drift_m"].median(),
                "p95_m": own["drift_m"].quantile(0.95), "rms_m": np.sqrt((own["drift_m"] ** 2).mean()),
                "stated_rms_m": np.sqrt((own["stated_m"] ** 2).mean()), "ratio": np.sqrt(own["square"].mean()),
                "ratio_low": low, "ratio_high": high,
            })  # fmt: skip
        return pd.DataFrame(rows)

    @property
    def test(self) -> tuple[float, float]:
        """Mean normalised square of the length that is farthest beyond its limit, and that; NaN and inf without any."""
        found = [
            (float(own["square"].mean()), max(float(chdtri(2 * len(own), FALSE_ALARM)) / (2 * len(own)), LARGEST))
            for _, own in self.windows.groupby("length_s")
        ]
        return max(found, key=lambda one: one[0] / one[1], default=(float("nan"), float("inf")))


def outages_of(inputs: DriveInputs) -> Outages:
    """Return the windows without fixes of all lengths that a drive has room for."""
    one = solve(inputs)
    rows = [
        _predicted(inputs, one, length, begin, end)
        for length in LENGTHS_S
        for begin, end in _windows(one, length)
    ]  # fmt: skip
    return Outages(pd.DataFrame(rows, columns=Outage._fields))


def _windows(one: DriveSolution, length: float) -> list[tuple[int, int]]:
    """Return the numbers of the fixes at begin and end of the windows of a length, one after the other."""
    record, time = one.record, one.time.to_numpy()[one.fix_row]
    limit = chdtri(np.maximum(record.freedom, 1), CONTROL.false_alarm)
    good = np.flatnonzero((record.freedom > 0) & (record.statistic < limit) & np.isfinite(record.innovation[:, 0]))
    found, begin = [], one.time[0] + SETTLING_S
    while len(first := good[time[good] >= begin]):
        due = time[first[0]] + length
        last = good[(time[good] <= due + 1e-6) & (time[good] >= due - SHORTER * length)]
        if len(last):
            found.append((int(first[0]), int(last[-1])))
        begin = time[last[-1]] if len(last) else time[first[0]] + 1e-6
        if due > time[-1]:
            break
    return found


def _predicted(inputs: DriveInputs, one: DriveSolution, length: float, begin: int, end: int) -> Outage:
    """Return the window from one fix of a solution to another, by prediction."""
    row = one.fix_row[begin]
    start = InitialState(one.time[row], one.history.navigation[row], one.history.errors[row], one.covariances[begin])
    stamp, last = inputs.log.index.to_numpy(), one.time[one.fix_row[end]]
    low, high = np.searchsorted(stamp, [start.time, last])
    at = inputs.fixes.index.to_numpy() == one.fix_time[end]
    part = replace(inputs, log=inputs.log.iloc[max(low - 2, 0) : high + 2], fixes=inputs.fixes[at], quality=CONTROL)
    record = navigate(part, start).record
    (north, east), variance = record.innovation[0, :2], record.variance[0, :2]
    return Outage(
        length, one.fix_time[begin], one.fix_time[end], float(north), float(east), float(np.hypot(north, east)),
        float(np.sqrt(variance.sum())), float(np.mean(record.whitened[0, :2] ** 2)),
    )  # fmt: skip
