"""Canonical log: table of one device over time, checked once, at reading.

Index ``time`` [s], strictly increasing; columns from :data:`AXES` (rad/s, m/s^2, in this order, any subset) and
optionally ``temperature`` [degC]. Recordings are read by :mod:`imugap.io.recording`.
"""

import json
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from imugap.atomic import atomic, is_stream

GYRO = ("gyro_x", "gyro_y", "gyro_z")
ACCEL = ("accel_x", "accel_y", "accel_z")
AXES = GYRO + ACCEL
TRIADS = {"gyro": GYRO, "accel": ACCEL}
"""Axes of each kind of sensor."""
TEMPERATURE = "temperature"
TIME = "time"
"""Name of the index, and of the pseudo-axis of clock errors in an error model."""
COLUMNS = (*AXES, TEMPERATURE)
FORMATS = (".parquet", ".csv")
"""Suffixes of the formats in which logs are written."""
MARK = {"imugap": "canonical log"}
"""Attributes of a Parquet log that this package wrote: its columns are what their names say."""
ATTRIBUTES = b"PANDAS_ATTRS"
"""Key under which pandas keeps the attributes of a table in Parquet."""


class LogError(ValueError):
    """Invalid log: source, location, expected and found."""

    def __init__(self, source: str | Path, place: str, expected: str, found: str) -> None:
        """Compose the message from its four parts, which are also attributes."""
        self.source, self.place, self.expected, self.found = str(source), place, expected, found
        super().__init__(f"{source}: {place}: expected {expected}; found {found}")

    @classmethod
    def at(cls, source: str | Path, place: str, error: ValueError) -> "LogError":
        """Return an error of the form ``expectation; found ...`` with the source and the location of it."""
        expected, _, found = str(error).partition("; found ")
        return cls(source, place, expected.removeprefix("expected "), found)

    def __reduce__(self):
        """Support pickling between processes."""
        return type(self), (self.source, self.place, self.expected, self.found)


def from_samples(samples: dict[str, np.ndarray], interval_s: float, start_s: float = 0.0) -> pd.DataFrame:
    """Make a log from evenly sampled columns.

    Parameters
    ----------
    samples
        Column name to array of shape (n,), SI units.
    interval_s
        Sampling interval [s].
    start_s
        Time of the first sample [s].
    """
    count = len(next(iter(samples.values())))
    time = pd.Index(start_s + interval_s * np.arange(count), name=TIME)
    return check(pd.DataFrame({name: samples[name] for name in COLUMNS if name in samples}, index=time))


def check(log: pd.DataFrame, source: str | Path = "log") -> pd.DataFrame:
    """Return ``log`` if it is valid; otherwise raise a :class:`LogError` with the location of the fault."""
    unknown = [name for name in log.columns if name not in COLUMNS]
    if unknown:
        raise LogError(source, "columns", f"a subset of {', '.join(COLUMNS)}", ", ".join(map(str, unknown)))
    if not axes(log):
        raise LogError(source, "columns", f"at least one of {', '.join(AXES)}", "none of them")
    if list(log.columns) != [name for name in COLUMNS if name in log.columns]:
        raise LogError(source, "columns", f"the order {', '.join(COLUMNS)}", ", ".join(log.columns))
    if log.index.name != TIME:
        raise LogError(source, "index", "time [s]", repr(log.index.name))
    if len(log) < 2:
        raise LogError(source, "rows", "at least 2 samples", str(len(log)))
    text = [
        str(name) for name in (TIME, *log.columns) if (log.index if name == TIME else log[name]).dtype.kind not in "iuf"
    ]
    if text:
        raise LogError(source, f"column {text[0]}", "numbers", "text or other objects")
    time = log.index.to_numpy()
    if not np.isfinite(time).all():
        raise LogError(source, f"row {np.argmin(np.isfinite(time))}", "a finite time", f"{time[~np.isfinite(time)][0]}")
    backward = np.flatnonzero(~(np.diff(time) > 0))
    if len(backward):
        row = int(backward[0]) + 1
        raise LogError(source, f"row {row}", "time that increases", f"{time[row]} s after {time[row - 1]} s")
    for name in log.columns:
        bad = np.flatnonzero(~np.isfinite(log[name].to_numpy()))
        if len(bad):
            place = f"row {bad[0]}, column {name}"
            raise LogError(source, place, "a finite number", f"{log[name].iloc[bad[0]]} ({len(bad)} such rows)")
    return log


