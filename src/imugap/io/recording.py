"""Recording of a user's device, in any format that is known, as a canonical log: read, name, convert, turn.

One door for all commands: :func:`read` gives a :class:`Recording`. What had to be recognised is in its sentences;
anything that cannot be recognised is a :class:`imugap.log.LogError` with the place, what was expected and found.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

import pandas as pd

from imugap.integrity.regular import Regular, regular
from imugap.io import readers
from imugap.log import check


@dataclass(frozen=True)
class RecordingSettings:
    """What the user says of a recording; anything not given is recognised from the file.

    Attributes
    ----------
    columns
        Names of the columns of the file, from left to right, canonical ones where they are to be read.
    units
        Unit of each quantity (``gyro``, ``accel``, ``temperature``).
    frame
        Where the axes of the device point (``FLU``, ``NED`` ...).
    rate_hz
        Sampling rate, where the file has no stamps [Hz].
    time_unit
        Unit of the stamps.
    topic
        Topic of a bag, or message of a log, that holds the samples.
    """

    columns: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    frame: str | None = None
    rate_hz: float | None = None
    time_unit: str | None = None
    topic: str | None = None


DEFAULTS = RecordingSettings()


@dataclass(frozen=True, eq=False)
class Recording:
    """Recording as read.

    Attributes
    ----------
    source
        File.
    table
        Index ``time`` [s], columns canonical, in SI and in canonical axes; unchecked: stamps may repeat or go back,
        samples may be NaN.
    recognised
        Sentences on what was recognised; empty for a file that keeps to the contract of the package.
    """

    source: Path
    table: pd.DataFrame
    recognised: tuple[str, ...] = ()

    @cached_property
    def log(self) -> pd.DataFrame:
        """Return the canonical log; LogError where a stamp does not increase or a sample is no number."""
        readers.require_order(self.table, self.source)
        return self._checked(self.table)

    @cached_property
    def regular(self) -> Regular:
        """Return the true samples on an even clock, with gaps as gaps; LogError where no rate or no value is right."""
        readers.require_si(self.table, self.source)
        return regular(self.table, str(self.source), partial(readers.place_of, self.source))

    @cached_property
    def repaired(self) -> pd.DataFrame:
        """Return the canonical log without the rows whose stamp is missing or does not exceed all stamps before it."""
        return self._checked(self.table[readers.advances(self.table.index.to_numpy())])

    def _checked(self, table: pd.DataFrame) -> pd.DataFrame:
        readers.require_numbers(table, self.source)
        readers.require_si(table, self.source)
        return check(table, self.source)


def read(path: str | Path, settings: RecordingSettings = DEFAULTS) -> Recording:
    """Read a recording of a user's device.

    Parameters
    ----------
    path
        File of any known format.
    settings
        What the user says of it.

    Returns
    -------
    Recording
        Its table is canonical. Anything else is a :class:`imugap.log.LogError` with file, line, column.
    """
    return Recording(Path(path), readers.read_table(path))
