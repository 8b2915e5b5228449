"""Units of columns of fixes: by the header, else by the places that they would give."""

import re
from collections.abc import Iterable

import numpy as np

INTEGERS = "1e-7 deg"
ANGLES = {"deg": 1.0, "rad": np.degrees(1.0), INTEGERS: 1e-7}
"""Degrees per unit."""
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048}
"""Metres per unit."""
SPEEDS = {
    "m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 1e-2, "mm/s": 1e-3, "kn": 1852 / 3600, "mph": 0.44704, "ft/s": 0.3048,
}  # fmt: skip
"""Metres per second per unit."""
SPELLINGS = {
    "deg": "deg degree degrees ° degn dege °n °e", "rad": "rad radian radians",
    INTEGERS: "dege7 deg*1e7 1e-7deg 1e7deg",
    "m": "m meter meters metre metres", "mm": "mm", "cm": "cm", "km": "km", "ft": "ft foot feet",
    "m/s": "m/s ms^-1 m*s^-1 ms-1 mps", "km/h": "km/h kmh kph kmph", "cm/s": "cm/s cmps", "mm/s": "mm/s mmps",
    "kn": "kn kt kts knot knots", "mph": "mph mi/h", "ft/s": "ft/s fps",
}  # fmt: skip
KNOWN = {spelling: unit for unit, spellings in SPELLINGS.items() for spelling in spellings.split()}
BRACKETS = re.compile(r"[\[(]([^\[\]()]*)[\])]")
FACTORS = ANGLES | LENGTHS | SPEEDS
EARTH_M = 6.37e6
SPANS_S = 5.0, 20.0
"""Times over which a speed is taken [s]: that of a motion is nearly the same over both, that by noise is not."""
MOVING = 0.5
"""Ratio of the speed over the longer time to that over the shorter from which it is a motion."""
SLOWEST, FASTEST = 1.0, 350.0
"""Mean speeds below which no receiver that is logged moves, and above which none does [m/s]."""
ALIKE = 4.0
"""Ratio of speeds within which they are one."""
OFFSHORE = np.pi / 2, np.pi
"""Latitude and longitude [deg] up to which a place is at sea, off Africa; no angle in radians is larger."""
TENTHS_OF_MICRODEGREES = 1e5
"""Size from which latitudes are whole numbers of 1e-7 deg."""
HIGHEST_M = 1e4
"""Height above which whole numbers beside such latitudes are millimetres."""


def scale(column: str, name: str) -> tuple[float, str | None]:
    """Return the factor to degrees, metres or metres per second that the name of a column states, and its unit."""
    angle = column in ("latitude", "longitude", "course")
    length = column in ("height", "sd_n", "sd_e", "sd_d", "radius", "sd_height")
    known = ANGLES if angle else LENGTHS if length else SPEEDS
    for found in BRACKETS.findall(name):
        unit = KNOWN.get(found.strip().lower().replace(" ", ""))
        if unit in known:
            return known[unit], unit
    return 1.0, None


def of_places(time: np.ndarray, latitude: np.ndarray, longitude: np.ndarray, speed: np.ndarray | None = None) -> str:
    """Return the unit of angles that name none; ValueError where degrees and radians are possible.

    Angles that radians cannot be are degrees. Those near zero would be at sea in degrees: the stated speed decides, or
    a speed that is too high for a receiver on a vehicle in one, or too low for one that moves in the other.

    Parameters
    ----------
    time, latitude, longitude
        Stamps [s] and places of the fixes, shape (n,) each.
    speed
        Stated horizontal speed [m/s], shape (n,), or None.
    """
    known = np.isfinite(latitude) & np.isfinite(longitude) & ((latitude != 0) | (longitude != 0))
    if not known.any():
        return "deg"
    north, east = np.abs(latitude[known]).max(), np.abs(longitude[known]).max()
    if north > TENTHS_OF_MICRODEGREES and north <= 90e7 and east <= 360e7:
        return INTEGERS
    at_sea = north < OFFSHORE[0] and east <= OFFSHORE[1]
    elsewhere = np.degrees(north) > OFFSHORE[0] or np.degrees(east) > OFFSHORE[1]
    if not (at_sea and elsewhere):
        return "deg"
    short, long = (_speed(time[known], latitude[known], longitude[known], span) for span in SPANS_S)
    stated = None if speed is None or not np.isfinite(speed).any() else float(np.nanmean(speed))
    return _by_speed(short, long > MOVING * short, stated)


def _by_speed(implied: float, moves: bool, stated: float | None) -> str:
    """Return the unit of angles by the speed that places in degrees imply, and the stated one [m/s].

    ``moves``: whether that is a motion, and not the noise of the receiver.
    """
    speeds = {"deg": implied, "rad": np.degrees(implied)}
    if stated is not None and stated > SLOWEST:
        near = [unit for unit, one in speeds.items() if 1 / ALIKE < one / stated < ALIKE]
        if len(near) == 1:
            return near[0]
    if speeds["rad"] > FASTEST:
        return "deg"
    if moves and speeds["deg"] < SLOWEST < speeds["rad"]:
        return "rad"
    readings = " or ".join(f"{one:.3g} m/s in {unit}" for unit, one in speeds.items())
    expected = "the unit of places off Africa in degrees, elsewhere in radians (--fixes-angles deg or rad decides)"
    raise ValueError(f"{expected}; found {readings}")


def _speed(time: np.ndarray, latitude: np.ndarray, longitude: np.ndarray, span_s: float) -> float:
    """Return the mean speed [m/s] of places in degrees, over spans of a time [s]."""
    rows = np.searchsorted(time, np.arange(time[0], time[-1], span_s))
    rows = np.unique(np.r_[rows, len(time) - 1].clip(0, len(time) - 1))
    metres = np.radians([latitude[rows], longitude[rows]]) * EARTH_M
    path = np.hypot(*np.diff(metres, axis=1)).sum()
    return float(path / (time[-1] - time[0])) if time[-1] > time[0] else 0.0


def said(units: Iterable[tuple[str, str]], source: str) -> list[str]:
    """Return sentences on conversions of columns from units, by what these were recognised."""
    return [f"{column} {unit} -> {_si(unit)} from the {source}" for column, unit in units if unit != _si(unit)]


def _si(unit: str) -> str:
    return "deg" if unit in ANGLES else "m" if unit in LENGTHS else "m/s"
