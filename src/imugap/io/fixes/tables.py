"""Tables of fixes with a header, as text of any dialect or Parquet; and those of KF-GINS, which have none."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from imugap import spelling
from imugap.io import gnss
from imugap.io.fixes import fix_units
from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.fixes.speed_course import COURSE, HEIGHT_STD, RADIUS, SPEED, SPEED_STD, with_components
from imugap.io.formats import catalogue
from imugap.io.formats.source import Source
from imugap.io.recognition import column_names, stamps
from imugap.io.recognition.settings import RecordingSettings
from imugap.io.split_stamps import with_stamps
from imugap.kinematics.strapdown import VELOCITY
from imugap.log import TIME, LogError
from imugap.units import factor

SPELLINGS = {
    "latitude": "latitude lat", "longitude": "longitude lon lng long",
    "height": "height alt altitude h hgt ele elevation ellipsoidalheight",
    "vel_n": "veln vn vnorth northvelocity velocitynorth", "vel_e": "vele ve veast eastvelocity velocityeast",
    "vel_d": "veld vd vdown downvelocity velocitydown", "vel_u": "velu vu vup upvelocity velocityup",
    "sd_n": "sdn stdn sn", "sd_e": "sde stde se", "sd_d": "sdd stdd sdu stdu su sd",
    "sd_vel_n": "sdveln sdvn", "sd_vel_e": "sdvele sdve", "sd_vel_d": "sdveld sdvd sdvu",
    SPEED: "speed groundspeed speedoverground sog", COURSE: "course bearing courseoverground cog",
    RADIUS: "horizontalaccuracy accuracy hacc", HEIGHT_STD: "verticalaccuracy vacc", SPEED_STD: "speedaccuracy sacc",
}  # fmt: skip
PREFIXES = ("location", "gps", "gnss")
"""What may stand before a name of a column of the receiver, in a table with those of other sensors."""
HEMISPHERES = {"latitude": ("N", "S"), "longitude": ("E", "W")}
"""Letters of a column of their own that says the sign of the places: the second one is below zero."""
ROWS = 2000
"""Rows at the begin of a column that show whether it has such letters."""
INTERVALS = 0.02, 20.0
"""Usual times between fixes of a vehicle [s]: three decades, so that one unit alone gives such a time."""
COLUMN = {spelling: column for column, spellings in SPELLINGS.items() for spelling in spellings.split()}
KF_GINS = {
    7: (TIME, *gnss.PLACE, *gnss.PLACE_STD),
    13: (TIME, *gnss.PLACE, *gnss.PLACE_STD, *VELOCITY, *gnss.VELOCITY_STD),
}
"""Columns of files without a header, by their number."""


def recognises(path: Path, head: bytes) -> bool:
    """Return True: the last format that is tried."""
    return True


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of a table; LogError where a column is missing."""
    source = with_stamps(catalogue.open_source(path, RecordingSettings(topic=settings.topic)), receiver=True)
    if settings.topic is not None and source.topic is None:
        source = source.group(settings.topic)
    names = source.names if any(source.names) else _nameless(source)
    known = _known(source, names)
    time = _time(source, names, known)
    missing = [column for column in (TIME, *gnss.PLACE) if column not in (*known.values(), time and TIME)]
    if missing:
        expected = f"all of {', '.join(gnss.PLACE)} [deg, deg, m], and time [s]"
        raise LogError(path, source.heading, expected, _nearest(names, known))
    block, raw = source.load([names.index(name) for name in known], names.index(time))
    count = len(raw)
    block, raw, rows = _of_receiver(block, raw, _prefix(time) != "")
    if stamps.are_clock_numbers(raw):
        raise LogError(path, f"column {time}", "seconds, or times of day as HH:MM:SS", "numbers HHMMSS")
    stated = column_names.stated_unit(time)
    unit = stated or _unit(raw)
    seconds = pd.Index(stamps.seconds(raw, factor(unit)), name=TIME)
    table = pd.DataFrame(dict(zip(known.values(), block, strict=True)), index=seconds)
    angles = settings.angles or (None if any(source.names) else "deg")
    try:
        notes = _convert(table, {column: name for name, column in known.items()}, angles)
    except ValueError as error:
        raise LogError.at(path, source.heading, error) from error
    table, said = with_components(table, fix_units.scale(SPEED, _name_of(known, SPEED))[1])
    notes += said
    if "vel_u" in table:
        table["vel_d"] = -table.pop("vel_u")
    if unit != "s":
        notes.append(f"stamps {unit} -> s from the {'header' if stated else 'rate'}")
    others = [name for name in names if name and name not in known and name != time]
    for column, name, letters in _hemispheres(source, names, tuple(others)):
        _, below = HEMISPHERES[column]
        table.loc[letters[rows] == below, column] = -table.loc[letters[rows] == below, column].abs()
        others.remove(name)
        notes.append(f"sign of {column} from {name}")
    notes += [f"left out {', '.join(others)[:120]}"] if others else []
    notes += [f"{count - len(rows)} rows without a fix: left out"] if len(rows) < count else []
    return Decoded(table, tuple(notes), lambda row: source.place(int(rows[row])))


