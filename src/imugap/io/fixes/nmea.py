"""Sentences of NMEA 0183: GGA (position), RMC (date, speed, course), GST (standard deviations).

Heights are above the ellipsoid: the altitude plus the separation of the geoid. Without a date, time is that of the day.
"""

from collections.abc import Iterator
from datetime import UTC, datetime
from functools import reduce
from math import cos, nan, radians, sin
from operator import xor
from pathlib import Path

import pandas as pd

from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.log import TIME, LogError

KNOT = 1852 / 3600
DAY_S = 86_400
TYPES = ("GGA", "RMC", "GST")


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a line of the head is a sentence of a receiver."""
    return any(line[:1] == b"$" and line[3:6].decode("ascii", "replace") in TYPES for line in head.splitlines())


def decode(path: Path, settings: ReceiverSettings) -> Decoded:
    """Return the fixes of all sentences of one time; those with a wrong checksum or without a fix are left out."""
    rows: dict[float, dict[str, float]] = {}
    day, last, wrong = 0.0, 0.0, 0
    for fields in _sentences(path):
        if fields is None:
            wrong += 1
            continue
        kind = fields[0][2:5]
        if kind not in TYPES or not fields[1]:
            continue
        clock = int(fields[1][:2]) * 3600 + int(fields[1][2:4]) * 60 + float(fields[1][4:])
        if kind == "RMC" and len(fields) > 9 and len(fields[9]) == 6:
            date = datetime.strptime(fields[9], "%d%m%y").replace(tzinfo=UTC)
            day = date.timestamp()
        elif clock < last - DAY_S / 2:
            day += DAY_S
        last = clock
        rows.setdefault(day + clock, {}).update(_values(kind, fields))
    known = {time: row for time, row in rows.items() if "latitude" in row}
    if not known:
        raise LogError(path, "sentences", "GGA with a position", "none")
    table = pd.DataFrame.from_dict(known, orient="index")
    table.index.name = TIME
    if "vel_n" in table:
        table["vel_d"] = nan
    notes = ("NMEA, UTC in seconds since 1970" if day else "NMEA, time of day",)
    return Decoded(table, notes + ((f"left out {wrong} sentences with a wrong checksum",) if wrong else ()))


def _sentences(path: Path) -> Iterator[list[str] | None]:
    """Yield the fields of each sentence, None where its checksum is wrong."""
    with path.open(encoding="ascii", errors="replace") as handle:
        for line in handle:
            _, mark, body = line.strip().partition("$")
            body, star, check = body.partition("*")
            if mark:
                right = not star or f"{reduce(xor, map(ord, body), 0):02X}" == check[:2].upper()
                yield body.split(",") if right else None


def _values(kind: str, fields: list[str]) -> dict[str, float]:
    match kind:
        case "GGA" if len(fields) > 11 and fields[2] and fields[6] not in ("", "0"):
            place = {
                "latitude": _degrees(fields[2], fields[3] == "S"),
                "longitude": _degrees(fields[4], fields[5] == "W"),
            }
            return place | {"height": float(fields[9] or nan) + float(fields[11] or 0)}
        case "RMC" if len(fields) > 8 and fields[2] == "A" and fields[7] and fields[8]:
            speed, course = float(fields[7]) * KNOT, radians(float(fields[8]))
            return {"vel_n": speed * cos(course), "vel_e": speed * sin(course)}
        case "GST" if len(fields) > 8 and all(fields[6:9]):
            return dict(zip(("sd_n", "sd_e", "sd_d"), map(float, fields[6:9]), strict=True))
    return {}


def _degrees(text: str, negative: bool) -> float:
    """Convert degrees and minutes, ``ddmm.mm``, to degrees."""
    whole = text.index(".") - 2 if "." in text else len(text) - 2
    value = int(text[:whole]) + float(text[whole:]) / 60
    return -value if negative else value
