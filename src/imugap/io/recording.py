"""Recording of a user's device, in any format that is known, as a canonical log.

One door for all commands: :func:`read` gives a :class:`Recording`. Stages::

    open     path -> Source            columns of the file, by its content (:mod:`imugap.io.formats`)
    assign   names -> Assignment       canonical name of each column, unit in the header
    load     Source -> arrays          only the columns that are read
    clock    stamps -> seconds         by header, option, year or rate
    units    samples -> SI             by option, header, contract or physics
    turn     samples -> canonical      by option, or by gravity

What was recognised is in the sentences of the recording; what cannot be recognised is a
:class:`imugap.log.LogError` with the place, what was expected and found, and the option that decides.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.integrity.regular import Regular, regular
from imugap.io.formats.catalogue import open_source
from imugap.io.formats.source import Source
from imugap.io.recognition import column_names, frame, samples, stamps, units
from imugap.io.recognition.column_names import SKIP, Assignment
from imugap.io.rows import advances, require_numbers, require_order
from imugap.log import ACCEL, AXES, GYRO, TIME, LogError, check
from imugap.units import factor

SAMPLE_ROWS = 2000
"""Rows on which a column of stamps has to advance, where there are several."""
SHOWN = 3
"""Columns that are left out and named."""


@dataclass(frozen=True)
class RecordingSettings:
    """What the user says of a recording; anything not given is recognised from the file.

    Attributes
    ----------
    columns
        A name for each column of the file from left to right, or ``canonical=name in the file``, or those to read
        (:func:`imugap.io.recognition.column_names.chosen`).
    units
        Unit of each quantity, ``gyro``, ``accel`` or ``temperature``
        (:func:`imugap.io.recognition.units.given_units`).
    frame
        Where the axes of the device point (:func:`imugap.io.recognition.frame.rotation_of`); ``as-is`` turns nothing.
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
    weightless
        Whether gravity was removed from the specific force.
    frame
        Where the axes of the file point (:mod:`imugap.io.recognition.frame`).
    place
        From the number of a row, where it is in the file.
    """

    source: Path
    table: pd.DataFrame
    recognised: tuple[str, ...] = ()
    weightless: bool = False
    frame: str = frame.AS_IS
    place: Callable[[int], str] = "row {}".format

    @cached_property
    def log(self) -> pd.DataFrame:
        """Return the canonical log; LogError where a stamp does not increase or a sample is no number."""
        require_order(self.table, self.source, self.place)
        return self._checked(self.table)

    def require_gravity(self) -> "Recording":
        """Return the recording; LogError where gravity was removed from its specific force."""
        if self.weightless:
            expected = "specific force, 9.8 m/s^2 at rest"
            found = "linear acceleration: gravity was removed, and cannot be restored (log the accelerometer itself)"
            raise LogError(self.source, "columns accel_x to accel_z", expected, found)
        return self

    @cached_property
    def regular(self) -> Regular:
        """Return the true samples on an even clock, with gaps as gaps; LogError where no rate or no value is right."""
        return regular(self.table, str(self.source), self.place)

    @cached_property
    def repaired(self) -> pd.DataFrame:
        """Return the canonical log without the rows whose stamp is missing or does not exceed all stamps before it."""
        return self._checked(self.table[advances(self.table.index.to_numpy())])

    def _checked(self, table: pd.DataFrame) -> pd.DataFrame:
        require_numbers(table, self.source, self.place)
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
        Its table is canonical. What cannot be recognised is a :class:`imugap.log.LogError`.
    """
    path = Path(path)
    source = open_source(path, settings)
    try:
        return _recognised(source, settings)
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error


