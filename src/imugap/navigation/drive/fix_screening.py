"""Screening of the fixes before a filter uses them: by themselves, without the device.

Left out are fixes from which the rest of the drive is out of reach, at the start or far away, as a receiver writes them
before it has a lock, and fixes that repeat the place of the one before, digit by digit, in motion. Velocities are
compared with the displacements: over spans of some seconds the displacement is the integral of the velocity. A unit or
an order of columns that explains the difference is refused with its name; velocities that contradict the positions in
another way are left out.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd

from imugap.io import gnss
from imugap.io.gnss import PLACE, VELOCITY_STD
from imugap.kinematics.strapdown import VELOCITY, Ellipsoid
from imugap.navigation.drive.correction import Correction

ORIGIN_FIXES = 5
"""Number of fixes whose median is the origin."""
NEAR_M = 50.0
"""Distance from fix to fix that needs no motion [m]."""
FAR_M = 1000.0
"""Distance above which fixes in the middle of a drive are left out, and not only tested by the filter [m]."""
FASTER = 3.0
"""Largest speed, as a multiple of the usual one."""
SLOWEST = 0.5
"""Smallest speed of a vehicle in motion [m/s]."""
RESOLUTION_M = 0.05
"""Displacement that no receiver rounds to zero [m]."""
AROUND_S = 2.0
"""Time before and after a fix from which its speed is taken where it has no velocity [s]."""
SPAN_S = 4.0
"""Time over which velocities are compared with displacements [s]."""
FEWEST_SPANS = 8
"""Smallest number of spans in motion."""
NOISE_MULTIPLE = 8.0
"""Displacement of a span that a comparison needs, in standard deviations of a position."""
FITS, CONTRADICTS = 0.1, 0.2
"""Unexplained shares of the displacements up to which velocities fit, and from which on they contradict."""
UP_SIGMA = 6.0
"""Significance of a vertical velocity of the opposite sign, in standard deviations."""
UNITS = {
    "km/h": 1 / 3.6, "knots": 0.514444, "mph": 0.44704, "cm/s": 0.01, "mm/s": 0.001,
}  # fmt: skip
"""Units that a velocity may have instead of m/s, and what one of them is [m/s]."""


class _Explanation(NamedTuple):
    """Matrix by which the velocities give the displacements, north and east, and what it means."""

    mat: np.ndarray
    expected: str
    found: str


def screen(
    fixes: pd.DataFrame, position_std: tuple[float, float, float]
) -> tuple[pd.DataFrame, tuple[Correction, ...]]:
    """Return the fixes that a filter can use, and what was left out; a ValueError for a unit or an order of columns.

    ``position_std`` are standard deviations of a position where the log gives none [m].
    """
    corrections = []
    for step in (_without_null_island, _without_unreachable, _without_repeats):
        fixes, found = step(fixes)
        corrections += found
    fixes, found = _with_fitting_velocities(fixes, position_std)
    return fixes, (*corrections, *found)


def middle(fixes: pd.DataFrame) -> Ellipsoid:
    """Return the ellipsoid with its origin at the median of the fixes."""
    turned = np.unwrap(fixes["longitude"].to_numpy())
    return Ellipsoid(float(fixes["latitude"].median()), float(np.median(turned)), float(fixes["height"].median()))


def first_place(fixes: pd.DataFrame) -> Ellipsoid:
    """Return the ellipsoid with its origin at the median of the first :data:`ORIGIN_FIXES` fixes."""
    return middle(fixes.iloc[:ORIGIN_FIXES])


def _without_null_island(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out fixes at latitude and longitude zero where others are elsewhere."""
    null = ((fixes["latitude"] == 0) & (fixes["longitude"] == 0)).to_numpy()
    if not null.any() or null.sum() > len(fixes) - 2:
        return fixes, []
    found = (
        f"{null.sum()} of {len(fixes)} fixes, the first at {fixes.index[null][0]:g} s, are at latitude 0, longitude 0"
    )
    return fixes[~null], [Correction("fixes before lock", found, "left out")]


