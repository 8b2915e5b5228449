"""Screening of the fixes before a filter uses them: by themselves, without the device.

Left out are fixes from which the rest of the drive is out of reach, at the start or far away, as a receiver writes them
before it has a lock, fixes that repeat the place of the one before in motion, fixes that were interpolated between
others, and a vertical velocity that never changes. Velocities are compared with the displacements: over spans of some
seconds the displacement is the integral of the velocity. A unit, a sign or an order of columns that explains the
difference is refused with its name; the delay of velocities against the positions is estimated; velocities that
contradict them in another way are left out.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.ndimage import maximum_filter1d

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
HELD_SHARE, HELD = 0.01, 0.3
"""Step from fix to fix, over the largest one around it, up to which a place in motion is that of the one before, where
more than a share of them is."""
ON_LINE, INTERPOLATED = 0.05, 0.4
"""Distance of a fix from the middle of its neighbours, over the largest ones, up to which it is on their line, and
share of such fixes in motion from which on they are interpolated."""
SPAN_S, LONG_SPAN_S = 4.0, 40.0
"""Times over which velocities are compared with displacements [s]; the noise of heights needs the longer one too."""
FEWEST_SPANS = 8
"""Smallest number of spans in motion."""
NOISE_MULTIPLE = 8.0
"""Displacement of a span that a comparison needs, in standard deviations of a position."""
FITS, CONTRADICTS = 0.1, 0.2
"""Unexplained shares of the displacements up to which velocities fit, and from which on they contradict."""
UP_SIGMA, LATE_SIGMA = 6.0, 5.0
"""Significance of a vertical velocity of the opposite sign, and of a delay, in standard deviations."""
SIZE = 0.05
"""Difference of displacements from those by velocities in another unit up to which it is named, as a share."""
LATE_S = 0.05
"""Smallest delay of velocities against positions that is named [s]."""
UNITS = {
    "km/h": 1 / 3.6, "knots": 0.514444, "mph": 0.44704, "cm/s": 0.01, "mm/s": 0.001,
}  # fmt: skip
"""Units that a velocity may have instead of m/s, and what one of them is [m/s]."""


class _Explanation(NamedTuple):
    """Matrix by which the velocities give the displacements, north and east, and what it means."""

    mat: np.ndarray
    expected: str
    found: str


class ScreenedFixes(NamedTuple):
    """Fixes that a filter can use, the delay of their velocities [s], and what was left out or corrected."""

    fixes: pd.DataFrame
    delay_s: float
    corrections: tuple[Correction, ...]


def screen(fixes: pd.DataFrame, position_std: tuple[float, float, float], delay_s: float = 0.0) -> ScreenedFixes:
    """Return the fixes that a filter can use; a ValueError for a unit or an order of columns.

    Parameters
    ----------
    position_std
        Standard deviations of a position where the log gives none [m].
    delay_s
        Delay of the velocities against the positions, if it is known [s].
    """
    corrections = []
    for step in (
        _without_null_island, _without_unreachable, _without_repeats, _without_interpolated, _without_constant_down,
    ):  # fmt: skip
        fixes, found = step(fixes)
        corrections += found
    fixes, late, found = _with_fitting_velocities(fixes, position_std)
    if delay_s or not late:
        return ScreenedFixes(fixes, delay_s, (*corrections, *found))
    words = f"the velocities of the fixes are {abs(late):.2f} s {'late' if late > 0 else 'early'} against the positions"
    delay = Correction("delay of velocities", words, f"receiver: {{velocity_delay_s: {late:.3f}}}")
    return ScreenedFixes(fixes, late, (*corrections, *found, delay))


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
    first = f"{fixes.index[null][0]:.10g} s"
    found = f"{null.sum()} of {len(fixes)} fixes, the first at {first}, are at latitude 0, longitude 0"
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
    when = f"from {time[gone][0]:.10g} s to {time[gone][-1]:.10g} s"
    found = f"{gone.sum()} of {len(time)} fixes, {when}, lie up to {away[gone].max():.3g} m away from the others"
    return fixes[~gone], [Correction("fixes from elsewhere", found, "left out")]


def _without_repeats(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out fixes that repeat the place of the one before, digit by digit, in motion."""
    time, local = fixes.index.to_numpy(dtype=float), gnss.local(fixes, middle(fixes))[:, :3]
    speed = _speeds(fixes, local)
    columns = [name for name in (*PLACE, *VELOCITY) if name in fixes]
    same = (fixes[columns].diff() == 0).to_numpy()
    whole = same.all(axis=1)
    steps = np.hypot(*np.diff(local[:, :2], axis=0, prepend=local[:1, :2]).T)
    width = 2 * round(AROUND_S / np.median(np.diff(time))) + 1
    near = steps < HELD_SHARE * maximum_filter1d(steps, width)
    moved = np.diff(time, prepend=time[0]) * speed
    able = (speed > SLOWEST) & (moved > RESOLUTION_M)
    place = same[:, : len(PLACE)].all(axis=1) | (near & (near[able].mean() > HELD if able.any() else False))
    moving = place & able
    if not moving.any():
        return fixes, []
    gone = moving | whole
    own = 1 / np.median(np.diff(time[~gone])) if (~gone).sum() > 1 else 0.0
    rates = f"a receiver at {own:.3g} Hz in a log at {1 / np.median(np.diff(time)):.3g} Hz"
    how = "digit by digit, in motion" if place[moving].all() and same[moving].all() else "in motion"
    found = f"{gone.sum()} of {len(time)} fixes repeat the one before, {how}: {rates}"
    return fixes[~gone], [Correction("held fixes", found, "left out")]


