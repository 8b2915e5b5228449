"""One door for stamps and samples: from the table of a file to the true samples of each axis, with gaps as gaps.

:func:`regular` undoes what is certain (rows written twice, counters that wrap, packets, repeated samples), marks what
is lost as NaN, states all of it in sentences, and raises a LogError where no number could be right.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
import pandas as pd
from scipy.special import bdtrc

from imugap.integrity import rest
from imugap.integrity.clock_reset import row_number
from imugap.integrity.row_clock import every_row_is_a_sample, rate_change
from imugap.integrity.scales import Scale, loud_axis
from imugap.integrity.timestamps import Stamps, stamps
from imugap.integrity.true_sampling import KNOTS, REPEATED, TrueSampling, held, interpolated
from imugap.log import ACCEL, COLUMNS, GYRO, TIME, LogError, axes
from imugap.numerics.samples.runs import runs_of

IMPROBABLE = 1e-6
"""Probability of equal rows by chance below which they are written twice."""
OWN = 0.2
"""Share of the rows of an axis that another lacks, from which both are streams of their own."""
CLIPPED = 0.5
"""Share of samples at one end of the range from which an axis is of no use."""
OTHER_NOISE = 0.17
"""Log ratio of the noise of two parts, half of that which half the rate makes in white noise, from which it differs."""
HEAVY = 3.0
"""Norm of the specific force [m/s^2] above which gravity is in it."""
SHARED = 0.6
"""Share of the rows of two axes that hold both, above which they may have stamps in common and values lost."""
BRIEF = 10
"""Fewest successive rows in which all axes are zero that are no coincidence."""


class Fault(Enum):
    """Kind of a fault of stamps or samples; the value is its name in a sentence."""

    TWICE = "rows written twice"
    LOST_VALUES = "lost values"
    """Values that are not finite, or rows without power."""
    DEAD = "axes without use"
    STREAMS = "axes with stamps of their own"
    RESET = "a clock that was reset"
    """Clock that wraps or is set back."""
    UNEVEN = "uneven stamps"
    """Stamps that do not show the clock."""
    LOST = "lost samples"
    """Samples without a row."""
    HELD = "repeated values"
    INTERPOLATED = "interpolated values"
    """Values between slower samples."""
    LOUD = "an axis of another noise"
    """Noise at rest that is far from that of both other axes of a sensor, as of another scale."""


NEIGHBOURS = 1.5
"""Distance of samples [intervals] above which one between them is lost."""


@dataclass(frozen=True)
class Remark:
    """Sentence on a fault: what, how many, where first, and what is done about it."""

    fault: Fault
    text: str

    def __str__(self) -> str:
        """Return the sentence."""
        return self.text


@dataclass(frozen=True, eq=False)
class AxisSamples:
    """True samples of one axis: ``values``, shape (n,), NaN where lost, every ``interval`` [s] from ``begin`` [s]."""

    values: np.ndarray
    interval: float
    begin: float

    @property
    def lost(self) -> np.ndarray:
        """Return the mask of lost samples, shape (n,)."""
        return np.isnan(self.values)


@dataclass(frozen=True, eq=False)
class Regular:
    """Log on an even clock.

    Attributes
    ----------
    source
        Name of the file.
    log
        All columns at every sample of the clock of the rows, NaN where lost; the table as read where nothing is.
    interval
        Interval of that clock [s].
    samples
        True samples of each axis that has any; their interval is longer than that of the rows where values repeat.
    unusable
        Axes without use, each with a sentence.
    remarks
        Faults of stamps and samples, in the order of the stages.
    streams
        Axes with stamps of their own, one table for each clock, with its interval [s]; ``log`` is one of them.
    """

    source: str
    log: pd.DataFrame
    interval: float
    samples: dict[str, AxisSamples]
    unusable: dict[str, str]
    remarks: tuple[Remark, ...]
    streams: tuple[tuple[pd.DataFrame, float], ...]

    @property
    def lost(self) -> np.ndarray:
        """Return the mask of the samples of the clock that no axis has, shape (n,)."""
        return self.log[list(axes(self.log))].isna().all(axis=1).to_numpy()

    @property
    def measured(self) -> pd.DataFrame:
        """Return the samples that all axes have, at their times on the even clock; LogError without one of the axes.

        Where all axes repeat their values alike, one row of each value. Axes with stamps of their own are interpolated
        to the stamps of the fastest ones.
        """
        if self.unusable:
            raise LogError(self.source, "columns", "values on every axis", "; ".join(self.unusable.values()))
        if len(self.streams) > 1:
            return _joined(self.streams)
        names = list(axes(self.log))
        rows = self.log.dropna(subset=names)
        slowest = min(one.interval for one in self.samples.values()) / self.interval
        if slowest < REPEATED or slowest > KNOTS:
            return rows
        place = np.rint((rows.index - self.log.index[0]) / self.interval).astype(int)
        return rows[np.r_[True, np.diff((place / slowest).astype(int)) > 0]]


def regular(table: pd.DataFrame, source: str = "log", place: Callable[[int], str] = row_number) -> Regular:
    """Return the log on an even clock.

    Parameters
    ----------
    table
        Index ``time`` [s], columns of a log (SI); stamps may be missing, repeated or reversed, values not finite.
    source, place
        Name of the file for errors, and the location of a row in it.
    """
    names = list(axes(table))
    if not names:
        raise LogError(source, "columns", "at least one inertial axis", ", ".join(map(str, table.columns)) or "none")
    once, twice = _once(table, place)
    finite, off, holes = _finite(once, place)
    unusable = _unusable(finite)
    streams = _streams(finite.drop(columns=list(unusable)) if unusable else finite)
    holes += _lost_values(streams, finite, off, place)
    try:
        clocks = [_clock(stream, place) for stream in streams]
    except LogError as error:
        raise LogError(source, error.place, error.expected, error.found) from error
    whole = [_on_clock(*pair) for pair in zip(streams, clocks, strict=True)]
    log, clock = max(zip(whole, clocks, strict=True), key=lambda pair: pair[0].shape[1])
    samples, slower = {}, []
    for one, of in zip(whole, clocks, strict=True):
        found, remarks = _true_samples(one, of.interval)
        samples |= found
        slower += remarks
    apart = [
        f"{', '.join(axes(one))}: {1 / of.interval:.4g} Hz on stamps of their own"
        for one, of in zip(whole, clocks, strict=True)
    ]
    remarks = (
        *twice, *holes, *(Remark(Fault.DEAD, text) for text in unusable.values()),
        *(Remark(Fault.STREAMS, text) for text in apart if len(whole) > 1),
        *dict.fromkeys(remark for of in clocks for remark in _of_clock(of)), *slower,
        *_of_noise(samples, log, clock.interval),
    )  # fmt: skip
    ordered = {name: samples[name] for name in names if name in samples}
    intervals = [of.interval for of in clocks]
    return Regular(source, log, clock.interval, ordered, unusable, remarks, tuple(zip(whole, intervals, strict=True)))


def _joined(streams: Sequence[tuple[pd.DataFrame, float]]) -> pd.DataFrame:
    """Return the samples of streams, each a table with its interval [s], at the stamps of the fastest."""
    fastest, *others = sorted(streams, key=lambda one: one[1])
    joined = fastest[0].dropna(subset=list(axes(fastest[0])))
    for stream, interval in others:
        joined = joined.join(_at(joined.index.to_numpy(), stream, interval)).dropna(subset=list(axes(stream)))
    return joined[[name for name in COLUMNS if name in joined]]


def _at(time: np.ndarray, stream: pd.DataFrame, interval: float) -> pd.DataFrame:
    """Return a stream, linear between its samples, at those of times [s], shape (n,), that it covers without a gap."""
    known = stream.dropna(subset=list(axes(stream)))
    stamps = known.index.to_numpy()
    after = np.searchsorted(stamps, time).clip(1, len(stamps) - 1)
    apart = stamps[after] - stamps[after - 1] > NEIGHBOURS * interval
    outside = (time < stamps[0]) | (time > stamps[-1])
    values = {name: np.interp(time, stamps, known[name]) for name in known}
    return pd.DataFrame(values, index=pd.Index(time, name=TIME))[~(apart | outside)]


def _once(table: pd.DataFrame, place: Callable[[int], str]) -> tuple[pd.DataFrame, list[Remark]]:
    """Return the table without rows written twice, stamp and all values equal, and a sentence if there are any.

    Neighbours of one stamp are new samples if they are equal no more often than neighbours of different stamps.
    """
    time = table.index.to_numpy(float)
    if np.all(np.diff(time) > 0):
        return table, []
    again = table.reset_index().duplicated().to_numpy()
    if not again.any():
        return table, []
    values = table.to_numpy(float)
    same = np.all((values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1])), axis=1)
    stamped = np.diff(time) == 0
    chance = (np.count_nonzero(same & ~stamped) + 1) / (np.count_nonzero(~stamped) + 2)
    trials = max(np.count_nonzero(stamped), np.count_nonzero(again))
    if bdtrc(np.count_nonzero(again) - 1, trials, chance) > IMPROBABLE:
        return table, []
    count, first = np.count_nonzero(again), int(np.argmax(again))
    text = f"{counted(count, 'row')} written twice, first at {place(first)}: left out"
    return table[~again], [Remark(Fault.TWICE, text)]


def _finite(table: pd.DataFrame, place: Callable[[int], str]) -> tuple[pd.DataFrame, np.ndarray, list[Remark]]:
    """Return the table with NaN for infinite values and for rows without power, these, and a sentence on them."""
    infinite = np.isinf(table.to_numpy(float))
    off = without_power(table)
    remarks = []
    if off.any():
        first = int(np.argmax(off))
        text = f"{counted(int(off.sum()), 'row')} zero on all axes, first at {place(first)}: lost"
        remarks.append(Remark(Fault.LOST_VALUES, text))
    return powered(table.mask(infinite) if infinite.any() else table, off), off, remarks


def _lost_values(
    streams: Sequence[pd.DataFrame], table: pd.DataFrame, off: np.ndarray, place: Callable[[int], str]
) -> list[Remark]:
    """Return a sentence on the values of each axis that are empty or not finite, in the rows of its stream.

    ``off``, shape (n,), are the rows of ``table`` without power.
    """
    lost, first = {}, []
    for stream in streams:
        rows = np.ones(len(table), bool) if len(streams) == 1 else _has_values(table, axes(stream))
        for name in axes(stream):
            missing = np.flatnonzero(table[name].isna().to_numpy() & rows & ~off)
            lost |= {name: len(missing)} if len(missing) else {}
            first += missing[:1].tolist()
    if not lost:
        return []
    each = ", ".join(f"{name} {count}" for name, count in lost.items())
    return [Remark(Fault.LOST_VALUES, f"values empty or not finite, first at {place(min(first))}: {each}: lost")]


def _has_values(table: pd.DataFrame, names: Sequence[str]) -> np.ndarray:
    """Return the rows of a table, shape (n,), in which any of some columns has a value."""
    return table[list(names)].notna().any(axis=1).to_numpy()


def powered(table: pd.DataFrame, off: np.ndarray) -> pd.DataFrame:
    """Return the table with NaN on the axes of the rows ``off``, shape (n,), which hold no samples."""
    return table.mask(off[:, None] & np.isin(table.columns, axes(table))) if off.any() else table


def without_power(table: pd.DataFrame) -> np.ndarray:
    """Return the mask of rows, shape (n,), in which all axes are exactly zero.

    A specific force of zero is no reading at rest. Without gravity in the log many successive rows count, on axes that
    are zero nowhere else.
    """
    names = list(axes(table))
    off = np.logical_and.reduce([table[name].to_numpy(float) == 0 for name in names])
    if not off.any():
        return off
    if set(ACCEL) <= set(names) and np.sqrt(sum(table[name] ** 2 for name in ACCEL)).median() > HEAVY:
        return off
    brief = np.diff(runs_of(off)) < BRIEF
    if off.mean() > CLIPPED or brief.any():
        return np.zeros(len(off), bool)
    return off


def _unusable(table: pd.DataFrame) -> dict[str, str]:
    """Return the axes without use, each with a sentence."""
    found = {}
    for name in axes(table):
        values = table[name].to_numpy(float)
        values = values[~np.isnan(values)]
        if not len(values):
            found[name] = f"{name}: no values"
        elif values.min() == values.max():
            found[name] = f"{name}: {values[0] + 0.0:.6g} throughout, no noise can be seen"
        else:
            ends = [float(end) for end in (values.min(), values.max()) if np.mean(values == end) > CLIPPED]
            beyond = [end for end in ends if len(np.unique(values)) > 2 and abs(end) >= np.abs(values).max()]
            if beyond and name in GYRO and abs(np.median(values)) == abs(beyond[0]):
                found[name] = f"{name}: at its end of range, {beyond[0]:.6g}, for most of the time"
    return found


def _streams(table: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the table in parts with stamps of their own: axes that have their values in the same rows.

    Rows of a part without any value are left out; a temperature goes with the first part.
    """
    names = list(axes(table))
    groups: list[list[str]] = []
    known = {name: table[name].notna().to_numpy() for name in names}
    for name in names:
        for group in groups:
            if _are_together(known[group[0]], known[name]):
                group.append(name)
                break
        else:
            groups.append([name])
    others = [name for name in table if name not in names]
    if len(groups) <= 1:
        return [table]
    parts = [table[[*group, *(others if group is groups[0] else [])]] for group in groups]
    return [part[part[group].notna().any(axis=1)] for part, group in zip(parts, groups, strict=True)]