def _speeds(fixes: pd.DataFrame, place: np.ndarray) -> np.ndarray:
    """Return the horizontal speed at each fix [m/s], by its velocity, or by the displacement around it."""
    if VELOCITY[0] in fixes:
        speed = np.hypot(fixes[VELOCITY[0]].to_numpy(), fixes[VELOCITY[1]].to_numpy())
        if np.isfinite(speed).mean() > 0.5:
            return np.nan_to_num(speed)
    time = fixes.index.to_numpy(dtype=float)
    before = np.searchsorted(time, time - AROUND_S)
    after = np.minimum(np.searchsorted(time, time + AROUND_S), len(time) - 1)
    return np.hypot(*(place[after] - place[before])[:, :2].T) / np.maximum(time[after] - time[before], 1e-3)


def _without_unreachable(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out fixes from which the rest of the drive is out of reach: those at the start, and those far away."""
    place, time = gnss.local(fixes, middle(fixes))[:, :3], fixes.index.to_numpy(dtype=float)
    steps = np.hypot(*np.diff(place, axis=0)[:, :2].T) / np.diff(time)
    usual = max(np.quantile(steps, 0.9), np.quantile(_speeds(fixes, place), 0.98), 10.0)

    def reachable(one: int, other: int) -> bool:
        away = np.hypot(*(place[one] - place[other])[:2])
        return bool(away < NEAR_M + FASTER * usual * abs(time[one] - time[other]))

    jumps = np.flatnonzero([not reachable(k, k + 1) for k in range(len(time) - 1)]) + 1
    bounds = [0, *jumps, len(time)]
    parts = list(pairwise(bounds))
    main = int(np.argmax([last - first for first, last in parts]))
    kept, first, last = np.zeros(len(time), bool), *parts[main]
    kept[first:last] = True
    for low, high in reversed(parts[:main]):
        if reachable(high - 1, first):
            kept[low:high], first = True, low
    for low, high in parts[main + 1 :]:
        if reachable(low, last - 1):
            kept[low:high], last = True, high
    away = np.zeros(len(time))
    inside = np.flatnonzero(kept)
    for k in np.flatnonzero(~kept):
        nearest = inside[np.argmin(np.abs(time[inside] - time[k]))]
        away[k] = np.hypot(*(place[k] - place[nearest])[:2])
    gone = ~kept & ((np.arange(len(time)) < inside[0]) | (away > FAR_M))
    if not gone.any():
        return fixes, []
    when = f"from {time[gone][0]:g} s to {time[gone][-1]:g} s"
    found = f"{gone.sum()} of {len(time)} fixes, {when}, lie up to {away[gone].max():.3g} m away from the others"
    return fixes[~gone], [Correction("fixes from elsewhere", found, "left out")]


def _without_repeats(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out fixes that repeat the place of the one before, digit by digit, in motion."""
    time, speed = fixes.index.to_numpy(dtype=float), _speeds(fixes, gnss.local(fixes, middle(fixes))[:, :3])
    columns = [name for name in (*PLACE, *VELOCITY) if name in fixes]
    same = (fixes[columns].diff() == 0).to_numpy()
    place, whole = same[:, : len(PLACE)].all(axis=1), same.all(axis=1)
    moved = np.diff(time, prepend=time[0]) * speed
    moving = place & (speed > SLOWEST) & (moved > RESOLUTION_M)
    if not moving.any():
        return fixes, []
    gone = moving | whole
    own = 1 / np.median(np.diff(time[~gone])) if (~gone).sum() > 1 else 0.0
    rates = f"a receiver at {own:.3g} Hz in a log at {1 / np.median(np.diff(time)):.3g} Hz"
    found = f"{gone.sum()} of {len(time)} fixes repeat the one before, digit by digit, in motion: {rates}"
    return fixes[~gone], [Correction("held fixes", found, "left out")]


def _with_fitting_velocities(
    fixes: pd.DataFrame, position_std: tuple[float, float, float]
) -> tuple[pd.DataFrame, list[Correction]]:
    """Compare velocities with displacements: refuse a unit or an order of columns, leave out what contradicts."""
    if VELOCITY[0] not in fixes:
        return fixes, []
    ellipsoid = middle(fixes)
    place, integral = _spans(fixes, ellipsoid)
    std = float(np.median(gnss.deviations(fixes, position_std, (1.0,) * 3)[:, 0]))
    length = np.maximum(*(np.hypot(one[:, 0], one[:, 1]) for one in (place, integral)))
    moving = length > max(NOISE_MULTIPLE * std, 0.5 * np.sqrt(np.mean(length**2))) if len(length) else length > 0
    if moving.sum() < FEWEST_SPANS:
        return fixes, []
    shift, way = place[moving, :2], integral[moving, :2]

    def unexplained(mat: np.ndarray) -> float:
        return float(np.median(np.sum((shift - way @ mat.T) ** 2, axis=1)) / np.median(np.sum(shift**2, axis=1)))

    plain = unexplained(np.eye(2))
    if plain > CONTRADICTS:
        best = min(_explanations(ellipsoid), key=lambda one: unexplained(one.mat))
        if unexplained(best.mat) < min(FITS, plain / 3):
            raise ValueError(f"fixes: expected {best.expected}; found {best.found}")
        found = f"the velocities of the fixes explain only {max(1 - plain, 0):.0%} of the displacements"
        names = [name for name in (*VELOCITY, *VELOCITY_STD) if name in fixes]
        return fixes.drop(columns=names), [
            Correction("velocities that contradict positions", found, "velocities left out")
        ]
    _check_down(place[moving, 2], integral[moving, 2])
    return fixes, []


def _check_down(shift: np.ndarray, way: np.ndarray) -> None:
    """Raise a ValueError where the vertical velocity has the opposite sign of the displacements."""
    slope = np.sum(shift * way) / max(np.sum(way**2), 1e-12)
    error = np.sqrt(np.sum((way * (shift - slope * way)) ** 2)) / max(np.sum(way**2), 1e-12)
    if slope < -UP_SIGMA * error and -1.5 < slope < -0.5:
        raise ValueError("fixes: expected vel_d positive down; found a height that rises with it (change its sign)")


def _spans(fixes: pd.DataFrame, ellipsoid: Ellipsoid) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements, and integrals of the velocity, over spans without a gap, shape (spans, 3) [m]."""
    known = fixes[np.isfinite(fixes[list(VELOCITY)]).all(axis=1)]
    time, seen = known.index.to_numpy(dtype=float), gnss.local(known, ellipsoid)
    if len(time) < FEWEST_SPANS:
        return np.empty((0, 3)), np.empty((0, 3))
    steps = np.diff(time)
    way = np.vstack([np.zeros(3), np.cumsum(0.5 * steps[:, None] * (seen[1:, 3:] + seen[:-1, 3:]), axis=0)])
    holes = np.append(0, np.cumsum(steps > 2.5 * np.median(steps)))
    begin = np.arange(len(time))[:: max(round(SPAN_S / np.median(steps)), 1)]
    first, last = begin[:-1], begin[1:]
    whole = holes[first] == holes[last]
    return tuple(one[last[whole]] - one[first[whole]] for one in (seen[:, :3], way))


def _explanations(ellipsoid: Ellipsoid) -> list[_Explanation]:
    """Return what may be wrong with the columns: units of the velocities, and the order of columns."""
    order = np.array([[0.0, 1.0], [1.0, 0.0]])
    found = [
        _Explanation(size * np.eye(2), "vel_n, vel_e, vel_d in m/s", f"{1 / size:.3g} times that, as in {unit}")
        for unit, size in UNITS.items()
    ]
    exchanged = np.array([[0.0, 1 / np.cos(ellipsoid.longitude)], [np.cos(ellipsoid.latitude), 0.0]])
    return [
        *found,
        _Explanation(np.radians(1) * np.eye(2), "latitude and longitude in degrees",
                     "displacements 57.3 times smaller than by the velocities, as in radians"),
        _Explanation(exchanged, "latitude and longitude in this order",
                     "displacements to the east where the velocities go north: the two are exchanged"),
        _Explanation(order, "vel_n and vel_e in this order",
                     "velocities to the east where the displacements go north: the two are exchanged"),
        _Explanation(-np.eye(2), "vel_n and vel_e of the vehicle", "velocities opposite to the displacements"),
    ]  # fmt: skip
