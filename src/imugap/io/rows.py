"""Rows of a table as read: in order of time, and numbers."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.log import TIME, LogError

FEWEST = 32
"""Fewest rows that are sorted."""
EVEN, NEAR = 0.95, 0.1
"""Share of the steps of sorted stamps that are whole numbers of intervals, and how near, of an even clock."""
MIXED, LOCAL = 0.02, 64
"""Share of steps back of rows that are out of order everywhere, and rows by which others are displaced: a few rows that
are displaced by more are another run."""
LONGEST = 1e12
"""Longest step of sorted stamps, in intervals of an even clock."""
LARGEST_SAMPLE, LARGEST_STAMP = 1e12, 1e20
"""Largest magnitude of a sample and of a stamp, in any unit: beyond any word of a device, and with powers in range."""
SMALLEST_SAMPLE = 1e-30
"""Samples of a smaller magnitude are zero: what a digital filter leaves that runs on behind its input."""


def advances(time: np.ndarray) -> np.ndarray:
    """Return the mask of stamps, shape (n,), that are finite and exceed all stamps before them."""
    time = np.where(np.isfinite(time), time, np.nan)
    return time > np.fmax.accumulate(np.concatenate([[-np.inf], time[:-1]]))


def by_stamps(raw: np.ndarray) -> tuple[np.ndarray, str] | None:
    """Return the order of rows by their stamps, shape (n,), and a sentence; None where they are to stay as they are.

    Rows that are out of order are sorted where the stamps, sorted, are those of an even clock, each there once: stamps
    that are uneven themselves are not. Rows that go back throughout are read from the last to the first.
    """
    if len(raw) < FEWEST or not np.isfinite(raw).all():
        return None
    steps = np.diff(raw)
    back = np.count_nonzero(steps < 0)
    if not back:
        return None
    if not (steps > 0).any():
        return np.arange(len(raw))[::-1], "rows from the last to the first, as their stamps go back"
    order = np.argsort(raw, kind="stable")
    sorted_steps = np.diff(raw[order])
    interval = np.median(sorted_steps)
    if sorted_steps.min() <= 0 or sorted_steps.max() / LONGEST > interval:
        return None
    intervals = sorted_steps / interval
    even = (np.rint(intervals) > 0) & (np.abs(intervals - np.rint(intervals)) < NEAR)
    moved = np.abs(order - np.arange(len(raw)))
    if even.mean() < EVEN or (back < MIXED * len(raw) and moved.max() > LOCAL):
        return None
    return order, f"{np.count_nonzero(moved)} rows out of order: sorted by their stamps"


def require_order(table: pd.DataFrame, path: Path, place: Callable[[int], str]) -> None:
    """Raise a LogError unless every stamp is finite and exceeds all before; ``place`` is that of a row in the file."""
    time = table.index.to_numpy()
    late = np.flatnonzero(~advances(time))
    if len(late):
        row = int(late[0])
        found = f"{time[row]} after {time[row - 1]}" if row else f"{time[row]}"
        raise LogError(path, f"{place(row)}, column time", "a time that increases", f"{found} ({_counted(late)})")


def require_numbers(table: pd.DataFrame, path: Path, place: Callable[[int], str]) -> None:
    """Raise a LogError unless every sample is finite; ``place`` is that of a row in the file."""
    rows, columns = np.nonzero(~np.isfinite(table.to_numpy()))
    if len(rows):
        found = f"{table.iat[rows[0], columns[0]]} ({_counted(np.unique(rows))})"
        raise LogError(path, f"{place(int(rows[0]))}, column {table.columns[columns[0]]}", "a finite number", found)


def of_sensor(block: np.ndarray, raw: np.ndarray) -> np.ndarray:
    """Return the mask of rows, shape (n,), with a stamp or a sample: the others hold those of another sensor.

    Parameters
    ----------
    block
        Samples, shape (columns, n), NaN where there is none.
    raw
        Stamps, shape (n,).
    """
    return np.isfinite(raw) | np.isfinite(block).any(axis=0)


def without_filler(block: np.ndarray, inertial: Sequence[int]) -> np.ndarray:
    """Write NaN where all axes hold one number but zero, as loggers write it for no sample; return these rows.

    Parameters
    ----------
    block
        Samples in the units of the file, shape (columns, n).
    inertial
        Columns of the inertial axes; gyroscopes and accelerometers, of which no sample has one number on all.
    """
    first = block[inertial[0]]
    filler = (first != 0) & np.logical_and.reduce([block[k] == first for k in inertial[1:]])
    rows = np.flatnonzero(filler)
    block[:, rows] = np.nan
    return rows


def require_range(columns: Mapping[str, np.ndarray], path: Path, place: Callable[[int], str]) -> None:
    """Raise a LogError unless every finite sample and stamp is within the range of any device, in any unit."""
    for name, values in columns.items():
        largest = LARGEST_STAMP if name == TIME else LARGEST_SAMPLE
        beyond = np.flatnonzero(np.isfinite(values) & (np.abs(values) > largest))
        if len(beyond):
            found = f"{values[beyond[0]]:g} ({_counted(beyond)})"
            expected = f"a number of at most {largest:g} either way"
            raise LogError(path, f"{place(int(beyond[0]))}, column {name}", expected, found)


def clear_vanishing(block: np.ndarray) -> None:
    """Write 0 for each sample of a block, shape (columns, n), that is too small for a float to hold its powers."""
    for column in block:
        column[np.abs(column) < SMALLEST_SAMPLE] = 0.0


def within_range(values: np.ndarray) -> np.ndarray:
    """Return samples, NaN where they are beyond the range of any device."""
    return np.where(np.abs(values) <= LARGEST_SAMPLE, values, np.nan)


def _counted(rows: np.ndarray) -> str:
    return f"{len(rows)} such row{'s' if len(rows) > 1 else ''}"
