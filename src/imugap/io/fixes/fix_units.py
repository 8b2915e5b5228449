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
OFFSHORE = np.pi / 2, np.pi
"""Latitude and longitude [deg] up to which a place is at sea, off Africa; no angle in radians is larger."""
TENTHS_OF_MICRODEGREES = 1e5
"""Size from which latitudes are whole numbers of 1e-7 deg."""
HIGHEST_M = 1e4
"""Height above which whole numbers beside such latitudes are millimetres."""


def scale(column: str, name: str) -> tuple[float, str | None]:
    """Return the factor to degrees, metres or metres per second that the name of a column states, and its unit."""
    angle, length = column in ("latitude", "longitude"), column in ("height", "sd_n", "sd_e", "sd_d")
    known = ANGLES if angle else LENGTHS if length else SPEEDS
    for found in BRACKETS.findall(name):
        unit = KNOWN.get(found.strip().lower().replace(" ", ""))
        if unit in known:
            return known[unit], unit
    return 1.0, None


def of_places(latitude: np.ndarray, longitude: np.ndarray) -> str:
    """Return the unit of angles that name none: degrees, unless those would be at sea where radians are ashore."""
    known = np.isfinite(latitude) & np.isfinite(longitude) & ((latitude != 0) | (longitude != 0))
    if not known.any():
        return "deg"
    north, east = np.abs(latitude[known]).max(), np.abs(longitude[known]).max()
    if north > TENTHS_OF_MICRODEGREES and north <= 90e7 and east <= 360e7:
        return INTEGERS
    at_sea = north < OFFSHORE[0] and east <= OFFSHORE[1]
    elsewhere = np.degrees(north) > OFFSHORE[0] or np.degrees(east) > OFFSHORE[1]
    return "rad" if at_sea and elsewhere else "deg"


def said(units: Iterable[tuple[str, str]], source: str) -> list[str]:
    """Return sentences on conversions of columns from units, by what these were recognised."""
    return [f"{column} {unit} -> {_si(unit)} from the {source}" for column, unit in units if unit != _si(unit)]


def _si(unit: str) -> str:
    return "deg" if unit in ANGLES else "m" if unit in LENGTHS else "m/s"