def _recognised(source: Source, settings: RecordingSettings) -> Recording:
    """Name, load, convert and turn the columns of a file."""
    names = _names(source, settings)
    assignment = _assigned(names, source)
    of = {name: names.index(column) for name, column in assignment.columns.items()}
    stamp = _time_column(source, names, assignment, settings)
    block, raw = source.load(list(of.values()), stamp)
    table = pd.DataFrame(block.T, columns=list(of), copy=False)
    if source.canonical:
        return Recording(source.path, table.set_index(pd.Index(raw, name=TIME)), place=source.place)
    contract = assignment.contract and not settings.columns
    values = dict(zip(of, block, strict=True))
    time, said = _clock(None if stamp is None else names[stamp], raw, len(table), settings)
    rate = 1 / stamps.step_of(time)
    say, weightless = _to_si(values, rate, assignment, settings, contract)
    said += say
    axes, say = _turned(values, settings)
    said += say
    said += _left_out(names, assignment, stamp)
    if said or not contract or source.notes:
        said = (f"{rate:.5g} Hz", f"{len(time):,} samples".replace(",", " "), *source.notes, *said)
    return Recording(source.path, table.set_index(pd.Index(time, name=TIME)), said, weightless, axes, source.place)


def _names(source: Source, settings: RecordingSettings) -> list[str]:
    """Return the name of each column, by the user or by the file."""
    if settings.columns:
        return list(_asked(column_names.chosen, source.heading, source.names, settings.columns))
    if not any(source.names):
        expected = "a header, or --columns with a name for each column (time gyro_x ..., - for one that is not read)"
        raise LogError(source.path, source.heading, expected, f"{len(source.names)} columns without names")
    return list(source.names)


def _assigned(names: list[str], source: Source) -> Assignment:
    """Return which columns are read; LogError where none is of an inertial sensor, or one is there twice."""
    assignment = _asked(column_names.assign, source.heading, list(dict.fromkeys(names)))
    read = (*assignment.columns.values(), *assignment.times)
    repeated = [name for name in read if names.count(name) > 1]
    if repeated:
        expected = "every column once (--columns decides)"
        raise LogError(source.path, source.heading, expected, f"{', '.join(repeated)} more than once")
    if not set(AXES) & set(assignment.columns):
        expected = "columns of gyroscopes or accelerometers (--columns names them)"
        raise LogError(source.path, source.heading, expected, column_names.nearest(name for name in names if name))
    return assignment


def _time_column(source: Source, names: list[str], assignment: Assignment, settings: RecordingSettings) -> int | None:
    """Return the position of the column of stamps, None where ``--rate`` stands for it."""
    if settings.rate_hz:
        return None
    places = [names.index(name) for name in assignment.times]
    if TIME in names:
        return names.index(TIME)
    if not places:
        counter = f"; {assignment.counters[0]!r} counts samples and is no clock" if assignment.counters else ""
        found = f"{', '.join(assignment.columns.values())[:120]}{counter}"
        raise LogError(source.path, source.heading, "stamps, or the rate of the samples (--rate HZ)", found)
    steady = [stamps.advances(values) for values in source.head(places, SAMPLE_ROWS)] if len(places) > 1 else [True]
    return places[steady.index(True) if True in steady else 0]