def axes(log: pd.DataFrame) -> tuple[str, ...]:
    """Return the inertial axes of the log, in canonical order."""
    return tuple(name for name in AXES if name in log.columns)


def triad(axis: str) -> tuple[str, ...]:
    """Return the three axes of the triad of ``axis``."""
    return GYRO if axis in GYRO else ACCEL


def block_means(log: pd.DataFrame, rate_hz: float) -> tuple[dict[str, np.ndarray], float]:
    """Return the means of the columns over blocks, near a lower rate, and their sampling interval [s]."""
    factor = max(round(1 / (interval(log) * rate_hz)), 1)
    whole = log.iloc[: len(log) // factor * factor]
    means = {name: whole[name].to_numpy().reshape(-1, factor).mean(axis=1) for name in whole}
    return means, factor * interval(log)


def interval(log: pd.DataFrame) -> float:
    """Return the sampling interval [s]: the mean step among those within half of the median step.

    Stamps rounded to a third of the interval or finer average out; lost samples (steps of two intervals or more) are
    excluded. Where no step is within half of the median one, it is that.
    """
    steps = np.diff(log.index.to_numpy())
    median = np.median(steps)
    regular = steps[np.abs(steps - median) <= 0.5 * median]
    return float(regular.mean() if len(regular) else median)


def rate(log: pd.DataFrame) -> float:
    """Return the sampling rate [Hz]."""
    return 1.0 / interval(log)


def duration(log: pd.DataFrame) -> float:
    """Return the duration of the log [s], including the interval of the last sample."""
    return float(log.index[-1] - log.index[0]) + interval(log)


def write(log: pd.DataFrame, path: str | Path) -> None:
    """Write the log as Parquet or CSV, by the suffix of ``path``, completely or not at all."""
    write_parts([log], path)


def write_parts(parts: Iterable[pd.DataFrame], path: str | Path) -> int:
    """Write a log that comes in parts as :func:`write` does, in the memory of a part; return the number of its rows."""
    write_table = {".parquet": _write_parquet, ".csv": _write_csv}[require_format(path)]
    with atomic(path) as partial:
        return write_table(parts, partial)


def _write_csv(parts: Iterable[pd.DataFrame], path: Path) -> int:
    rows = 0
    with path.open("w", newline="", encoding="utf-8") as file:
        for part in parts:
            part.to_csv(file, header=not rows)
            rows += len(part)
    return rows


def _write_parquet(parts: Iterable[pd.DataFrame], path: Path) -> int:
    rows, writer = 0, None
    with ExitStack() as stack:
        for part in parts:
            marked = part.copy(deep=False)
            marked.attrs = MARK
            table = pa.Table.from_pandas(marked)
            if writer is None:
                schema = table.schema.with_metadata(table.schema.metadata | {ATTRIBUTES: json.dumps(MARK).encode()})
                writer = stack.enter_context(pq.ParquetWriter(path, schema))
            writer.write_table(table.cast(writer.schema))
            rows += len(part)
    return rows


def require_format(path: str | Path) -> str:
    """Return the suffix of the format in which a log is written: that of ``path``; CSV for a pipe or a device."""
    suffix = Path(path).suffix
    if suffix in FORMATS:
        return suffix
    if not suffix and is_stream(path):
        return ".csv"
    raise LogError(path, "file name", f"one that ends in {' or '.join(FORMATS)}", suffix or "no ending")


def load(path: str | Path, columns: list[str] | None = None) -> pd.DataFrame:
    """Load a canonical Parquet log written by this package, without a check; ``columns`` selects columns."""
    return pd.read_parquet(path, columns=columns)
