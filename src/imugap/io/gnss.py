"""Log of a GNSS receiver: fixes over time, checked once, at reading.

Index ``time`` [s], strictly increasing. Columns :data:`PLACE` (rad, rad, m above the ellipsoid), optionally
:data:`VELOCITY` [m/s], and standard deviations :data:`PLACE_STD` [m] and :data:`VELOCITY_STD` [m/s]. Optional
values may be NaN; a file has latitude and longitude in degrees (:mod:`imugap.io.fixes`).
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.kinematics.strapdown import VELOCITY, Ellipsoid
from imugap.log import TIME, LogError
from imugap.numerics.rotation import wrap

PLACE = ("latitude", "longitude", "height")
PLACE_STD = ("sd_n", "sd_e", "sd_d")
VELOCITY_STD = ("sd_vel_n", "sd_vel_e", "sd_vel_d")
COLUMNS = (*PLACE, *VELOCITY, *PLACE_STD, *VELOCITY_STD)
COMPONENTS = ("north", "east", "down", *VELOCITY)
"""Measured components of a fix."""
FASTEST = 1e4
HIGHEST = 1e6
FASTEST_HZ = 1e3
"""Rate of fixes that no receiver exceeds [Hz]."""
SENSE = {
    "latitude": ("less than pi/2 rad (90 deg) either way", lambda values: np.abs(values) < np.pi / 2),
    "longitude": ("at most 2 pi rad (360 deg) either way", lambda values: np.abs(values) <= 2 * np.pi),
    "height": (f"at most {HIGHEST:g} m either way", lambda values: np.abs(values) <= HIGHEST),
}
"""Valid range of each component of the position, in words, and as a mask of valid values."""


def check(
    fixes: pd.DataFrame, source: str | Path = "gnss", place: Callable[[int], str] = "row {}".format
) -> pd.DataFrame:
    """Return ``fixes`` with their columns in order if they are valid; else raise a LogError.

    ``place`` converts the number of a row to its location in ``source``.
    """
    for group, needed in ((PLACE, True), (VELOCITY, False), (PLACE_STD, False), (VELOCITY_STD, False)):
        held = [name for name in group if name in fixes.columns]
        if len(held) < len(group) and (held or needed):
            expected = f"all of {', '.join(group)}{'' if needed else ' or none'}"
            raise LogError(source, "columns", expected, ", ".join(held) or "none of them")
    fixes = fixes[[name for name in COLUMNS if name in fixes.columns]]
    if len(fixes) < 2:
        raise LogError(source, "rows", "at least 2 fixes", str(len(fixes)))
    backward = np.flatnonzero(~(np.diff(fixes.index.to_numpy()) > 0))
    if len(backward):
        row = int(backward[0]) + 1
        raise LogError(source, f"{place(row)}, column {TIME}", "a time that increases", str(fixes.index[row]))
    rate = 1 / float(np.median(np.diff(fixes.index.to_numpy())))
    if rate > FASTEST_HZ:
        raise LogError(source, f"column {TIME}", f"stamps in seconds, at most {FASTEST_HZ:g} Hz", f"{rate:.3g} Hz")
    for name in fixes.columns:
        values, (sense, rule) = fixes[name].to_numpy(), SENSE.get(name, _of_group(name))
        wrong = np.flatnonzero(~rule(values))
        if len(wrong):
            found = f"{values[wrong[0]]:g} ({len(wrong)} such row{'s' if len(wrong) > 1 else ''})"
            raise LogError(source, f"{place(int(wrong[0]))}, column {name}", sense, found)
    return fixes


def _of_group(name: str) -> tuple[str, Callable[[np.ndarray], np.ndarray]]:
    """Return the valid range of a column that may be NaN, in words, and as a mask of valid values."""
    if name.startswith("sd_"):
        return "a standard deviation > 0", lambda values: np.isnan(values) | ((values > 0) & np.isfinite(values))
    return f"at most {FASTEST:g} m/s either way", lambda values: np.isnan(values) | (np.abs(values) <= FASTEST)


def origin(fixes: pd.DataFrame) -> Ellipsoid:
    """Return the ellipsoid with its origin at the first fix."""
    return Ellipsoid(*map(float, fixes[list(PLACE)].iloc[0]))


def local(fixes: pd.DataFrame, ellipsoid: Ellipsoid) -> np.ndarray:
    """Return the :data:`COMPONENTS` of the fixes relative to ``ellipsoid``, shape (n, 6); NaN if missing."""
    _, _, metres_north, metres_east = ellipsoid.origin
    place = fixes[list(PLACE)].to_numpy() - [ellipsoid.latitude, ellipsoid.longitude, ellipsoid.height]
    place[:, 1] = wrap(place[:, 1])
    velocity = [fixes[name].to_numpy() if name in fixes else np.full(len(fixes), np.nan) for name in VELOCITY]
    return np.column_stack([place * [metres_north, metres_east, -1.0], *velocity])


def deviations(
    fixes: pd.DataFrame, place_std: tuple[float, float, float], velocity_std: tuple[float, float, float]
) -> np.ndarray:
    """Return the standard deviations of :data:`COMPONENTS`, shape (n, 6): of the log, else the given ones."""
    names, usual = (*PLACE_STD, *VELOCITY_STD), (*place_std, *velocity_std)
    return np.column_stack([
        fixes[name].fillna(std).to_numpy() if name in fixes else np.full(len(fixes), std)
        for name, std in zip(names, usual, strict=True)
    ])  # fmt: skip


def from_local(time: np.ndarray, measured: np.ndarray, std: np.ndarray, ellipsoid: Ellipsoid) -> pd.DataFrame:
    """Make a log of fixes from measured :data:`COMPONENTS` and their standard deviations, shape (n, 6)."""
    table = pd.DataFrame(index=pd.Index(time, name=TIME), columns=list(COLUMNS), dtype=float)
    table[list(PLACE)] = ellipsoid.geodetic(measured[:, :3])
    table[list(VELOCITY)] = measured[:, 3:]
    table[[*PLACE_STD, *VELOCITY_STD]] = std
    return check(table)