def _clock(
    name: str | None, raw: np.ndarray | None, rows: int, settings: RecordingSettings
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the stamps in seconds, and what was recognised, from a column and its name, if there is one."""
    if name is None:
        return np.arange(rows) / settings.rate_hz, (f"no stamps, {settings.rate_hz:g} Hz from the option",)
    unit, why = (
        settings.time_unit or column_names.stated_unit(name),
        "the option" if settings.time_unit else "the header",
    )
    if unit is None:
        unit, why = _asked(stamps.unit_of_stamps, f"column {name}", raw, name == TIME)
    said = () if unit == "s" else (f"stamps {unit} -> s from {why}",)
    return stamps.seconds(raw, factor(unit)), said


def _to_si(
    values: dict[str, np.ndarray], rate: float, assignment: Assignment, settings: RecordingSettings, contract: bool
) -> tuple[tuple[str, ...], bool]:
    """Convert the samples in place; return what was recognised, and whether gravity was removed."""
    said, weightless, accel = [], False, _triad(values, ACCEL)
    if accel is not None:
        unit = units.accel_unit(accel, rate, settings.units.get("accel"), assignment.units.get("accel"), contract)
        said += _convert(values, ACCEL, "accel", unit, rate)
        accel = _triad(values, ACCEL)
        force = samples.force_of(accel) if accel.shape[1] == len(ACCEL) else None
        weightless = assignment.free or bool(force is not None and units.without_gravity(force, 1.0))
        said += ["no gravity in the specific force: it was removed"] if weightless else []
    gyro = _triad(values, GYRO)
    if gyro is not None:
        seen = accel if accel is not None and accel.shape[1] == len(ACCEL) else None
        unit = units.gyro_unit(gyro, seen, rate, settings.units.get("gyro"), assignment.units.get("gyro"), contract)
        said = _convert(values, GYRO, "gyro", unit, rate) + said
    return tuple(said), weightless


def _triad(values: dict[str, np.ndarray], axes: tuple[str, ...]) -> np.ndarray | None:
    """Return the rows of a triad on which units are recognised, shape (n, axes); None where there is no axis."""
    found = [values[name] for name in axes if name in values]
    return samples.excerpt(found) if found else None


def _convert(values: dict, axes: tuple[str, ...], quantity: str, unit: units.Unit, rate: float) -> list[str]:
    size = unit.to_si(rate)
    for name in axes:
        if name in values and size != 1:
            values[name] *= size
    return [] if unit.evidence is None else [unit.sentence(quantity)]


def _turned(values: dict[str, np.ndarray], settings: RecordingSettings) -> tuple[str, tuple[str, ...]]:
    """Turn the samples to the canonical axes in place; return the frame of the file, and what was recognised."""
    axes = settings.frame or _vertical_frame(values) or frame.AS_IS
    if axes in (frame.AS_IS, frame.CANONICAL):
        return axes, ()
    matrix = _asked(frame.rotation_of, "frame", axes)
    for triad in (GYRO, ACCEL):
        if set(triad) <= set(values):
            turned = [_combined(row, [values[name] for name in triad]) for row in matrix]
            for name, column in zip(triad, turned, strict=True):
                values[name][:] = column
    why = f"{axes} from the option" if settings.frame else f"{frame.vertical(axes)} ({axes})"
    return axes, (f"{why} -> turned, z down",)


def _vertical_frame(values: dict[str, np.ndarray]) -> str | None:
    """Return the frame of a device with one axis along gravity, or None."""
    force = samples.force_of(_triad(values, ACCEL)) if set(ACCEL) <= set(values) else None
    return None if force is None else frame.upright(force.direction)


def _combined(row: np.ndarray, columns: list[np.ndarray]) -> np.ndarray:
    """Return the sum of columns with weights, without round-off for a single one of weight 1 or -1."""
    used = [(weight, column) for weight, column in zip(row, columns, strict=True) if weight]
    total = used[0][0] * used[0][1]
    for weight, column in used[1:]:
        total += weight * column
    return total


def _left_out(names: list[str], assignment: Assignment, stamp: int | None) -> tuple[str, ...]:
    read = {*assignment.columns.values(), *([] if stamp is None else [names[stamp]])}
    others = [name for name in names if name and name != SKIP and name not in read]
    if not others:
        return ()
    more = f" and {len(others) - SHOWN} more" if len(others) > SHOWN else ""
    return (f"left out {', '.join(others[:SHOWN])}{more}",)


def _asked(function, place: str, *arguments):
    """Call a function of recognition; its ValueError, ``expectation; found ...``, becomes a LogError at a place."""
    try:
        return function(*arguments)
    except LogError:
        raise
    except ValueError as error:
        expected, _, found = str(error).partition("; found ")
        raise LogError("log", place, expected.removeprefix("expected "), found) from error