def _of_receiver(block: np.ndarray, raw: np.ndarray, own: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the columns, shape (columns, m), and stamps of the rows that hold anything of a fix, and their numbers.

    Where the stamps are the ``own`` ones of the receiver, a row that repeats one holds no other fix.
    """
    there = np.isfinite(block).any(axis=0)
    rows = np.flatnonzero(there & np.append(True, raw[1:] != raw[:-1]) if own else there)
    return (block, raw, rows) if len(rows) == len(raw) else (block[:, rows], raw[rows], rows)


def _convert(table: pd.DataFrame, names: dict[str, str], angles: str | None) -> list[str]:
    """Convert the columns of a table to degrees, metres and metres per second; return what was converted.

    ``angles`` is the unit of latitude and longitude, None where the names or the places decide; ValueError where these
    do not.
    """
    stated = {column: fix_units.scale(column, name) for column, name in names.items()}
    notes = fix_units.said([(column, unit) for column, (_, unit) in stated.items() if unit], "header")
    guessed = {}
    if angles is not None:
        guessed = dict.fromkeys(("latitude", "longitude"), angles)
        notes += fix_units.said(guessed.items(), "option")
    elif stated["latitude"][1] is None and stated["longitude"][1] is None:
        speeds = [table[one].to_numpy() * stated[one][0] for one in VELOCITY[:2] if one in table]
        speed = np.hypot(*speeds) if len(speeds) == len(VELOCITY[:2]) else None
        places = (table[one].to_numpy() for one in ("latitude", "longitude"))
        unit = fix_units.of_places(table.index.to_numpy(), *places, speed)
        guessed = dict.fromkeys(("latitude", "longitude"), unit)
        if unit == fix_units.INTEGERS and stated["height"][1] is None:
            guessed["height"] = "mm" if table["height"].abs().median() > fix_units.HIGHEST_M else "m"
        notes += fix_units.said(guessed.items(), "places")
    for column, (scale, _) in stated.items():
        scale = fix_units.FACTORS[guessed[column]] if column in guessed else scale
        if scale != 1.0:
            table[column] = table[column] * scale
    return notes


def _known(source: Source, names: tuple[str, ...]) -> dict[str, str]:
    """Return the columns that are read, the plainest of each kind; LogError where two groups have one."""
    found: dict[str, list[str]] = {}
    for name in names:
        if column := _column(name):
            found.setdefault(column, []).append(name)
    known = {}
    for column, rivals in found.items():
        rivals = sorted(rivals, key=lambda name: SPELLINGS[column].split().index(_spelling(name)))
        if len(rivals) > 1 and _spelling(rivals[0]) == _spelling(rivals[1]):
            expected = f"one column of {column} (--topic takes what stands before the dot)"
            raise LogError(source.path, source.heading, expected, ", ".join(rivals)[:120])
        known[rivals[0]] = column
    return {name: known[name] for name in names if name in known}


def _column(name: str) -> str | None:
    return COLUMN.get(_spelling(name))


def _name_of(known: dict[str, str], column: str) -> str:
    """Return the name in the file of a column; nothing where it has none."""
    return next((name for name, one in known.items() if one == column), "")


def _prefix(name: str) -> str:
    """Return which of :data:`PREFIXES` stands before a name; nothing where none does."""
    plain = _plain(name)
    return next((one for one in PREFIXES if plain.startswith(one) and plain != one), "")


def _spelling(name: str) -> str:
    """Return the letters of a name, without what stands before the names of one sensor."""
    plain = _plain(name)
    return plain if plain in COLUMN else plain.removeprefix(_prefix(name))


def _plain(name: str) -> str:
    """Return the letters of a name, without its group and its unit."""
    base = name.partition("(")[0].partition("[")[0].rpartition(".")[2]
    return "".join(one for one in base.lower() if one.isalpha())


def _time(source: Source, names: tuple[str, ...], known: dict[str, str]) -> str | None:
    """Return the name of the column of stamps: that of the receiver, in a table with those of other sensors.

    Else, of ``time`` and the others that name a time, the first that is one.
    """
    others = column_names.assign([name for name in names if name not in (*known, TIME)]).times
    own = next((name for name in others if _prefix(name) and _prefix(name) in map(_prefix, known)), None)
    if own is not None:
        return own
    candidates = (*[TIME] * (TIME in names), *others)
    return next((name for name in candidates[:-1] if _runs(source, names.index(name))), (None, *candidates)[-1])


def _runs(source: Source, column: int) -> bool:
    """Return whether a column holds stamps that advance."""
    try:
        return stamps.run(source.head([column], ROWS)[0].astype(float))
    except LogError:
        return False


def _hemispheres(
    source: Source, names: tuple[str, ...], others: tuple[str, ...]
) -> Iterator[tuple[str, str, np.ndarray]]:
    """Yield latitude or longitude, the name of a column with the letters of its hemisphere, and these, shape (n,)."""
    for name in others:
        try:
            first = next(source.texts(names.index(name)), np.empty(0, str))[:ROWS]
            found = next((one for one, letters in HEMISPHERES.items() if len(first) and set(first) <= {*letters}), None)
            if found is not None:
                yield found, name, np.concatenate(list(source.texts(names.index(name))))
        except LogError:  # neither numbers nor texts
            continue


def _unit(raw: np.ndarray) -> str:
    """Return the unit of stamps of fixes: that of a usual interval before the year 2099, else the largest before it."""
    first, steps = (float(raw[0]), np.diff(raw)) if len(raw) else (0.0, np.empty(0))
    units = [unit for unit in ("s", "ms", "us", "ns") if first * factor(unit) < stamps.YEARS[1]] or ["s"]
    interval = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    low, high = INTERVALS
    return next((unit for unit in units if low <= interval * factor(unit) < high), units[0])


def _nameless(source: Source) -> tuple[str, ...]:
    names = KF_GINS.get(len(source.names))
    if names is None:
        expected = f"a header, or the {' or '.join(map(str, KF_GINS))} columns of KF-GINS"
        raise LogError(source.path, source.heading, expected, f"{len(source.names)} columns without names")
    return names


def _nearest(names: tuple[str, ...], known: dict[str, str]) -> str:
    for name in names:
        question = spelling.hint(name, (TIME, *gnss.COLUMNS))
        if question and name not in known and name != TIME:
            return f"{name!r}{question}"
    return ", ".join(names)[:120] or "nothing"
