"""Conversion of units: multiply by a factor to SI, divide by it from SI.

The table has every unit of a file, a published table or a data sheet of this study. Standard gravity is the
conventional value 9.80665 m/s^2 (BIPM, SI brochure, 9th ed.), used to convert units, and as the gravity of a site
that is not given.
"""

from math import pi

STANDARD_GRAVITY = 9.80665

FACTORS: dict[str, float] = {
    "1": 1.0,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "min": 60.0,
    "100us": 1e-4,
    "ns": 1e-9,
    "100ns": 1e-7,
    "m": 1.0,
    "mm": 1e-3,
    "degC": 1.0,
    "rad": 1.0,
    "rad/s": 1.0,
    "m/s": 1.0,
    "m/s^2": 1.0,
    "ft/s^2": 0.3048,
    "cm/s^2": 1e-2,
    "mm/s^2": 1e-3,
    "mrad/s": 1e-3,
    "urad/s": 1e-6,
    "rad/s/sqrt(Hz)": 1.0,
    "rad/s^2/sqrt(Hz)": 1.0,
    "m/s^2/sqrt(Hz)": 1.0,
    "m/s^3/sqrt(Hz)": 1.0,
    "mg/sqrt(Hz)": 1e-3 * STANDARD_GRAVITY,
    "rad/s^2": 1.0,
    "m/s^3": 1.0,
    "1/s": 1.0,
    "(rad/s)^2": 1.0,
    "(m/s^2)^2": 1.0,
    "h": 3600.0,
    "d": 86400.0,
    "deg": pi / 180,
    "deg/s": pi / 180,
    "mdeg/s": 1e-3 * pi / 180,
    "deg/h": pi / 180 / 3600,
    "deg/min": pi / 180 / 60,
    "arcsec/s": pi / 180 / 3600,
    "rev/s": 2 * pi,
    "rev/min": 2 * pi / 60,
    "deg/sqrt(h)": pi / 180 / 60,
    "deg/h/sqrt(h)": pi / 180 / 3600 / 60,
    "g": STANDARD_GRAVITY,
    "mg": 1e-3 * STANDARD_GRAVITY,
    "ug": 1e-6 * STANDARD_GRAVITY,
    "mGal": 1e-5,
    "m/s/sqrt(h)": 1 / 60,
    "m/s/h/sqrt(h)": 1 / 3600 / 60,
    "%": 1e-2,
    "ppm": 1e-6,
}

HABITS = {
    "rad/s/sqrt(Hz)": "deg/sqrt(h)",
    "m/s^2/sqrt(Hz)": "m/s/sqrt(h)",
    "rad/s": "deg/h",
    "m/s^2": "ug",
    "rad/s/s/sqrt(Hz)": "deg/h/sqrt(h)",
    "m/s^2/s/sqrt(Hz)": "m/s/h/sqrt(h)",
}
"""Unit of data sheets of each SI unit."""


def to_si(value, unit: str):
    """Convert ``value`` (number or array) given in ``unit`` to SI."""
    return value * factor(unit)


def from_si(value, unit: str):
    """Convert ``value`` (number or array) given in SI to ``unit``."""
    return value / factor(unit)


def factor(unit: str) -> float:
    """Return the number of SI units per ``unit``; ValueError with the known ones if unknown."""
    if unit not in FACTORS:
        raise ValueError(f"unit: expected one of {', '.join(FACTORS)}; found {unit!r}")
    return FACTORS[unit]


def with_unit(number: str, unit: str) -> str:
    """Return the text of a number with its unit; alone where it has none."""
    return number if unit == "1" else f"{number} {unit}"


def habit(value: float, unit: str) -> str:
    """Return a value of a SI unit in the unit of data sheets, or nothing where there is none."""
    if unit not in HABITS:
        return ""
    return f"{from_si(value, HABITS[unit]):.4g} {HABITS[unit]}"
