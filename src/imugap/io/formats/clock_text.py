"""Times as texts: dates with a time of day, times of day or of the hour alone, lengths of time with their unit.

Dates count from 1970. Where only numbers stand for day, month and year and the year is not known to be first, all dates
of a column decide their order (:func:`order_of`).
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date
from itertools import chain, pairwise

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

MONTHS = {
    "jan": 1, "feb": 2, "mar": 3, "mär": 3, "mrz": 3, "apr": 4, "may": 5, "mai": 5, "jun": 6, "jul": 7, "aug": 8,
    "sep": 9, "oct": 10, "okt": 10, "nov": 11, "dec": 12, "dez": 12,
}  # fmt: skip
"""First letters of the months in English and German."""
NUMBERS = r"(?P<one>\d{1,2})(?P<mark>[-/.])(?P<two>\d{1,2})[-/.](?P<three>\d{4}|\d\d)"
"""Day, month and year in an order that is not known."""
CLOCK = (
    r"^(?:(?:(?P<year>\d{4})[-/.](?P<month>\d{1,2})[-/.](?P<day>\d{1,2})"
    rf"|(?P<later_day>\d{{1,2}})\.?[- ](?P<name>(?i:{'|'.join(MONTHS)}))[a-zä]*\.?[- ](?P<later_year>\d{{4}})"
    rf"|{NUMBERS})(?:T|,? +|_))?"
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
CENTURY = 2000
"""Years of two digits count from it."""
GO_ON_DAYS = 7
"""Largest step from one date of a log to the next: another order of day and month makes it weeks."""


@dataclass(frozen=True)
class Order:
    """Order of the three numbers of dates.

    Attributes
    ----------
    name
        Order in words.
    places
        Places of year, month and day among the numbers.
    same
        Another order in which the differences are the same; None where there is none.
    """

    name: str
    places: tuple[int, int, int]
    same: str | None = None

    def sentence(self, column: str) -> str:
        """Return how the dates of a column are taken."""
        others = "" if self.same is None else f" (the differences are the same as {self.same})"
        return f"dates of {column} taken as {self.name}{others}"


DAY_FIRST = Order("day/month/year", (2, 1, 0))
MONTH_FIRST = Order("month/day/year", (2, 0, 1))
YEAR_FIRST = Order("year/month/day", (0, 1, 2))


def order_of(cells: Iterable[pa.Array]) -> Order | None:
    """Return the order of day, month and year in all cells of a column; None where these are no such dates.

    An order counts in which every text is a date. Of several, the one in which a date follows the one before within
    days; where there is but one date, the usual one: the day is first, but the month before a time with AM or PM.

    Raises
    ------
    ValueError
        Where no order, or more than one, gives dates that follow each other.
    """
    batches = iter(cells)
    first = next(batches, pa.array([], pa.string()))
    cell = next((one for one in first.to_pylist() if one), "")
    begin = re.match(NUMBERS, cell)
    if begin is None:
        return None
    known = list(dict.fromkeys(chain.from_iterable(map(_numbers, chain([first], batches)))))
    dotted, short = begin["mark"] == ".", len(begin["three"]) == 2
    orders = [DAY_FIRST, *([] if dotted else [MONTH_FIRST]), *([YEAR_FIRST] if short else [])]
    if re.search("[AaPp][Mm]", cell) and not dotted:
        orders = [MONTH_FIRST, DAY_FIRST, *orders[2:]]
    days = {order: found for order in orders if (found := [_day(one, order) for one in known]) and None not in found}
    if len(known) == 1 and days:
        best, *others = days
        return Order(best.name, best.places, others[0].name if others else None)
    following = [
        order for order, one in days.items() if all(0 < after - before <= GO_ON_DAYS for before, after in pairwise(one))
    ]
    right = following if len(following) == 1 else list(days)
    if len(right) != 1:
        shown = " and ".join(repr("/".join(map(str, one))) for one in known[:2])
        raise ValueError(f"dates in one order of day, month and year (the year first leaves no doubt); found {shown}")
    return right[0]


def _numbers(cells: pa.Array) -> list[tuple[int, ...]]:
    """Return the different dates among cells, each as its three numbers, in their order."""
    parts = pc.extract_regex(cells, f"^{NUMBERS}").drop_null()
    texts = pc.binary_join_element_wise(*(parts.field(name) for name in ("one", "two", "three")), "/")
    return [tuple(map(int, one.split("/"))) for one in pc.unique(texts).to_pylist()]


def _day(numbers: tuple[int, ...], order: Order) -> int | None:
    """Return the day since 1970 of three numbers in an order; None where they are no date."""
    year, month, day = (numbers[place] for place in order.places)
    try:
        return date(year if year >= 100 else CENTURY + year, month, day).toordinal() - date(1970, 1, 1).toordinal()
    except ValueError:
        return None


def is_time(cell: str) -> bool:
    """Return whether a text is a time."""
    return any(re.match(one, cell) for one in (CLOCK, OF_HOUR, LENGTH))


def nanoseconds(cells: pa.Array, order: Order | None = None) -> np.ndarray:
    """Return times as texts in nanoseconds, shape (n,): since 1970, since midnight, since the hour, or from zero.

    ``order`` is that of the numbers of dates; by default the one of these cells.

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
    try:
        order = order or order_of([cells])
    except ValueError as error:
        raise pa.ArrowInvalid(str(error)) from error
    return _days(parts, order) * DAY + _of_day(parts) - _zone(parts)


def _of_day(parts: pa.StructArray) -> np.ndarray:
    """Return the time of day [ns]."""
    hour, minute, second = (_whole(parts.field(name)) for name in ("hour", "minute", "second"))
    half = np.array([one[:1].lower() for one in parts.field("half").to_pylist()], "U1")
    hour = np.where(half == "", hour, hour % 12 + 12 * (half == "p"))
    return ((hour * 60 + minute) * 60 + second) * SECOND + _fraction(parts)


def _fraction(parts: pa.StructArray) -> np.ndarray:
    """Return the fraction of a second [ns]."""
    return _whole(pc.utf8_rpad(parts.field("rest"), 9, "0"))


def _days(parts: pa.StructArray, order: Order | None) -> np.ndarray:
    """Return the days since 1970; zero where there is no date."""
    names = pc.utf8_lower(parts.field("name")).to_pylist()
    month = _whole(parts.field("month")) + [MONTHS[one] if one else 0 for one in names]
    year, day = (_whole(parts.field(name)) + _whole(parts.field(f"later_{name}")) for name in ("year", "day"))
    if order is not None:
        numbers = [_whole(parts.field(name)) for name in ("one", "two", "three")]
        of_order = [numbers[place] for place in order.places]
        year, month, day = (one + other for one, other in zip((year, month, day), of_order, strict=True))
    year = np.where(year < 100, CENTURY + year, year)
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
