"""The log of a GNSS receiver: fixes over time, checked once, at reading.

Index ``time`` [s], strictly increasing. Columns :data:`PLACE` (rad, rad, m above the ellipsoid), optionally
:data:`VELOCITY` [m/s], and standard deviations :data:`PLACE_STD` [m] and :data:`VELOCITY_STD` [m/s]. What is optional
may be NaN where the receiver does not tell; a file has latitude and longitude in degrees (:mod:`imugap.readers`).
"""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap.log import TIME, LogError
from imugap.strapdown import VELOCITY, Ellipsoid

PLACE = ("latitude", "longitude", "height")
PLACE_STD = ("sd_n", "sd_e", "sd_d")
VELOCITY_STD = ("sd_vel_n", "sd_vel_e", "sd_vel_d")
COLUMNS = (*PLACE, *VELOCITY, *PLACE_STD, *VELOCITY_STD)
COMPONENTS = ("north", "east", "down", *VELOCITY)
"""What a fix measures."""


def check(fixes: pd.DataFrame, source: str | Path = "gnss") -> pd.DataFrame:
    """Return ``fixes`` in the order of the columns if they keep the contract; else raise a LogError."""
    for name in PLACE:
        if name not in fixes.columns:
            raise LogError(source, "columns", f"all of {', '.join(PLACE)}", f"no {name}")
    for group in (VELOCITY, PLACE_STD, VELOCITY_STD):
        held = [name for name in group if name in fixes.columns]
        if held and len(held) < len(group):
            raise LogError(source, "columns", f"all of {', '.join(group)} or none", ", ".join(held))
    fixes = fixes[[name for name in COLUMNS if name in fixes.columns]]
    if len(fixes) < 2:
        raise LogError(source, "rows", "at least 2 fixes", str(len(fixes)))
    time = fixes.index.to_numpy()
    bad = np.flatnonzero(~(np.diff(time) > 0))
    if not np.isfinite(time).all() or len(bad):
        row = int(bad[0]) + 1 if len(bad) else int(np.argmin(np.isfinite(time)))
        raise LogError(source, f"row {row}, column {TIME}", "a time that increases", str(time[row]))
    for name in fixes.columns:
        _require_sense(fixes[name].to_numpy(), name, source)
    return fixes


def _require_sense(values: np.ndarray, name: str, source: str | Path) -> None:
    """Raise where a column holds what its quantity cannot be."""
    limit = {"latitude": np.pi / 2, "longitude": 2 * np.pi, "height": 1e5}.get(name, 1e6)
    expected = {"latitude": "less than 90 deg either way", "longitude": "at most 360 deg either way"}
    wrong = np.abs(values) > limit if name in PLACE else np.abs(values) > 1e6
    if name in PLACE:
        wrong |= ~np.isfinite(values)
    elif name.startswith("sd_"):
        wrong |= values <= 0
    if name == "latitude":
        wrong |= np.abs(values) >= limit
    if wrong.any():
        row = int(np.argmax(wrong))
        found = np.degrees(values[row]) if name in ("latitude", "longitude") else values[row]
        sense = expected.get(name, "a standard deviation > 0" if name.startswith("sd_") else "a finite number")
        raise LogError(source, f"row {row}, column {name}", sense, f"{found:g} ({int(wrong.sum())} such rows)")


def origin(fixes: pd.DataFrame) -> Ellipsoid:
    """Return the ellipsoid with its origin at the first fix."""
    return Ellipsoid(*map(float, fixes[list(PLACE)].iloc[0]))


def local(fixes: pd.DataFrame, ellipsoid: Ellipsoid) -> np.ndarray:
    """Return what the fixes measure, :data:`COMPONENTS`, from the origin of ``ellipsoid``, shape (n, 6); NaN: not."""
    _, _, metres_north, metres_east = ellipsoid.origin
    place = fixes[list(PLACE)].to_numpy() - [ellipsoid.latitude, ellipsoid.longitude, ellipsoid.height]
    place[:, 1] = np.remainder(place[:, 1] + np.pi, 2 * np.pi) - np.pi
    velocity = [fixes[name].to_numpy() if name in fixes else np.full(len(fixes), np.nan) for name in VELOCITY]
    return np.column_stack([place * [metres_north, metres_east, -1.0], *velocity])


def deviations(
    fixes: pd.DataFrame, place_std: tuple[float, float, float], velocity_std: tuple[float, float, float]
) -> np.ndarray:
    """Return the standard deviations of :data:`COMPONENTS`, shape (n, 6): those of the log, else the given ones."""
    names, usual = (*PLACE_STD, *VELOCITY_STD), (*place_std, *velocity_std)
    return np.column_stack([
        fixes[name].fillna(std).to_numpy() if name in fixes else np.full(len(fixes), std)
        for name, std in zip(names, usual, strict=True)
    ])  # fmt: skip


def from_local(time: np.ndarray, measured: np.ndarray, std: np.ndarray, ellipsoid: Ellipsoid) -> pd.DataFrame:
    """Make a log of fixes from what they measure, :data:`COMPONENTS`, and its standard deviations, shape (n, 6)."""
    table = pd.DataFrame(index=pd.Index(time, name=TIME), columns=list(COLUMNS), dtype=float)
    table[list(PLACE)] = ellipsoid.geodetic(measured[:, :3])
    table[list(VELOCITY)] = measured[:, 3:]
    table[[*PLACE_STD, *VELOCITY_STD]] = std
    return check(table)
