"""Units as headers write them (``rad s^-1``, ``deg/sec``, ``m/s²``, ``dps``), as units of :mod:`imugap.units`."""

import re
from collections import Counter

SPELLINGS = {
    "s": "s sec secs second seconds",
    "ms": "ms msec msecs millis millisecond milliseconds",
    "us": "us usec usecs micros microsecond microseconds",
    "ns": "ns nsec nsecs nanos nanosec nanosecond nanoseconds",
    "min": "min mins minute minutes",
    "h": "h hr hour hours",
    "d": "d day days",
    "rad": "rad rads radian radians",
    "mrad": "mrad",
    "urad": "urad",
    "arcsec": "arcsec arcsecs arcsecond arcseconds",
    "rev": "rev revs revolution revolutions",
    "deg": "deg degs degree degrees",
    "mdeg": "mdeg",
    "m": "m meter meters metre metres",
    "cm": "cm",
    "mm": "mm",
    "ft": "ft foot feet",
    "g": "g gs gn gee",
    "mg": "mg milligs",
    "ug": "ug",
    "degC": "c degc celsius degcelsius",
    "degF": "f degf fahrenheit degfahrenheit",
    "K": "k kelvin kelvins",
}
BASES = {spelling: base for base, spellings in SPELLINGS.items() for spelling in spellings.split()}
SHORT = {
    "dps": "deg/s", "d/s": "deg/s", "mdps": "mdeg/s", "rpm": "rev/min", "gal": "cm/s^2", "mgal": "mGal",
    "m gal": "mGal", "milli-g": "mg", "milli g": "mg", "mps2": "m/s^2",
    "mps 2": "m/s^2", "100ns": "100ns",
    "100 ns": "100ns",
}  # fmt: skip
"""Abbreviations of whole units."""
COUNTS = "counts"
"""Unit of what a converter gives: the size of a count is in the data sheet."""
COUNT_WORDS = ("lsb", "lsbs", "count", "counts", "raw", "digit", "digits", "adc", "code", "codes", "bit", "bits")
SIGNS = str.maketrans({"²": "^2", "³": "^3", "µ": "u", "μ": "u", "°": "deg", "⁻": "-", "¹": "1", "·": " ", "*": " "})
TIMES = ("s", "min", "h")
QUANTITIES = {
    "time": ("s", "ms", "us", "ns", "100ns", "min", "h", "d"),
    "gyro": (
        "rad/s", "deg/s", "mrad/s", "urad/s", "mdeg/s", "deg/h", "deg/min", "arcsec/s", "rev/s", "rev/min", "rad",
        "deg",
    ),
    "accel": ("m/s^2", "g", "mg", "ug", "cm/s^2", "mm/s^2", "mGal", "ft/s^2", "m/s"),
    "temperature": ("degC", "degF", "K"),
}  # fmt: skip
"""Units of each quantity; those without the last time in them are of increments over the sampling interval."""
INCREMENTS = ("rad", "deg", "m/s")
PREFIX = r"(?:(?:milli|micro|nano|kilo|centi|deci)[ -]?|[munkMcd])?"
FOREIGN = re.compile(rf"{PREFIX}(?:[Vv]|[Vv]olts?|Hz|hz|[Hh]ertz|N|[Nn]ewtons?|kgf|lbf|Pa|T|[Gg]auss|[Gg]al)|[mun]A|%")
"""Units of other quantities than those of a log."""
TEN = re.compile(r"(?:0?[.,]0*1|10+|1?[eE][-+]?\d+|10\^-?\d+)[ *·]*")
"""A power of ten before a unit; other numbers are of a range, such as 16g."""
QUOTIENT = re.compile(r".*[a-z°].*([/^²]|per).*", re.IGNORECASE)


def unit_of(text: str) -> str | None:
    """Return the unit that a text is, :data:`COUNTS`, or None.

    ``m s2`` and ``rad_s``, as names of columns have them, are quotients.
    """
    plain = text.strip().translate(SIGNS).lower()
    if plain in SHORT:
        return SHORT[plain]
    if plain in COUNT_WORDS:
        return COUNTS
    exponents: Counter[str] = Counter()
    sign, last = 1, None
    for token in re.findall(r"[a-z]+|\^?-?\d+|/", plain):
        if token in ("/", "per"):
            sign, last = -1, None
        elif token in BASES:
            last = BASES[token]
            exponents[last] += -1 if sign < 0 or (last in TIMES and len(exponents)) else 1
        elif last is not None and re.fullmatch(r"\^?-?[123]", token):
            size = int(token.lstrip("^-"))
            exponents[last] = size if exponents[last] > 0 and "-" not in token else -size
        else:
            return None
    return _written(exponents)


def is_foreign(text: str) -> bool:
    """Return whether a text is a unit of another quantity than those of a log, such as mV."""
    return FOREIGN.fullmatch(text.strip()) is not None


def looks_like_unit(text: str) -> bool:
    """Return whether a text is written as units are, known or not: a quotient, a foreign unit, a multiple of a unit."""
    plain = text.strip()
    scaled, prefixed = TEN.sub("", plain, count=1), re.sub(f"^{PREFIX}", "", plain)
    return (
        unit_of(plain) is not None
        or QUOTIENT.fullmatch(plain) is not None
        or is_foreign(scaled)
        or quantity_of(unit_of(scaled) or "") is not None
        or quantity_of(unit_of(prefixed) or "") in ("gyro", "accel")
    )


def quantity_of(unit: str) -> str | None:
    """Return the quantity of a unit: gyro, accel, temperature or time; None if it is of no log."""
    return next((quantity for quantity, units in QUANTITIES.items() if unit in units), None)


def _written(exponents: Counter[str]) -> str | None:
    """Return exponents of base units as a known unit, or None."""
    above = [base for base, exponent in exponents.items() if exponent == 1]
    below = [base if exponent == -1 else f"{base}^{-exponent}" for base, exponent in exponents.items() if exponent < 0]
    unit = "/".join([*above, *below])
    return unit if len(above) == 1 and quantity_of(unit) else None
