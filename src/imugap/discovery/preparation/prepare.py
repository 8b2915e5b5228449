"""Prepare a log: detect irregular stamps, lost, stuck and clipped samples, and rounded values, before any statistics.

These flaws are effects and are named here, since they would disturb all later steps. The result is one evenly sampled
sequence for each axis.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import CubicSpline

from imugap.discovery.finding import Discrepancy, Finding, finding
from imugap.discovery.preparation.cosine_bins import usable_share
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.preparation.shocks import common_shocks
from imugap.effects import CATALOGUE
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel, Effect, Evidence, Role, Stage
from imugap.integrity.regular import powered, without_power
from imugap.integrity.thermometer import smoothed
from imugap.integrity.timestamps import LEAST, ROUNDED, Stamps, stamps
from imugap.log import ACCEL, AXES, GYRO, TEMPERATURE, TIME, LogError, axes
from imugap.model import ErrorModel
from imugap.numerics.samples.runs import runs_of
from imugap.stream import stream

CERTAIN_LOG_P = -1e6
"""Logarithm of the smallest probability reported."""
STAMP_TOLERANCE = 1e-6
"""Largest difference, in intervals, of equal stamps of reference and log."""
MAX_TICK_DEVIATION = 2.1
"""Largest displacement of a stamp, in standard deviations, by the ticks of another clock (uniform: 1.73)."""
MIN_GAP_STEPS = 5.0
"""Minimum step of the stamps of the reference, over the median step, of a gap in it."""
MARGIN = 30
"""Number of samples at either end that the reference has to extend beyond those used: what an effect takes from just
before or after a sample, such as the input of a delay, is then known for all of them."""
MIN_STRAIGHT_SHARE, STRAIGHT_TOLERANCE = 0.3, 1e-3
"""Minimum share of samples on the straight line between their neighbours, within this tolerance over the median
difference of neighbours, of an axis that was interpolated."""
MIN_CHANGES = 20
"""Minimum number of samples that differ from the most frequent value; with fewer, an axis is stuck."""
RECURRENCE, PREDICTED = 4, 1e-9
"""Order of the linear recurrence, and error of its prediction over the range below which an axis has no noise."""
MIN_DISTINCT_SHARE = 0.2
"""Minimum fraction of distinct values for the interpolation test."""
MIN_COMMON_SHARE = 0.5
"""Minimum share of the repeats of an axis that all axes have in common, for a common cause."""


@dataclass(frozen=True, eq=False)
class PreparedLog:
    """A log prepared for discovery.

    Attributes
    ----------
    sequences
        Error of each axis, evenly sampled, time 0 = power-on; flawed samples are replaced and marked. Rounded values
        stay on their lattice (:meth:`imugap.effects.Resolution.found`).
    outputs
        Output of each axis at the same times with its flaws; only lost samples are replaced.
    findings
        The effects found.
    discrepancies
        Where log and start model disagree, in the views ``stamps`` and ``values``, named or not.
    begin
        Stamp of the first sample, which is time zero.
    unusable
        Excluded axes, as places of the view ``values``: at the value of a constant axis, or at the time between the
        true samples of an interpolated axis.
    shocks
        Begin and end of each shock of a device at rest [s]; its samples are replaced as lost ones are.
    confirmed
        Evidence of the effects of the start model on the output of each axis, and on the stamps.
    """

    sequences: dict[str, AxisSequence]
    outputs: dict[str, np.ndarray]
    findings: tuple[Finding, ...]
    discrepancies: tuple[Discrepancy, ...]
    begin: float = 0.0
    unusable: tuple[Discrepancy, ...] = ()
    shocks: tuple[tuple[float, float], ...] = ()
    confirmed: Mapping[str, tuple[Evidence, ...]] = field(default_factory=dict)


def prepare(
    log: pd.DataFrame,
    reference: pd.DataFrame | None = None,
    seed: int = 0,
    start: ErrorModel | None = None,
    catalogue: Sequence[type[Effect]] = tuple(CATALOGUE.values()),
) -> PreparedLog:
    """Detect flaws of a log, and replace flawed samples.

    Parameters
    ----------
    log
        Table as :func:`imugap.io.recording.read` gives it: stamps may be missing, repeated or reversed, values NaN.
    reference
        Error-free log, or None for a log at rest; samples that are not :data:`MARGIN` samples within it are excluded,
        those in its gaps are replaced.
    seed
        Seed of the replacements.
    start
        Start model: its effects are removed but not reported.
    catalogue
        Kinds of effects; those of the output and the clock are searched for in samples and stamps.
    """
    known = ErrorModel({}) if start is None else start
    log = measured(log)
    unusable = _unusable(log)
    rows = _rows(log.drop(columns=[place.axis for place in unusable]), reference)
    clock = stamps(rows.index.to_numpy(float))
    kinds = sorted((kind for kind in catalogue if kind.role is Role.CLOCK), key=lambda kind: not kind.displaces)
    stamped = [evidence for kind in kinds if (evidence := kind.found(clock)) is not None]
    displaced = any(evidence.effect.displaces for evidence in stamped)
    time = clock.line if displaced else clock.grid
    everywhere = _conditions(rows, clock, reference)
    news = _News(known, float(time[0]))
    for evidence in stamped:
        news.add(TIME, evidence, "stamps", time[0], time[-1])
    news.irregular(clock, displaced)
    outputs = {axis: _on_grid(rows[axis], clock) for axis in axes(rows)}
    at = {axis: _at(everywhere, axis) for axis in outputs}
    seen = {axis: _seen(values, at[axis], catalogue) for axis, values in outputs.items()}
    for axis, values in outputs.items():
        elsewhere = np.isnan(values) & ~clock.lost
        if elsewhere.any() and not np.isnan(values).all():
            news.missing(axis, elsewhere, at[axis].time, kinds)
        news.seen(axis, seen[axis], values)
    at_rest = reference is None
    blind = common_shocks(outputs, clock.interval) if at_rest else in_reference_gap(reference, clock.course)
    flawed = {axis: np.isnan(values) | _flawed(seen[axis], len(values)) | blind for axis, values in outputs.items()}
    for kind in (kind for kind in catalogue if kind.stage is Stage.TRANSFER):
        _transferred(kind, news, outputs, at, flawed)
    steps = {axis: max((one.effect.lattice for one in some), default=0.0) for axis, some in seen.items()}
    sequences = {
        axis: _sequence(values, at[axis], flawed[axis], seen[axis], steps[axis], seed)
        for axis, values in outputs.items()
    }
    whole = {axis: _filled_output(np.where(blind, np.nan, one), sequences[axis]) for axis, one in outputs.items()}
    struck = [tuple(map(float, ends)) for ends in runs_of(blind) * clock.interval] if at_rest else []
    places = (*unusable, *news.discrepancies)
    begin = float(time[0])
    return PreparedLog(sequences, whole, news.findings(), places, begin, unusable, tuple(struck), news.confirmed)


class _News:
    """Collector of evidence: effects outside of the start model become discrepancies and findings."""

    def __init__(self, known: ErrorModel, origin: float) -> None:
        self.known, self.origin, self.discrepancies = known, origin, []
        self.evidence: dict[type[Effect], dict[str, Evidence]] = {}
        self.confirmed: dict[str, tuple[Evidence, ...]] = {}

    def add(self, axis: str, evidence: Evidence, view: str, low: float, high: float, unit: str = "s") -> None:
        kind = type(evidence.effect)
        if any(isinstance(effect, kind) for effect in self.known.axes.get(axis, AxisModel())):
            self.confirmed[axis] = (*self.confirmed.get(axis, ()), evidence)
            return
        self.evidence.setdefault(kind, {})[axis] = evidence
        self.place(view, axis, low, high, unit, evidence.log_p)

    def place(self, view: str, axis: str, low: float, high: float, unit: str, log_p: float) -> None:
        shift = self.origin if unit == "s" else 0.0
        p_value = float(np.exp(max(log_p, CERTAIN_LOG_P)))
        self.discrepancies.append(Discrepancy(view, axis, float(low - shift), float(high - shift), unit, p_value))

    def seen(self, axis: str, found: Sequence[Evidence], values: np.ndarray) -> None:
        """Add the evidence found in the output of an axis, shape (n,), at the range of values affected."""
        for evidence in found:
            low, high = evidence.extent or (np.nanmin(values), np.nanmax(values))
            self.add(axis, evidence, "values", low, high, _unit(axis))

    def missing(self, axis: str, lost: np.ndarray, time: np.ndarray, kinds: Sequence[type[Effect]]) -> None:
        """Add the evidence of samples missing on one axis alone, ``lost`` of shape (n,)."""
        for evidence in filter(None, (kind.missing(lost) for kind in kinds)):
            self.add(axis, evidence, "values", *time[lost][[0, -1]] + self.origin)

    def irregular(self, clock: Stamps, displaced: bool) -> None:
        """Add the places of stamps that are out of order, or whose scatter no effect explains."""
        bad = np.flatnonzero(~clock.advancing)
        if len(bad):
            near = clock.time[clock.advancing]
            spots = np.interp(bad, np.flatnonzero(clock.advancing), near)
            self.place("stamps", TIME, spots[0], spots[-1], "s", CERTAIN_LOG_P)
        scattered = clock.scatter.size >= LEAST and clock.variance > ROUNDED * clock.rounding_variance
        tailed = scattered and np.abs(clock.scatter).max() > MAX_TICK_DEVIATION * np.sqrt(clock.variance)
        if clock.even and tailed and not displaced:
            first, last = clock.time[clock.advancing][[0, -1]]
            self.place("stamps", TIME, first, last, "s", CERTAIN_LOG_P)

    def findings(self) -> tuple[Finding, ...]:
        """Return one finding for each effect; axes with equal parameters share it."""
        shared: dict[tuple, dict[str, Evidence]] = {}
        for kind, found in self.evidence.items():
            for axis, evidence in found.items():
                units, values = kind.units(_unit(axis)), evidence.effect.parameters()
                same = (kind, *((name, f"{value:.4g}", units[name]) for name, value in values.items()))
                shared.setdefault(same, {})[axis] = evidence
        return tuple(map(_finding, shared.values()))


def _finding(found: dict[str, Evidence]) -> Finding:
    """Return the finding of one effect."""
    axis, surest = min(found.items(), key=lambda one: one[1].log_p)
    one = finding({axis: evidence.effect for axis, evidence in found.items()}, surest, _unit(axis))
    return replace(one, log_p=max(one.log_p, CERTAIN_LOG_P))


def _unit(axis: str) -> str:
    return {TIME: "s"}.get(axis, "rad/s" if axis in GYRO else "m/s^2")


def _unusable(log: pd.DataFrame) -> tuple[Discrepancy, ...]:
    """Return the unusable axes, each as a place, if there are others.

    Those without noise (:func:`without_noise`), at their first value, and those of samples between which the others
    were interpolated.
    """
    values = {axis: log[axis].dropna() for axis in axes(log)}
    unusable = {}
    for axis, found in values.items():
        unique = found.unique()
        if without_noise(found.to_numpy(float)):
            level = float(unique[0]) if len(unique) else np.nan
            unusable[axis] = Discrepancy("values", axis, level, level, _unit(axis), 0.0)
        elif (every := _samples_to_a_knot(found.to_numpy(float))) > 1:
            period = every * float(np.median(np.diff(found.index)))
            unusable[axis] = Discrepancy("values", axis, period, period, "s", 0.0)
    return () if len(unusable) == len(values) else tuple(unusable.values())


def without_noise(values: np.ndarray) -> bool:
    """Return whether finite samples, shape (n,), are nearly all one value, or follow exactly from those before.

    A linear recurrence gives each sample of a ramp, of alternating values or of tones from those before.
    """
    if len(values) < 2 or len(values) - np.unique(values, return_counts=True)[1].max() < MIN_CHANGES:
        return True
    scaled = (values - values[0]) / np.ptp(values)
    if len(scaled) < 4 * RECURRENCE:
        return False
    before = sliding_window_view(scaled[:-1], RECURRENCE)
    terms = np.column_stack([before, np.ones(len(before))])
    step = scaled[RECURRENCE:] - scaled[RECURRENCE - 1 : -1]
    left = step - terms @ np.linalg.lstsq(terms, step, rcond=None)[0]
    return bool(np.abs(left).max() < PREDICTED)


def _samples_to_a_knot(values: np.ndarray) -> float:
    """Return the number of samples per true sample of an axis that was interpolated; one if it was not.

    On a coarse lattice equal differences are frequent without any interpolation; such an axis is not tested.
    """
    slope = np.diff(values)
    if len(slope) < 2 or len(np.unique(values)) < MIN_DISTINCT_SHARE * len(values):
        return 1.0
    straight = np.abs(np.diff(slope)) < STRAIGHT_TOLERANCE * np.median(np.abs(slope))
    share = float(np.mean(straight & (slope[1:] != 0)))
    return 1 / (1 - share) if MIN_STRAIGHT_SHARE < share < 1 else 1.0


def measured(log: pd.DataFrame) -> pd.DataFrame:
    """Return a log with NaN for what is no value: not finite, or of rows without power, which are zero on all axes."""
    finite = log.replace([np.inf, -np.inf], np.nan)
    return powered(finite, without_power(finite)) if axes(log) else finite


def _rows(log: pd.DataFrame, reference: pd.DataFrame | None) -> pd.DataFrame:
    """Return the rows that hold a value, :data:`MARGIN` samples within the time of the reference."""
    names = list(axes(log))
    if not names:
        raise LogError("log", "columns", f"at least one of {', '.join(AXES)}", "none of them")
    held = log[names].notna().any(axis=1).to_numpy()
    if reference is not None:
        missing = [name for name in names if name not in reference]
        if missing:
            raise LogError("reference", "columns", f"those of the log, {', '.join(names)}", f"no {missing[0]}")
        held = held & ~outside(reference, log.index.to_numpy(float))
    if np.count_nonzero(held) < 2:
        raise LogError("log", "rows", "at least 2 that hold a value", str(np.count_nonzero(held)))
    return log[held]


def _on_grid(column: pd.Series, clock: Stamps) -> np.ndarray:
    """Return a column at every sample of the clock, NaN where it has no value."""
    values = np.full(clock.count, np.nan)
    values[clock.slots[clock.kept]] = column.to_numpy(float)[clock.kept]
    return values


def _conditions(rows: pd.DataFrame, clock: Stamps, reference: pd.DataFrame | None) -> Conditions:
    even = clock.interval * np.arange(clock.count)
    temperature = None
    if TEMPERATURE in rows:
        temperature = _on_grid(rows[TEMPERATURE], clock)
        measured = np.isfinite(temperature)
        temperature = smoothed(np.interp(even, even[measured], temperature[measured])) if measured.any() else None
    if reference is None:
        return Conditions(even, clock.interval, temperature)
    motion = _motion(reference, clock)
    ideal = motion.iloc[MARGIN : len(motion) - MARGIN].set_axis(even)
    return Conditions(even, clock.interval, temperature, ideal=ideal, motion=motion)


def _motion(reference: pd.DataFrame, clock: Stamps) -> pd.DataFrame:
    """Return the reference at the samples and :data:`MARGIN` more at either end; index: time since the first one [s].

    It is unchanged where the stamps are equal, else interpolated by cubic splines. Samples are taken at even times,
    also where a stamp is rounded or scattered.
    """
    names, own, time = list(axes(reference)), reference.index.to_numpy(float), _extended(clock.grid, clock.interval)
    nearest = np.clip(np.searchsorted(own, time - STAMP_TOLERANCE * clock.interval), 0, len(own) - 1)
    values = reference[names].to_numpy(float)
    if np.all(np.diff(nearest) == 1) and np.all(np.abs(own[nearest] - time) < STAMP_TOLERANCE * clock.interval):
        values = values[nearest]
    else:
        time = _extended(clock.course, clock.interval)
        inside, blind = np.clip(time, own[0], own[-1]), in_reference_gap(reference, time)
        bridged = np.column_stack([np.interp(inside, own, column) for column in values.T])
        values = np.where(blind[:, None], bridged, CubicSpline(own, values)(inside))
    even = clock.interval * np.arange(-MARGIN, clock.count + MARGIN)
    return pd.DataFrame(values, columns=names, index=pd.Index(even, name=TIME))


def _extended(time: np.ndarray, interval: float) -> np.ndarray:
    """Return even times, shape (n,), with :data:`MARGIN` more at either end."""
    more = interval * np.arange(1, MARGIN + 1)
    return np.concatenate([time[0] - more[::-1], time, time[-1] + more])


def outside(reference: pd.DataFrame, time: np.ndarray) -> np.ndarray:
    """Return which stamps, shape (n,), are not :data:`MARGIN` samples within the time of the reference."""
    margin = (MARGIN - STAMP_TOLERANCE) * np.nanmedian(np.diff(time))
    return (time < reference.index[0] + margin) | (time > reference.index[-1] - margin)


def in_reference_gap(reference: pd.DataFrame, time: np.ndarray) -> np.ndarray:
    """Return which times, shape (n,), are in a gap of the reference."""
    own = reference.index.to_numpy(float)
    steps, after = np.diff(own), np.clip(np.searchsorted(own, time), 1, len(own) - 1)
    return steps[after - 1] > MIN_GAP_STEPS * np.median(steps)


def _at(everywhere: Conditions, axis: str) -> Conditions:
    return replace(everywhere, axis=axis)


def _seen(values: np.ndarray, conditions: Conditions, catalogue: Sequence[type[Effect]]) -> list[Evidence]:
    """Return the evidence of output effects in the output of one axis, shape (n,), NaN where lost."""
    if np.isnan(values).all():
        return []
    kinds = [kind for kind in catalogue if kind.role is Role.OUTPUT and kind.stage is not Stage.TRANSFER]
    return [evidence for kind in kinds if (evidence := kind.found(values, conditions)) is not None]


def _flawed(found: Sequence[Evidence], count: int) -> np.ndarray:
    """Return which samples, shape (count,), are flawed by effects."""
    return np.any([one.flawed for one in found], axis=0) if found else np.zeros(count, bool)


def _transferred(kind: type[Effect], news: _News, outputs: dict, at: dict, flawed: dict) -> None:
    """Add and mark the samples flawed in transfer: of all axes at once where they share them, else of each axis."""
    free = {axis: np.where(flawed[axis], np.nan, values) for axis, values in outputs.items()}
    alone = {axis: kind.found(values, at[axis]) for axis, values in free.items()}
    for group in (tuple(outputs), *(tuple(axis for axis in outputs if axis in triad) for triad in (GYRO, ACCEL))):
        if len(group) < 2:
            continue
        together = kind.found(np.column_stack([free[axis] for axis in group]), at[group[0]])
        if together is None:
            continue
        shared = np.count_nonzero(together.flawed)
        counts = [np.count_nonzero(alone[axis].flawed) for axis in group if alone[axis] is not None]
        if shared >= MIN_COMMON_SHARE * max(counts, default=0):
            alone |= dict.fromkeys(group, together)
            break
    for axis, evidence in alone.items():
        if evidence is not None:
            news.add(axis, evidence, "values", *(at[axis].time[evidence.flawed][[0, -1]] + news.origin))
            flawed[axis] = flawed[axis] | evidence.flawed


def _sequence(
    values: np.ndarray,
    conditions: Conditions,
    flawed: np.ndarray,
    seen: Sequence[Evidence],
    step: float,
    seed: int,
) -> AxisSequence:
    """Return the error of an axis with its flawed samples replaced, within the limits of their input if known."""
    low, high = np.full((2, len(values)), [[-np.inf], [np.inf]])
    for evidence in (one for one in seen if one.bounds is not None):
        low = np.where(evidence.flawed, evidence.bounds[0], low)
        high = np.where(evidence.flawed, evidence.bounds[1], high)
    error, ideal = values - conditions.error_free, conditions.error_free
    whole = AxisSequence(np.where(np.isfinite(error), error, 0.0), conditions, step=step)
    if flawed.all():
        return whole
    mended = whole.with_replaced(flawed, stream(seed, "mended", conditions.axis))
    mended = mended.with_censored_drawn(low - ideal, high - ideal, stream(seed, "beyond", conditions.axis))
    return replace(mended, share=usable_share(mended.values))


def _filled_output(values: np.ndarray, sequence: AxisSequence) -> np.ndarray:
    """Return the output of an axis with the replacements of its sequence where it has no value."""
    return np.where(np.isnan(values), sequence.values + sequence.conditions.error_free, values)
