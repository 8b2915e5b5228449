"""Tables of fixes with a header, as text of any dialect or Parquet; and those of KF-GINS, which have none."""

from pathlib import Path

import numpy as np
import pandas as pd

from imugap import spelling
from imugap.io import gnss
from imugap.io.fixes.decoded import Decoded
from imugap.io.formats import catalogue
from imugap.io.formats.source import Source
from imugap.io.recognition import column_names, stamps
from imugap.io.recognition.settings import RecordingSettings
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
}  # fmt: skip
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


def decode(path: Path, topic: str | None) -> Decoded:
    """Return the fixes of a table; LogError where a column is missing."""
    source = catalogue.open_source(path, RecordingSettings(topic=topic))
    names = source.names if any(source.names) else _nameless(source)
    known = {name: column for name in names if (column := _column(name))}
    time = _time(names, known)
    missing = [column for column in (TIME, *gnss.PLACE) if column not in (*known.values(), time and TIME)]
    if missing:
        expected = f"all of {', '.join(gnss.PLACE)} [deg, deg, m], and time [s]"
        raise LogError(path, source.heading, expected, _nearest(names, known))
    block, raw = source.load([names.index(name) for name in known], names.index(time))
    table = pd.DataFrame(dict(zip(known.values(), block, strict=True)))
    if "vel_u" in table:
        table["vel_d"] = -table.pop("vel_u")
    stated = column_names.stated_unit(time)
    unit = stated or _unit(raw)
    table.index = pd.Index(stamps.seconds(raw, factor(unit)), name=TIME)
    others = [name for name in names if name and name not in known and name != time]
    notes = [f"left out {', '.join(others)[:120]}"] if others else []
    if unit != "s":
        notes.append(f"stamps {unit} -> s from the {'header' if stated else 'rate'}")
    return Decoded(table, tuple(notes), source.place)


def _column(name: str) -> str | None:
    plain = "".join(one for one in name.partition("(")[0].partition("[")[0].lower() if one.isalpha())
    return COLUMN.get(plain)


def _time(names: tuple[str, ...], known: dict[str, str]) -> str | None:
    """Return the name of the column of stamps: ``time``, or the plainest that names a time."""
    if TIME in names:
        return TIME
    return next(iter(column_names.assign([name for name in names if name not in known]).times), None)


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
