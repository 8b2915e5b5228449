"""Rows of a table as read: in order of time, and numbers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.log import LogError


def advances(time: np.ndarray) -> np.ndarray:
    """Return the mask of stamps, shape (n,), that are finite and exceed all stamps before them."""
    time = np.where(np.isfinite(time), time, np.nan)
    return time > np.fmax.accumulate(np.concatenate([[-np.inf], time[:-1]]))


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


def _counted(rows: np.ndarray) -> str:
    return f"{len(rows)} such row{'s' if len(rows) > 1 else ''}"