def _are_together(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two axes, which have values in these rows, shape (n,), have the same stamps.

    A slower sensor has its values in rows that are evenly spaced; values lost at random are not.
    """
    rows = max(np.count_nonzero(one | other), 1)
    if np.count_nonzero(one != other) < OWN * rows:
        return True
    if np.count_nonzero(one & other) < SHARED * rows:
        return False
    fewer = one if np.count_nonzero(one) < np.count_nonzero(other) else other
    return not every_row_is_a_sample(np.flatnonzero(fewer[one | other]).astype(float), 0.0)


def _clock(table: pd.DataFrame, place: Callable[[int], str]) -> Stamps:
    """Return the clock of a table; LogError where its rate changes to a multiple and its noise does, too.

    At the same noise, samples are lost; a device that is set to another rate has other noise.
    """
    time = table.index.to_numpy(float)
    clock = stamps(time, place)
    change = rate_change(clock.ordered, clock.interval)
    if change is None or not clock.lost.any():
        return clock
    ratios = []
    for name in axes(table):
        values = table[name].to_numpy(float)
        before, after = (np.nanmedian(np.abs(np.diff(part))) for part in (values[: change.row], values[change.row :]))
        ratios.append(after / before if before > 0 else 1.0)
    if abs(np.log(np.median(ratios))) > OTHER_NOISE:
        change.refuse(place)
    return clock


def _on_clock(table: pd.DataFrame, clock: Stamps) -> pd.DataFrame:
    """Return a table at every sample of its clock, NaN where lost; itself where its rows are the samples."""
    if clock.even and clock.count == len(table):
        return table
    values = np.full((clock.count, table.shape[1]), np.nan)
    values[clock.slots[clock.kept]] = table.to_numpy(float)[clock.kept]
    return pd.DataFrame(values, columns=table.columns, index=pd.Index(clock.grid, name=TIME))


def _of_clock(clock: Stamps) -> list[Remark]:
    """Return a remark for each reset of a clock, for stamps that do not show it, and for lost samples."""
    rate = f"{1 / clock.interval:.6g} Hz"
    remarks = [Remark(Fault.RESET, text) for text in clock.remarks]
    if not clock.even:
        text = f"stamps uneven or repeated, every row a sample: {rate} by their mean"
        remarks.append(Remark(Fault.UNEVEN, text))
    late = int(np.count_nonzero(~clock.advancing))
    if clock.even and late:
        text = f"{counted(late, 'stamp')} missing or out of order: the rows are taken in their order"
        remarks.append(Remark(Fault.UNEVEN, text))
    lost = int(np.count_nonzero(clock.lost))
    if lost:
        first, end = max(runs_of(clock.lost), key=lambda run: run[1] - run[0])
        gap, before = (end - first) * clock.interval, clock.grid[max(first - 1, 0)]
        where = f"the longest gap {gap:.3g} s after {before:.10g} s"
        text = f"{lost} of {clock.count} samples lost at {rate} ({100 * lost / clock.count:.2g} %), {where}"
        remarks.append(Remark(Fault.LOST, text))
    double = len(clock.slots) - int(np.count_nonzero(clock.kept))
    if double:
        remarks.append(Remark(Fault.TWICE, f"{counted(double, 'row')} between two samples of the clock: left out"))
    return remarks


def _true_samples(log: pd.DataFrame, interval: float) -> tuple[dict[str, AxisSamples], list[Remark]]:
    """Return the true samples of each axis of a log on an even clock, and a sentence for each slower sensor."""
    begin, found, remarks = float(log.index[0]), {}, []
    for triad in (GYRO, ACCEL):
        names = [name for name in triad if name in log]
        if not names:
            continue
        slow = held(_known(log[names].to_numpy(float)))
        if slow is not None:
            remarks.append(_slower(names, slow, interval, "repeat"))
        between: dict[float, list[str]] = {}
        for name in names:
            values = log[name].to_numpy(float)
            sampling = slow or interpolated(values)
            if sampling is not None and slow is None:
                between.setdefault(round(sampling.rows, 3), []).append(name)
            one = (values, interval) if sampling is None else sampling.samples(values, interval)
            found[name] = AxisSamples(*one, begin)
        remarks += [
            _slower(some, TrueSampling(rows, True), interval, "are interpolated") for rows, some in between.items()
        ]
    return found, remarks


def _of_noise(samples: dict[str, AxisSamples], log: pd.DataFrame, interval: float) -> list[Remark]:
    """Return the axis of each sensor whose noise, while the others are at rest, is that of another scale."""
    remarks = []
    for triad in (GYRO, ACCEL):
        loud = loud_axis({axis: Scale.of(samples[axis].values) for axis in triad if axis in samples})
        if loud is not None and rest.motion(log.drop(columns=loud.name, errors="ignore"), interval).at_rest:
            text = f"{loud.name}: noise {loud.times} that of the two others; has it another scale? Then rescale it"
            remarks.append(Remark(Fault.LOUD, text))
    return remarks


def _known(columns: np.ndarray) -> np.ndarray:
    """Return the rows without NaN of ``columns``, shape (n, axes)."""
    lost = np.isnan(columns).any(axis=1)
    return columns[~lost] if lost.any() else columns


def _slower(names: list[str], sampling: TrueSampling, interval: float, how: str) -> Remark:
    rate = f"{1 / (sampling.rows * interval):.4g} Hz"
    used = "means over longer times are used" if sampling.interpolated else "one of each is used"
    fault = Fault.INTERPOLATED if sampling.interpolated else Fault.HELD
    return Remark(fault, f"{', '.join(names)}: values {how} between samples at {rate}, {used}")


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless it is one."""
    ending = "" if number == 1 else "es" if noun.endswith("ch") else "s"
    return f"{number} {noun}{ending}"
