"""Samples numbered by a counter in the file, where a rate is given and there are no stamps: lost samples stay gaps."""

from dataclasses import replace

import numpy as np

from imugap.io.formats.source import Source
from imugap.log import LogError

WIDTHS = (2**8, 2**16, 2**32)
"""Numbers after which binary counters begin anew; another one does after its largest."""
MOSTLY, ROWS = 0.6, 2
"""Share of the steps of a counter of samples that are 1, and fewest rows."""
LONGEST = 50
"""Samples per row above which a counter is of something else."""
NAME = "counted time [s]"
"""Name of the column of stamps that follow from a counter."""


def with_counted(source: Source, counters: tuple[int, ...], rate_hz: float) -> tuple[Source, int] | None:
    """Return a source with stamps that follow from a counter of samples as its last column, and the counter.

    Of the columns at the positions ``counters`` the first that counts samples is taken, at a rate [Hz]; None where none
    does.
    """
    for place in counters:
        try:
            values = source.load([place], None)[0][0]
        except LogError:
            continue
        found = numbers(values)
        if found is not None:
            return _joined(source, place, found, rate_hz), place
    return None


def numbers(counter: np.ndarray) -> np.ndarray | None:
    """Return the number of each sample, shape (n,), from 0, by a counter that may begin anew; None where it is none."""
    if len(counter) < ROWS or not (counter == np.rint(counter)).all() or counter.min() < 0:
        return None
    steps = np.diff(counter)
    if (steps < 0).any():
        widths = [width for width in (*WIDTHS, counter.max() + 1) if width > counter.max()]
        steps = steps % next((width for width in widths if _is_whole(counter, width)), widths[0])
    total = steps.sum()
    if np.mean(steps == 1) < MOSTLY or total > LONGEST * len(counter):
        return None
    return np.r_[0.0, np.cumsum(steps)]


def _is_whole(counter: np.ndarray, width: float) -> bool:
    """Return whether a counter that begins anew after ``width`` does so with few samples lost."""
    steps = np.diff(counter)
    return bool(np.median(steps[steps < 0] % width) <= LONGEST)


def _joined(source: Source, place: int, found: np.ndarray, rate_hz: float) -> Source:
    count, lost = len(source.names), int(found[-1]) + 1 - len(np.unique(found))

    def batches(columns):
        row = 0
        for values in source.batches([place, *(k for k in columns if k != count)]):
            others, end = iter(values[1:]), row + len(values[0])
            yield [found[row:end] / rate_hz if k == count else next(others) for k in columns]
            row = end

    note = f"samples counted by {source.names[place]} at {rate_hz:g} Hz from the option, {lost} lost"

    def texts(column):
        return source.texts(column) if column < count else (one.astype(str) for (one,) in batches([count]))

    return replace(source, names=(*source.names, NAME), batches=batches, notes=(*source.notes, note), cells=texts)
