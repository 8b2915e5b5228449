"""Column of the stamps: which of the columns of a file it is, and what is said of the choice."""

import numpy as np

from imugap.io.formats.source import Source
from imugap.io.recognition import column_names, stamps
from imugap.io.recognition.column_names import SKIP, Assignment
from imugap.log import TIME, LogError
from imugap.units import factor

SAMPLE_ROWS = 2000
"""Rows on which a column of stamps has to advance, where there are several."""
EVEN, OTHER_RATE = 0.2, 0.02
"""Largest unevenness of stamps that tell the rate, and share by which an option contradicts it."""
CLOCK_WORDS = frozenset(["date", "time", "clock", "datum", "hhmmss", "utc"])
"""Words of columns that may be stamps."""
SHOWN = 3
"""Columns named that may be the stamps."""


def find(source: Source, names: list[str], assignment: Assignment, rate_hz: float | None) -> int | None:
    """Return the position of the column of stamps, None where ``--rate`` or a rate in the file stands for it."""
    if rate_hz:
        return None
    places = _clocks(source, names, assignment)
    if not places and source.rate:
        return None
    if not places:
        counter = f"; {assignment.counters[0]!r} counts samples and is no clock" if assignment.counters else ""
        found = f"{', '.join(assignment.columns.values())[:120]}{counter}{_other_clocks(source, names, assignment)}"
        raise LogError(
            source.path, source.heading, "stamps (--columns time=NAME), or the rate of the samples (--rate HZ)", found
        )
    if len(places) == 1 and not source.rate:
        return places[0]
    found = [_first_stamps(source, place) for place in places]
    if source.rate and not any(np.isfinite(values).any() for values in found):
        return None
    if names[places[0]] == TIME and stamps.run(found[0]):
        return places[0]
    return min(zip(places, found, strict=True), key=lambda one: _disorder(one[1]))[0]


def sentences(
    source: Source, names: list[str], assignment: Assignment, stamp: int | None, rate_hz: float | None
) -> tuple[str, ...]:
    """Return which of several columns of stamps is taken, and which even stamps a rate replaces that contradict it."""
    return (*_chosen(names, stamp, assignment), *_overruled(source, names, assignment, rate_hz))


def _clocks(source: Source, names: list[str], assignment: Assignment) -> list[int]:
    """Return the positions of columns that may be the stamps, the plainest first."""
    others = [name for name in assignment.times if name != TIME]
    places = [names.index(name) for name in (*[TIME] * (TIME in names), *others)]
    return places or [place for place in source.clocks if names[place] != SKIP]


def _disorder(values: np.ndarray) -> tuple[bool, float]:
    """Return whether stamps do not advance, and how uneven they are, to a hundredth of the interval."""
    return not stamps.run(values), round(stamps.unevenness(values), 2)


def _chosen(names: list[str], stamp: int | None, assignment: Assignment) -> tuple[str, ...]:
    """Return which of several columns of stamps is taken, a sentence."""
    if stamp is None or len(assignment.times) < 2 or names[stamp] not in assignment.times:
        return ()
    return (f"stamps from column {names[stamp]!r} of {len(assignment.times)}",)


def _overruled(source: Source, names: list[str], assignment: Assignment, rate_hz: float | None) -> tuple[str, ...]:
    """Return which even stamps say another rate than the option that replaces them, a sentence."""
    for place in _clocks(source, names, assignment) if rate_hz else ():
        values = _first_stamps(source, place)
        said = _stated_rate(values, "ns" if place in source.clocks else column_names.stated_unit(names[place]))
        if said and stamps.unevenness(values) < EVEN and abs(said / rate_hz - 1) > OTHER_RATE:
            return (f"STAMPS NOT USED: column {names[place]!r} says {said:.5g} Hz (leave out --rate to take it)",)
    return ()


def _stated_rate(values: np.ndarray, unit: str | None) -> float | None:
    """Return the rate [Hz] of the first stamps of a column, None where they do not tell."""
    try:
        return 1 / (stamps.step_of(values) * factor(unit or stamps.unit_of_stamps(values, False)[0]))
    except ValueError:
        return None


def _other_clocks(source: Source, names: list[str], assignment: Assignment) -> str:
    """Return which other columns advance as stamps do, in words."""
    read = {*assignment.columns.values(), *assignment.counters, SKIP, ""}
    others = [name for place, name in enumerate(names) if name not in read and _may_be_clock(source, place)]
    return f"; {', '.join(map(repr, others[:SHOWN]))} may be the stamps" if others else ""


def _may_be_clock(source: Source, place: int) -> bool:
    """Return whether a column has a word of a clock in its name, or advances."""
    words = set(column_names.words_of(source.names[place]))
    return bool(words & CLOCK_WORDS) or stamps.advances(_first_stamps(source, place))


def _first_stamps(source: Source, place: int) -> np.ndarray:
    """Return the first stamps of a column; none where it has texts that are no times."""
    try:
        return source.head([place], SAMPLE_ROWS)[0].astype(float)
    except LogError:
        return np.empty(0)
