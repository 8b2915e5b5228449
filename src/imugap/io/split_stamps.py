"""Stamps in several columns: seconds and nanoseconds, week and seconds, hours to milliseconds, date and time of day."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import pyarrow as pa

from imugap.io.formats import clock_text
from imugap.io.formats.source import Source
from imugap.io.recognition.column_names import OF_HOST, parts_of
from imugap.log import LogError

WEEK = 604_800_000_000_000
SIZES = {
    WEEK: "week weeks wn gpsweek",
    3_600_000_000_000: "hour hours hr hh",
    60_000_000_000: "minute minutes min mm",
    1_000_000_000: "s sec secs second seconds ss tow sow",
    1_000_000: "ms msec msecs millisecond milliseconds millis itow",
    1_000: "us usec usecs microsecond microseconds micros",
    1: "ns nsec nsecs nanosec nanosecs nanosecond nanoseconds nanos",
}
"""Nanoseconds of the parts of a stamp, and the words of their columns, the last of which counts."""
PART = {word: size for size, words in SIZES.items() for word in words.split()}
OTHER_WORDS = frozenset([
    "time", "stamp", "timestamp", "header", "gps", "gnss", "utc", "of", "in", "t", "ts", "epoch", "unix", "clock",
    "since",
])  # fmt: skip
"""Other words of the names of these columns."""
CLOCK = frozenset(["time", "stamp", "timestamp", "epoch"])
"""Words of a column of whole seconds that may name no unit."""
DATE, OF_DAY = frozenset(["date"]), frozenset(["time", "clock", "tod"])
"""Words of a column of dates, and of one of times of day."""
RECEIVER = frozenset(["gps", "gnss"])
"""Words of stamps of a receiver."""
CALENDAR = ("year", "month", "day")
ROWS = 2000
NAME = "stamp [ns]"
"""Name of the column of whole stamps."""

Join = Callable[[Sequence[np.ndarray]], np.ndarray]
"""From parts of stamps, shape (n,) each, the stamps [ns]."""


def with_stamps(source: Source, receiver: bool = False) -> Source:
    """Return a source with one column of stamps in place of several that are its parts.

    Of several stamps it is that of the sensor, or that of the ``receiver``.
    """
    dated = _dated(source)
    if dated is not None:
        order = _order(source, dated[0])
        source = source if order is None else replace(
            source, notes=(*source.notes, order.sentence(source.names[dated[0]]))
        )  # fmt: skip
        return _joined(source, dated, lambda parts: _of_texts(parts, order), source.texts)
    found = _split(source, receiver)
    if not found:
        return source
    sizes, places = zip(*found, strict=True)
    days = _calendar(source) if max(sizes) < WEEK else ()
    return _joined(source, (*places, *days), lambda parts: _sum(parts, sizes) + _days(parts[len(sizes) :]))


def _dated(source: Source) -> tuple[int, int] | None:
    """Return the positions of a date and a time of day; None where there are no such texts."""
    words = [set(parts_of(name)[0]) for name in source.names]
    dates, times = ([k for k, one in enumerate(words) if one & kind] for kind in (DATE, OF_DAY))
    if source.cells is None or not dates or not times:
        return None
    try:
        date, clock = (next(source.texts(places[0]), np.empty(0, str))[:ROWS] for places in (dates, times))
    except LogError:
        return None
    are_dated = [
        clock_text.is_time(f"{day} {hour}") and not clock_text.is_time(day)
        for day, hour in zip(date, clock, strict=False)
    ]
    return (dates[0], times[0]) if dates[0] != times[0] and len(are_dated) and all(are_dated) else None


def _split(source: Source, receiver: bool) -> list[tuple[int, int]]:
    """Return the size [ns] and position of the parts of a stamp, the coarsest first; none where there is one part.

    The values of a part are less than one of the part before, which is whole.
    """
    stamps: dict[tuple[str, ...], dict[int, int]] = {}
    for place, name in enumerate(source.names):
        words, unit = parts_of(name)
        sizes = [PART[word] for word in (*words, unit) if word in PART] or [PART["s"]] * bool(CLOCK & {*words})
        others = sorted({*words} - {*PART} - OTHER_WORDS)
        if sizes and (not others or CLOCK & {*words}):
            rank = not RECEIVER & {*words} if receiver else len(OF_HOST & {*words})
            stamps.setdefault((rank, name.rpartition(".")[0], *others), {}).setdefault(min(sizes), place)
    several = sorted((one for one in stamps.items() if len(one[1]) > 1), key=lambda one: one[0][0])
    found = (_bounded(source, sorted(parts.items(), reverse=True)) for _, parts in several)
    return next(filter(None, found), [])


def _calendar(source: Source) -> tuple[int, ...]:
    """Return the positions of a year, a month and a day; none where one is missing."""
    plain = {tuple(parts_of(name)[0]): k for k, name in enumerate(source.names)}
    return tuple(plain[one,] for one in CALENDAR) if all((one,) in plain for one in CALENDAR) else ()


def _days(parts: Sequence[np.ndarray]) -> np.ndarray | int:
    """Return years, months and days, shape (n,) each, as nanoseconds since 1970; 0 where there are none."""
    if not parts:
        return 0
    year, month, day = (np.asarray(one).astype(np.int64) for one in parts)
    first = ((year - 1970) * 12 + month - 1).astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    return (first + day - 1) * clock_text.DAY


def _bounded(source: Source, parts: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the parts from the coarsest on of which each is less than one of the part before; none where it is one.

    Rows of another sensor lack them.
    """
    try:
        values = np.array([one.astype(float) for one in source.head([place for _, place in parts], ROWS)])
    except LogError:
        return []
    values = values[:, np.isfinite(values).all(axis=0)]
    kept = [0]
    for k in range(1, len(parts) if values.size else 0):
        whole = bool((values[kept[-1]] == np.rint(values[kept[-1]])).all())
        if whole and values[k].min() >= 0 and values[k].max() * parts[k][0] < parts[kept[-1]][0] + parts[k][0]:
            kept.append(k)
    return [parts[k] for k in kept] if len(kept) > 1 else []


