"""Times as texts: dates with a time of day, times of day or of the hour alone, lengths of time with their unit.

A date that begins with the year, or has the name of the month, counts from 1970. Of another the order of day and month
is not known: its time of day is read, as of a text without a date, and a step back at midnight is one of the clock.
"""

import re

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
CLOCK = (
    r"^(?:(?:(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})"
    rf"|(?P<later_day>\d{{1,2}})[- ](?P<name>(?i:{'|'.join(MONTHS)}))[a-z]*[- ](?P<later_year>\d{{4}})"
    r"|\d{1,2}[-/.]\d{1,2}[-/.](?:\d{4}|\d\d))(?:T|,? +|_))?"
    r"(?P<hour>\d{1,2})[:.-](?P<minute>[0-5]?\d)[:.-](?P<second>[0-5]?\d)(?:[.,:_](?P<rest>\d{1,9})\d*)?"
    r" *(?P<half>[AaPp][Mm])? *(?:Z|UTC|(?P<sign>[+-])(?P<zone_hours>\d\d):?(?P<zone_minutes>\d\d))?$"
)
"""Date and time of day; milliseconds may stand behind a colon."""
OF_HOUR = r"^(?P<minute>\d{1,2}):(?P<second>[0-5]\d)[.,](?P<rest>\d{1,9})\d*$"
"""Minutes and seconds with a fraction, as spreadsheets show times."""
LENGTH = r"^(?P<number>[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?) (?P<unit>ms|s|sec|min|hr)$"
"""Length of time, as tables of MATLAB have it."""
NANOSECONDS = {"ms": 1e6, "s": 1e9, "sec": 1e9, "min": 60e9, "hr": 3600e9}
SECOND, DAY = 10**9, 86400 * 10**9


def is_time(cell: str) -> bool:
    """Return whether a text is a time."""
    return any(re.match(one, cell) for one in (CLOCK, OF_HOUR, LENGTH))


def nanoseconds(cells: pa.Array) -> np.ndarray:
    """Return times as texts in nanoseconds, shape (n,): since 1970, since midnight, since the hour, or from zero.

    Raises
    ------
    pyarrow.ArrowInvalid
        Where a text is no time of the kind of the first.
    """
    first = next((one for one in cells.to_pylist() if one is not None), "")
    form = next((one for one in (LENGTH, OF_HOUR) if re.match(one, first)), CLOCK)
    parts = pc.extract_regex(cells, form)
    if parts.null_count:
        at = int(np.flatnonzero(parts.is_null().to_numpy(zero_copy_only=False))[0])
        raise pa.ArrowInvalid(f"{cells[at].as_py()!r} is no time")
    if form == OF_HOUR:
        minute, second = (_whole(parts.field(name)) for name in ("minute", "second"))
        return (minute * 60 + second) * SECOND + _fraction(parts)
    if form == LENGTH:
        sizes = np.array([NANOSECONDS[one] for one in parts.field("unit").to_pylist()])
        return np.rint(parts.field("number").cast(pa.float64()).to_numpy() * sizes).astype(np.int64)
    return _days(parts) * DAY + _of_day(parts) - _zone(parts)


def _of_day(parts: pa.StructArray) -> np.ndarray:
    """Return the time of day [ns]."""
    hour, minute, second = (_whole(parts.field(name)) for name in ("hour", "minute", "second"))
    half = np.array([one[:1].lower() for one in parts.field("half").to_pylist()], "U1")
    hour = np.where(half == "", hour, hour % 12 + 12 * (half == "p"))
    return ((hour * 60 + minute) * 60 + second) * SECOND + _fraction(parts)


def _fraction(parts: pa.StructArray) -> np.ndarray:
    """Return the fraction of a second [ns]."""
    return _whole(pc.utf8_rpad(parts.field("rest"), 9, "0"))


def _days(parts: pa.StructArray) -> np.ndarray:
    """Return the days since 1970; zero where the date is not known."""
    names = pc.utf8_lower(parts.field("name")).to_pylist()
    month = _whole(parts.field("month")) + [MONTHS.index(one) + 1 if one else 0 for one in names]
    year, day = (_whole(parts.field(name)) + _whole(parts.field(f"later_{name}")) for name in ("year", "day"))
    months = np.where(month > 0, (year - 1970) * 12 + month - 1, 0)
    first = months.astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    return np.where(month > 0, first + day - 1, 0)


def _zone(parts: pa.StructArray) -> np.ndarray:
    """Return how far a clock is ahead of UTC [ns]."""
    minutes = 60 * _whole(parts.field("zone_hours")) + _whole(parts.field("zone_minutes"))
    return np.where(pc.equal(parts.field("sign"), "-").to_numpy(zero_copy_only=False), -minutes, minutes) * 60 * SECOND


def _whole(texts: pa.Array) -> np.ndarray:
    """Return whole numbers; zero for an empty text."""
    return pc.if_else(pc.equal(texts, ""), "0", texts).cast(pa.int64()).to_numpy()