def _without_interpolated(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out fixes on the line of their neighbours, where most are: those of a slower receiver, interpolated."""
    place = gnss.local(fixes, middle(fixes))[:, :3]
    bent = np.hypot(*(place[2:] - 2 * place[1:-1] + place[:-2])[:, :2].T)
    moving = _speeds(fixes, place)[1:-1] > SLOWEST
    if moving.sum() < FEWEST_SPANS:
        return fixes, []
    line = bent < ON_LINE * np.quantile(bent[moving], 0.98)
    own = np.flatnonzero(moving & ~line)
    if line[moving].mean() < INTERPOLATED or len(own) < FEWEST_SPANS or np.median(np.diff(own)) < 2:
        return fixes, []
    kept = np.r_[True, ~line, True]
    rates = tuple(1 / np.median(np.diff(one.index)) for one in (fixes[kept], fixes))
    found = (
        f"{np.sum(~kept)} of {len(fixes)} fixes lie on the line of their neighbours: a receiver at {rates[0]:.3g} Hz, "
        f"interpolated to {rates[1]:.3g} Hz"
    )
    return fixes[kept], [Correction("interpolated fixes", found, "left out")]


def _without_constant_down(fixes: pd.DataFrame) -> tuple[pd.DataFrame, list[Correction]]:
    """Leave out a vertical velocity that is the same throughout a drive, as where a receiver measures none."""
    name = VELOCITY[2]
    if name not in fixes or fixes[name].nunique() != 1 or len(fixes) < FEWEST_SPANS:
        return fixes, []
    if not (_speeds(fixes, gnss.local(fixes, middle(fixes))[:, :3]) > SLOWEST).any():
        return fixes, []
    found = f"the vertical velocity of all fixes is {fixes[name].iloc[0] + 0.0:g} m/s, as where it is not measured"
    return fixes.assign(**{name: np.nan}), [Correction("vertical velocity", found, "left out")]


def _with_fitting_velocities(
    fixes: pd.DataFrame, position_std: tuple[float, float, float]
) -> tuple[pd.DataFrame, float, list[Correction]]:
    """Compare velocities with displacements: refuse a unit or an order of columns, leave out what contradicts.

    The second value is the delay of the velocities against the positions, 0 where it is none of note [s].
    """
    if VELOCITY[0] not in fixes:
        return fixes, 0.0, []
    ellipsoid = middle(fixes)
    place, integral, change = _spans(fixes, ellipsoid)
    std = float(np.median(gnss.deviations(fixes, position_std, (1.0,) * 3)[:, 0]))
    length = np.maximum(*(np.hypot(one[:, 0], one[:, 1]) for one in (place, integral)))
    moving = length > max(NOISE_MULTIPLE * std, 0.5 * np.sqrt(np.mean(length**2))) if len(length) else length > 0
    if moving.sum() < FEWEST_SPANS:
        return fixes, 0.0, []
    shift, way = place[moving, :2], integral[moving, :2]

    def unexplained(mat: np.ndarray) -> float:
        return float(np.median(np.sum((shift - way @ mat.T) ** 2, axis=1)) / np.median(np.sum(shift**2, axis=1)))

    plain = unexplained(np.eye(2))
    if plain > CONTRADICTS:
        best = min(_explanations(ellipsoid), key=lambda one: unexplained(one.mat))
        size = _slope(way @ best.mat.T, shift)[0]
        if unexplained(best.mat) < min(FITS, plain / 3) and abs(size - 1) < SIZE:
            raise ValueError(f"fixes: expected {best.expected}; found {best.found}")
        found = f"the velocities of the fixes explain only {max(1 - plain, 0):.0%} of the displacements"
        names = [name for name in (*VELOCITY, *VELOCITY_STD) if name in fixes]
        left_out = Correction("velocities that contradict positions", found, "velocities left out")
        return fixes.drop(columns=names), 0.0, [left_out]
    _check_down(place[moving, 2], integral[moving, 2])
    _check_down(*(one[:, 2] for one in _spans(fixes, ellipsoid, LONG_SPAN_S)[:2]))
    late, error = _slope(change[:, :2], place[:, :2] - integral[:, :2])
    return fixes, round(late, 3) if abs(late) > max(LATE_S, LATE_SIGMA * error) else 0.0, []


def _slope(cause: np.ndarray, effect: np.ndarray) -> tuple[float, float]:
    """Return the factor by which a cause gives an effect, and its standard error by the scatter."""
    power = max(float(np.sum(cause**2)), 1e-12)
    slope = float(np.sum(effect * cause)) / power
    return slope, float(np.sqrt(np.sum((cause * (effect - slope * cause)) ** 2))) / power


def _check_down(shift: np.ndarray, way: np.ndarray) -> None:
    """Raise a ValueError where the vertical velocity has the opposite sign of the displacements."""
    slope, error = _slope(way, shift)
    if slope < -UP_SIGMA * error and -1.5 < slope < -0.5:
        raise ValueError("fixes: expected vel_d positive down; found a height that rises with it (change its sign)")


def _spans(
    fixes: pd.DataFrame, ellipsoid: Ellipsoid, span_s: float = SPAN_S
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return displacements, integrals and changes of the velocity over spans without a gap, shape (spans, 3) [m]."""
    known = fixes[np.isfinite(fixes[list(VELOCITY[:2])]).all(axis=1)]
    time, seen = known.index.to_numpy(dtype=float), gnss.local(known, ellipsoid)
    if len(time) < FEWEST_SPANS:
        return (np.empty((0, 3)),) * 3
    steps = np.diff(time)
    way = np.vstack([np.zeros(3), np.cumsum(0.5 * steps[:, None] * (seen[1:, 3:] + seen[:-1, 3:]), axis=0)])
    holes = np.append(0, np.cumsum(steps > 2.5 * np.median(steps)))
    begin = np.arange(len(time))[:: max(round(span_s / np.median(steps)), 1)]
    first, last = begin[:-1], begin[1:]
    whole = holes[first] == holes[last]
    return tuple(one[last[whole]] - one[first[whole]] for one in (seen[:, :3], way, seen[:, 3:]))


def _explanations(ellipsoid: Ellipsoid) -> list[_Explanation]:
    """Return what may be wrong with the columns: units of the velocities, and the order of columns."""
    order = np.array([[0.0, 1.0], [1.0, 0.0]])
    found = [
        _Explanation(size * np.eye(2), "vel_n, vel_e, vel_d in m/s", f"{1 / size:.3g} times that, as in {unit}")
        for unit, size in UNITS.items()
    ]
    degrees = min(np.degrees(abs(ellipsoid.latitude)), 1.5)
    radians = np.radians(1) * np.diag([1.0, np.cos(ellipsoid.latitude) / np.cos(degrees)])
    exchanged = np.array([[0.0, 1 / np.cos(ellipsoid.longitude)], [np.cos(ellipsoid.latitude), 0.0]])
    return [
        *found,
        _Explanation(radians, "latitude and longitude in degrees",
                     "displacements 57.3 times smaller than by the velocities, as in radians"),
        _Explanation(exchanged, "latitude and longitude in this order",
                     "displacements to the east where the velocities go north: the two are exchanged"),
        _Explanation(order, "vel_n and vel_e in this order",
                     "velocities to the east where the displacements go north: the two are exchanged"),
        _Explanation(-np.eye(2), "vel_n and vel_e of the vehicle", "velocities opposite to the displacements"),
        _Explanation(np.diag([1.0, -1.0]), "longitude and vel_e positive to the east",
                     "displacements to the west where the velocities go east: one of the two has the opposite sign"),
        _Explanation(np.diag([-1.0, 1.0]), "latitude and vel_n positive to the north",
                     "displacements to the south where the velocities go north: one of the two has the opposite sign"),
        _Explanation(0.6 * np.eye(2), "latitude and longitude in decimal degrees",
                     "displacements 0.6 times those by the velocities, as where minutes are written as decimals"),
    ]  # fmt: skip