def _sum(parts: Sequence[np.ndarray], sizes: Sequence[int]) -> np.ndarray:
    """Return the stamps that parts of these sizes [ns] add up to, whole where no part is missing."""
    if not all(np.isfinite(one).all() for one in parts):
        return sum(part * float(size) for part, size in zip(parts, sizes, strict=False))
    terms = (
        part.astype(np.int64) * size if part.dtype.kind == "i" else np.rint(part * float(size)).astype(np.int64)
        for part, size in zip(parts, sizes, strict=False)
    )
    return sum(terms, np.zeros(len(parts[0]), np.int64))


def _order(source: Source, column: int) -> clock_text.Order | None:
    """Return the order of day, month and year in a column of dates; LogError where it is not known."""
    try:
        return clock_text.order_of(pa.array(batch.tolist(), pa.string()) for batch in source.texts(column))
    except ValueError as error:
        raise LogError.at(source.path, f"column {source.names[column]}", error) from error


def _of_texts(parts: Sequence[np.ndarray], order: clock_text.Order | None) -> np.ndarray:
    return clock_text.nanoseconds(pa.array([f"{date} {clock}" for date, clock in zip(*parts, strict=True)]), order)


def _joined(source: Source, places: Sequence[int], join: Join, texts=None) -> Source:
    """Return a source with what joins some columns as the last, and these without a name."""
    count = len(source.names)

    def stamps() -> Iterator[np.ndarray]:
        parts = source.batches(places) if texts is None else zip(*map(texts, places), strict=True)
        return map(join, parts)

    def batches(columns: Sequence[int]) -> Iterator[list[np.ndarray]]:
        others = [k for k in columns if k != count]
        rest = source.batches(others) if others else ([] for _ in stamps())
        joined = stamps() if count in columns else None
        for values in rest:
            found = dict(zip(others, values, strict=True))
            yield [next(joined) if k == count else found[k] for k in columns]

    names = (*("" if k in places else name for k, name in enumerate(source.names)), NAME)
    notes = (*source.notes, f"stamps from {' and '.join(source.names[k] for k in places)}")
    return replace(
        source, names=names, batches=batches, notes=notes, whole=source.whole | {NAME},
        clocks=source.clocks if texts is None else source.clocks | {count},
        cells=lambda column: source.texts(column) if column < count else (one.astype(str) for one in stamps()),
    )  # fmt: skip
