"""Fixes of a receiver in any format that is known, checked and in SI (:mod:`imugap.io.gnss`)."""

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.io import gnss
from imugap.io.fixes import bags, gnss_ins_sim, gpx, nmea, phones, px4, rtklib, tables
from imugap.io.fixes.decoded import Decoded
from imugap.io.fixes.receiver_settings import DEFAULTS, ReceiverSettings
from imugap.io.formats.source import require_file, sha256_of, whole_file
from imugap.io.rows import require_numbers, require_order, require_range
from imugap.log import TIME
from imugap.units import to_si

FORMATS = (bags, px4, gnss_ins_sim, phones, rtklib, gpx, nmea, tables)
HEAD_BYTES = 4096


@dataclass(frozen=True, eq=False)
class ReceiverLog:
    """Fixes of a receiver, checked and in SI, sentences on what was recognised, and the file."""

    fixes: pd.DataFrame
    recognised: tuple[str, ...] = ()
    source: Path = Path("fixes")

    @cached_property
    def sha256(self) -> str:
        """Return the SHA-256 of the file, or of the table where there is none."""
        if self.source.exists():
            return sha256_of(self.source)
        return sha256(np.ascontiguousarray(self.fixes.reset_index().to_numpy(float)).tobytes()).hexdigest()


def read(path: str | Path, settings: ReceiverSettings = DEFAULTS) -> ReceiverLog:
    """Read the fixes of a receiver, in a format that is recognised by its content.

    Parameters
    ----------
    path
        File of any of :data:`FORMATS`; a table has columns ``time`` [s], latitude and longitude [deg], height [m], and
        any of the others of :data:`imugap.io.gnss.COLUMNS`, whose cells may be empty.
    settings
        What the user says of it.
    """
    path = Path(path)
    require_file(path, "a log of fixes")
    head = b""
    if path.is_file():
        with path.open("rb") as handle:
            head = handle.read(HEAD_BYTES)
    with whole_file(path):
        decoded = next(one for one in FORMATS if one.recognises(path, head)).decode(path, settings)
    return _checked(decoded, path)


def of_table(table: pd.DataFrame) -> ReceiverLog:
    """Take a table as the fixes of a receiver: index ``time`` [s], columns as those of a file (:func:`read`)."""
    return _checked(Decoded(table.copy()), ReceiverLog.source)


def _checked(decoded: Decoded, path: Path) -> ReceiverLog:
    table = decoded.table
    require_range({TIME: table.index.to_numpy()}, path, decoded.place)
    require_order(table, path, decoded.place)
    require_numbers(table[[name for name in gnss.PLACE if name in table]], path, decoded.place)
    for name in table.columns.intersection(["latitude", "longitude"]):
        table[name] = to_si(table[name], "deg")
    fixes = gnss.check(table, path, decoded.place)
    return ReceiverLog(fixes, (f"{len(fixes)} fixes", *decoded.notes) if decoded.notes else (), path)
