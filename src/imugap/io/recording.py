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

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.integrity.regular import Regular, regular
from imugap.io import stamp_column
from imugap.io.devices import every_row, one_device, require_one_device, stretches_of
from imugap.io.formats.catalogue import open_source
from imugap.io.formats.memory import table_source
from imugap.io.formats.source import Source, sha256_of
from imugap.io.gravity_columns import with_gravity
from imugap.io.recognition import column_names, frame, samples, stamps
from imugap.io.recognition.column_names import SKIP, Assignment
from imugap.io.recognition.conversion import Conversion, asked, conversion
from imugap.io.recognition.settings import DEFAULTS, RecordingSettings
from imugap.io.rows import (
    advances,
    by_stamps,
    clear_vanishing,
    of_sensor,
    require_numbers,
    require_order,
    require_range,
    within_range,
    without_filler,
)
from imugap.io.sample_counter import with_counted
from imugap.io.scales import require_one_scale
from imugap.io.split_stamps import with_stamps
from imugap.log import AXES, TIME, LogError, check

LARGEST_WHOLE = 2**62
"""Stamps below it are kept as whole numbers."""
ALL = 1, 1
"""Rows of one device (:attr:`imugap.io.recognition.settings.RecordingSettings.rows`)."""
SHOWN = 3
"""Columns that are left out and named."""


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
    topic
        Topic of ROS from which it is; None where it is from none, or from two.
    """

    source: Path
    table: pd.DataFrame
    recognised: tuple[str, ...] = ()
    weightless: bool = False
    frame: str = frame.AS_IS
    place: Callable[[int], str] = "row {}".format
    topic: str | None = None

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
    def sha256(self) -> str:
        """Return the SHA-256 of the file, of all files of a folder, or of the samples where there is neither."""
        if not self.source.exists():
            samples = self.table.reset_index().to_numpy(float)
            return sha256(np.ascontiguousarray(samples).tobytes()).hexdigest()
        return sha256_of(self.source)

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
    source = _opened(path, settings)
    try:
        return _recognised(source, settings)
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error


def of_table(table: pd.DataFrame, settings: RecordingSettings = DEFAULTS) -> Recording:
    """Take a table as the recording of a device, recognised as a file with these columns is."""
    return _recognised(table_source(table), settings)


def stream(path: str | Path, settings: RecordingSettings = DEFAULTS) -> tuple[Conversion, Iterator[pd.DataFrame]]:
    """Return the conversion of a recording, and its canonical table in parts, in the memory of a part.

    The file is read twice: the conversion is recognised on stretches spread over all of it.
    """
    source = _opened(Path(path), settings)
    try:
        selection = _selected(source, settings)
        source, selection = _of_rows(source, selection, settings)
        stretches = _stretches(source, selection)
        _require_one_device(source, stretches, selection, settings)
        excerpt = dict(zip(selection.assignment.columns, np.hstack([one for one, _ in stretches]), strict=True))
        raw = None if selection.stamp is None else np.concatenate([stamps for _, stamps in stretches])
        _require_clock(source, raw)
        require_one_scale(excerpt)
        found = _conversion(selection, excerpt, raw, settings)
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error
    said = *source.notes, *selection.said, *found.recognised, *_unread(selection), *_left_out(selection)
    return replace(found, recognised=said), _parts(source, selection, found)


@dataclass(frozen=True)
class Selection:
    """Columns of a file that are read: names, positions, that of the stamps, or the rate and what states it.

    ``whole``: whether the stamps are written as whole numbers; ``clock``: whether they are times as texts; ``said``:
    sentences on the choice between stamps, and between stamps and a rate.
    """

    names: tuple[str, ...]
    assignment: Assignment
    stamp: int | None
    rate: tuple[float, str] | None
    whole: bool
    clock: bool
    said: tuple[str, ...] = ()

    @property
    def places(self) -> list[int]:
        """Return the positions of the samples."""
        return [self.names.index(column) for column in self.assignment.columns.values()]

    @property
    def inertial(self) -> list[int]:
        """Return the positions of the inertial axes among the columns that are read."""
        return [k for k, name in enumerate(self.assignment.columns) if name in AXES]

    @property
    def stamp_name(self) -> str | None:
        """Return the name of the column of stamps, None where there is none."""
        return None if self.stamp is None else self.names[self.stamp]


def _opened(path: Path, settings: RecordingSettings) -> Source:
    """Return the columns of a file, those of a group, and the rows of a device, where one is asked for."""
    source = with_stamps(with_gravity(open_source(path, settings)))
    if source.topic is None:
        source = one_device(source, settings.topic)
    return source if settings.topic is None or source.topic is not None else source.group(settings.topic)


def _of_rows(source: Source, selection: Selection, settings: RecordingSettings) -> tuple[Source, Selection]:
    """Return the rows of one device, where the user says that those of several alternate, or the samples counted.

    A counter of samples numbers those at a rate that the user gives.
    """
    if settings.rows is not None:
        places = [selection.places[k] for k in selection.inertial]
        return every_row(source, places, settings.rows), selection
    if not settings.rate_hz:
        return source, selection
    counters = tuple(selection.names.index(name) for name in selection.assignment.counters)
    counted = with_counted(source, counters, settings.rate_hz)
    if counted is None:
        return source, selection
    source, counter = counted
    names = (*(SKIP if k == counter else name for k, name in enumerate(selection.names)), source.names[-1])
    return source, replace(selection, names=names, stamp=len(names) - 1, rate=None)


def _recognised(source: Source, settings: RecordingSettings) -> Recording:
    """Name, load, convert and turn the columns of a file."""
    selection = _selected(source, settings)
    source, selection = _of_rows(source, selection, settings)
    block, raw = source.load(selection.places, selection.stamp)
    columns = list(selection.assignment.columns)
    if raw is not None and not (kept := of_sensor(block, raw)).all():
        block, raw = block[:, kept], raw[kept]
        rest = f"{np.count_nonzero(~kept)} rows without stamp and sample: left out"
        source = replace(source, place=_place_of(source, np.flatnonzero(kept)), notes=(*source.notes, rest))
    clear_vanishing(block)
    filled = _filled(_without_filler(block, selection), source)
    sorted_rows = None if raw is None else by_stamps(raw)
    if sorted_rows is not None:
        order, sentence = sorted_rows
        block, raw = block[:, order], raw[order]
        source = replace(source, place=_place_of(source, order), notes=(*source.notes, sentence))
    _require_sound(source, dict(zip(columns, block, strict=True)), raw)
    parts = [(block[:, rows], None if raw is None else raw[rows]) for rows in stretches_of(block.shape[1])]
    _require_one_device(source, parts, selection, settings)
    table = pd.DataFrame(block.T, columns=columns, copy=False)
    excerpt = dict(zip(columns, samples.excerpt(list(block)).T, strict=True))
    require_one_scale(excerpt)
    if source.canonical:
        said = () if sorted_rows is None else source.notes
        return Recording(source.path, table.set_index(pd.Index(raw, name=TIME)), said, place=source.place)
    found = _conversion(selection, excerpt, raw, settings)
    time = found.apply(dict(zip(columns, block, strict=True)), raw)
    said = (*selection.said, *found.recognised, *_unread(selection), *_left_out(selection), *filled)
    if said or not selection.assignment.contract or settings.columns or source.notes:
        said = (f"{found.rate_hz:.5g} Hz", f"{len(time):,} samples".replace(",", " "), *source.notes, *said)
    table = table.drop(columns=[*found.without]).set_index(pd.Index(time, name=TIME))
    return Recording(source.path, table, said, found.weightless, found.frame, source.place, _ros_topic(source))


def _ros_topic(source: Source) -> str | None:
    """Return the topic of ROS from which the columns are, a name that begins with a slash."""
    one = source.topic or ""
    return one if one.startswith("/") and " " not in one else None


def _place_of(source: Source, order: np.ndarray) -> Callable[[int], str]:
    """Return how the place of a row in the file follows from its number among sorted rows."""
    return lambda row: source.place(int(order[row]))


def _without_filler(block: np.ndarray, selection: Selection) -> np.ndarray:
    """Write NaN where all six axes hold one number, shape (columns, n); return these rows."""
    return without_filler(block, selection.inertial) if len(selection.inertial) == len(AXES) else np.empty(0, int)


def _filled(rows: np.ndarray, source: Source) -> tuple[str, ...]:
    """Return what became of rows of one number, a sentence; none where there are none."""
    if not len(rows):
        return ()
    return (f"{len(rows)} rows of one number on all axes, first at {source.place(int(rows[0]))}: lost",)


def _require_sound(source: Source, columns: dict[str, np.ndarray], raw: np.ndarray | None) -> None:
    """Raise a LogError unless there are two rows, their numbers are in range, and some stamps increase."""
    count = min(map(len, columns.values()))
    if count < 2:
        raise LogError(source.path, "rows", "at least 2 samples", str(count))
    require_range(({} if raw is None else {TIME: raw}) | columns, source.path, source.place)
    _require_clock(source, raw)


def _require_clock(source: Source, raw: np.ndarray | None) -> None:
    """Raise a LogError unless some stamps increase."""
    if raw is None or stamps.step_of(raw) > 0:
        return
    known = raw[np.isfinite(raw.astype(float))]
    expected = "a time that increases (--rate HZ takes the rows as even, --columns time=NAME another column as stamps)"
    found = "no stamp above the one before (rows from the last to the first? sort them by their stamps)"
    if len(known) and (known == known[0]).all():
        found = f"{known[0]:.10g} in all {len(raw)} rows (a clock that was not set, or digits lost in a spreadsheet?)"
    raise LogError(source.path, "stamps", expected, found)


def _selected(source: Source, settings: RecordingSettings) -> Selection:
    names = _names(source, settings)
    assignment = _assigned(names, source)
    stamp = stamp_column.find(source, names, assignment, settings.rate_hz)
    given = (settings.rate_hz, "the option") if settings.rate_hz else source.rate
    whole = stamp is not None and source.names[stamp] in source.whole
    said = stamp_column.sentences(source, names, assignment, stamp, settings.rate_hz)
    return Selection(
        tuple(names), assignment, stamp, given if stamp is None else None, whole, stamp in source.clocks, said
    )  # fmt: skip


def _conversion(selection: Selection, excerpt: dict, raw: np.ndarray | None, settings: RecordingSettings) -> Conversion:
    if selection.whole and (np.abs(raw) < LARGEST_WHOLE).all() and (raw == np.rint(raw)).all():
        raw = raw.astype(np.int64)
    clock = selection.stamp_name or selection.rate
    return conversion(excerpt, raw, clock, selection.assignment, settings, selection.clock)


def _require_one_device(source: Source, stretches: list, selection: Selection, settings: RecordingSettings) -> None:
    """Raise a LogError where the rows of stretches, columns and stamps of each, are of devices that alternate."""
    if not source.canonical and settings.rows != ALL:
        samples = [columns[selection.inertial].T for columns, _ in stretches]
        require_one_device(source, samples, [raw for _, raw in stretches])


def _stretches(source: Source, selection: Selection) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """Return stretches spread over a file: their columns, shape (columns, rows), and their stamps, shape (rows,).

    Samples beyond the range of any device, which are refused when their part is read, are NaN.
    """
    due = list(np.linspace(0, source.rows, samples.STRETCHES, endpoint=False))
    kept, row = [], 0
    for batch in source.all_batches(selection.places, selection.stamp):
        row += len(batch[0])
        if due and row > due[0]:
            kept.append([values[: samples.STRETCH].copy() for values in batch])
            due = [one for one in due if one >= row]
    if not kept:
        raise LogError(source.path, "rows", "at least 2 samples", "0")
    stamps = [None if selection.stamp is None else one.pop() for one in kept]
    blocks = [within_range(np.array(one, float)) for one in kept]
    for block in blocks:
        clear_vanishing(block)
        _without_filler(block, selection)
    return list(zip(blocks, stamps, strict=True))


def _parts(source: Source, selection: Selection, found: Conversion) -> Iterator[pd.DataFrame]:
    columns, row = list(selection.assignment.columns), 0
    for batch in source.all_batches(selection.places, selection.stamp):
        raw = None if selection.stamp is None else batch.pop()
        block = np.array(batch, float)
        clear_vanishing(block)
        _without_filler(block, selection)
        values = dict(zip(columns, block, strict=True))
        stamped = {} if raw is None else {TIME: raw}
        require_range(stamped | values, source.path, lambda number, first=row: source.place(first + number))
        kept = slice(None) if raw is None else of_sensor(block, raw)
        time = raw if source.canonical else found.apply(values, raw, row)
        row += block.shape[1]
        values = {name: column[kept] for name, column in values.items() if name not in found.without}
        yield pd.DataFrame(values, index=pd.Index(time[kept], name=TIME))


def _names(source: Source, settings: RecordingSettings) -> list[str]:
    """Return the name of each column, by the user or by the file."""
    if settings.columns:
        return list(asked(column_names.chosen, source.heading, source.names, settings.columns))
    if not any(source.names):
        expected = "a header, or a name for each column (--columns time,gyro_x,... with - for one that is not read)"
        raise LogError(source.path, source.heading, expected, f"{len(source.names)} columns without names")
    return list(source.names)


def _assigned(names: list[str], source: Source) -> Assignment:
    """Return which columns are read; LogError where none is of an inertial sensor, or one is there twice."""
    assignment = asked(column_names.assign, source.heading, list(dict.fromkeys(names)))
    read = (*assignment.columns.values(), *assignment.times)
    repeated = [name for name in read if names.count(name) > 1]
    if repeated:
        expected = "every column once (--columns decides)"
        raise LogError(source.path, source.heading, expected, f"{', '.join(repeated)} more than once")
    if not set(AXES) & set(assignment.columns):
        expected = "columns of gyroscopes or accelerometers (--columns names them)"
        raise LogError(source.path, source.heading, expected, column_names.nearest(name for name in names if name))
    return assignment


def _unread(selection: Selection) -> tuple[str, ...]:
    """Return what looks like axes of a sensor that are not read, sentences."""
    alike = column_names.unread([name for name in selection.names if name], selection.assignment)
    return tuple(
        f"{quantity} lacks axes, though {', '.join(names[:SHOWN])} may be some (--columns with a name for each column)"
        for quantity, names in alike.items()
    )


def _left_out(selection: Selection) -> tuple[str, ...]:
    read = {*selection.assignment.columns.values(), selection.stamp_name}
    others = [name for name in selection.names if name and name != SKIP and name not in read]
    if not others:
        return ()
    more = f" and {len(others) - SHOWN} more" if len(others) > SHOWN else ""
    return (f"left out {', '.join(others[:SHOWN])}{more}",)
