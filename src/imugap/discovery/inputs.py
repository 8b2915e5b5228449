"""Discovery on files: read and check logs, reference and start model of a user, then discover."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from imugap import log
from imugap.discovery import report
from imugap.discovery.device import Discovery, Settings, discover
from imugap.discovery.next_log import Advice, advise
from imugap.discovery.preparation.prepare import MARGIN, in_reference_gap, measured, outside, without_noise
from imugap.discovery.start_comparison import final_parameters
from imugap.discovery.start_comparison.parameters import StartParameter, against_start
from imugap.discovery.steps import Progress
from imugap.effects.effect import Role
from imugap.integrity.timestamps import Stamps, stamps
from imugap.interchange.plugins import catalogue
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io import recording
from imugap.io.recognition.frame import AS_IS
from imugap.io.recording import DEFAULTS, Recording, RecordingSettings
from imugap.io.scales import require_same_scale
from imugap.log import LogError
from imugap.model import ErrorModel
from imugap.numerics.samples.change_period import change_period

MIN_SAMPLES = 320
"""Minimum number of samples of an axis, for the views of the training and the held-out part."""
MAX_RATE_DIFFERENCE = 0.2
"""Maximum relative difference of the rates of a further run and the first: no clock of a device is farther off."""
MIN_REGULAR_SHARE, MIN_REGULAR_COUNT = 0.9, 40
"""Minimum share and number of values at one spacing in rows for this spacing to be the rate of the axis."""
MIN_COVERAGE = 0.9
"""Minimum share of the log that its reference covers; the rest is not used."""


@dataclass(frozen=True)
class Files:
    """Files of a discovery, and the module of further effects.

    Attributes
    ----------
    logs, tests, reference, model
        Canonical CSV or Parquet logs of one device; further runs of it, on which distances are taken; error-free log
        of the first run, for a device in motion; start model (YAML, or a file of a simulator).
    effects
        Name of a module whose effects join the catalogue.
    reading
        How the logs are read. Unless it has a frame, the axes stay those of the files: a model is of the axes of the
        device, and gravity is taken off in any of them.
    """

    logs: tuple[Path, ...]
    tests: tuple[Path, ...] = ()
    reference: Path | None = None
    model: Path | None = None
    effects: str | None = None
    reading: RecordingSettings = DEFAULTS


@dataclass(frozen=True, eq=False)
class FileDiscovery:
    """Discovery on files, with the properties of its logs.

    Attributes
    ----------
    logs, tests
        Path, sha256, rate [Hz], first stamp and duration [s] of each log; of the first log those of its used part. All
        times of the report and of the models count from its first stamp.
    alpha
        Level of the tests.
    found
        The discovery.
    inputs
        The recordings and the start model.
    remarks
        Sentences on what was recognised in the start model, where it is a file of another tool.
    against
        Parameters of the start model beside those of the log; none without a start model.
    """

    logs: tuple[dict, ...]
    tests: tuple[dict, ...]
    alpha: float
    found: Discovery
    inputs: "DiscoveryInputs"
    remarks: tuple[str, ...] = ()
    against: tuple[StartParameter, ...] = ()

    @property
    def recognised(self) -> dict[str, tuple[str, ...]]:
        """Return sentences on what was recognised in each log and in the start model, by its path.

        Only of logs that are not canonical and models of other tools.
        """
        recordings = (*self.inputs.logs, *self.inputs.tests)
        said = {str(one.source): one.recognised for one in recordings if one.recognised}
        return said | ({str(self.inputs.model.path): self.remarks} if self.inputs.model and self.remarks else {})

    @cached_property
    def parameters(self) -> pd.DataFrame:
        """Return the parameters of the final model, each with its interval (:func:`final_parameters.table`)."""
        return final_parameters.table(self.found)

    @cached_property
    def advice(self) -> tuple[Advice, ...]:
        """Return what to record next for each finding with an ambiguous name."""
        return advise(self.found.findings, lambda axis: self.found.results[axis].whole_fit.sequence.conditions)

    def report(self) -> dict:
        """Return the report as plain data, schema ``imugap/discovery/2``."""
        return report.to_mapping(self.found, self.logs, self.tests)


@dataclass(frozen=True, eq=False)
class DiscoveryInputs:
    """Recordings of a discovery.

    Attributes
    ----------
    logs, tests, reference
        Runs of one device, as :class:`Files` has them, in the axes of the device.
    model
        Start model; None for a constant bias and white noise fitted to the log.
    """

    logs: tuple[Recording, ...]
    tests: tuple[Recording, ...] = ()
    reference: Recording | None = None
    model: ModelFile | None = None

    def __post_init__(self) -> None:
        """Check that a reference is that of one log, and that there are no tests then; ValueError otherwise."""
        _require_one_run(self.logs, self.tests, self.reference)


def discover_files(
    files: Files, settings: Settings, progress: Progress = lambda step, done, steps: None
) -> FileDiscovery:
    """Read the files, then discover on them (:func:`discover_recordings`).

    The start model and the catalogue of ``settings`` are replaced by those of the files.
    """
    kinds = catalogue(files.effects)
    opened = None if files.model is None else ModelFile.open(files.model, kinds)
    settings = replace(settings, catalogue=tuple(kinds.values()))
    _require_one_run(files.logs, files.tests, files.reference)
    reading = replace(files.reading, frame=files.reading.frame or AS_IS)
    logs, tests = (tuple(recording.read(path, reading) for path in some) for some in (files.logs, files.tests))
    turned = RecordingSettings(frame=logs[0].frame)
    reference = None if files.reference is None else recording.read(files.reference, turned)
    return discover_recordings(DiscoveryInputs(logs, tests, reference, opened), settings, progress)


def discover_recordings(
    inputs: DiscoveryInputs, settings: Settings, progress: Progress = lambda step, done, steps: None
) -> FileDiscovery:
    """Check the recordings, then discover; the start model of ``settings`` is replaced by that of the inputs.

    An invalid recording raises a ValueError or OSError that names the file, the location in it, and the expected and
    found value.
    """
    logs, tests = (tuple(map(_usable, some)) for some in (inputs.logs, inputs.tests))
    first = logs[0]
    for one, table in zip((*inputs.logs[1:], *inputs.tests), (*logs[1:], *tests), strict=True):
        _require_columns(table, one.source, list(first.columns))
        _require_values(table, one.source, first)
        _require_rate(table, one.source, first)
    require_same_scale([one.source for one in (*inputs.logs, *inputs.tests)], [*logs, *tests])
    start = None if inputs.model is None else inputs.model.at(1 / _clock(inputs.logs[0].source, first).interval)
    if start is not None:
        _require_describable(start.model, inputs.model.path, first)
    settings = replace(settings, start=start and start.model)
    reference = None if inputs.reference is None else _reference(inputs.reference, first)
    found = discover(logs, settings, tests, reference, progress)
    properties, *others = map(_log_properties, inputs.logs, logs)
    used = (properties | _used_part(found), *others)
    others = tuple(map(_log_properties, inputs.tests, tests))
    if start is None:
        return FileDiscovery(used, others, settings.alpha, found, inputs)
    against = against_start(found, start.model, start.keys, settings.alpha)
    return FileDiscovery(used, others, settings.alpha, found, inputs, start.remarks, against)


def _require_one_run(logs: Sequence, tests: Sequence, reference: object | None) -> None:
    """Raise a ValueError if there is a reference, and several logs or tests."""
    if tests and reference is not None:
        raise ValueError("test: expected runs at rest; found a reference, which implies a device in motion")
    if len(logs) > 1 and reference is not None:
        raise ValueError(f"reference: expected one log, which it is the error-free one of; found {len(logs)}")


def _usable(found: Recording) -> pd.DataFrame:
    """Return the table; raise a LogError unless an axis varies, and each such has enough samples at its own rate."""
    path, table = found.source, found.table
    _clock(path, table)
    varying = _varying(table)
    if not varying:
        same = all(table[axis].dropna().nunique() < 2 for axis in log.axes(table))
        what = "one value everywhere" if same else "nearly one value, or samples that follow exactly from those before"
        raise LogError(path, "columns", "values that vary on one axis at least, as noise does", what)
    for axis, values in varying.items():
        if len(values) < MIN_SAMPLES:
            raise LogError(path, f"column {axis}", f"at least {MIN_SAMPLES} samples", str(len(values)))
        _require_own_rate(table, path, axis)
    return table


def _varying(table: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the finite values of the axes that have noise."""
    finite = {axis: values.dropna() for axis, values in measured(table)[list(log.axes(table))].items()}
    return {axis: values for axis, values in finite.items() if not without_noise(values.to_numpy(float))}


def _require_own_rate(table: pd.DataFrame, path: Path, axis: str) -> None:
    """Raise a LogError if an axis has a new value only at regular spacings of several rows, and is not held between."""
    values = table[axis].to_numpy(float)
    if change_period(values[:, None]) is not None:
        return
    known = np.isfinite(values)
    fresh = np.flatnonzero(known)
    fresh = fresh[np.r_[True, np.diff(values[fresh]) != 0]]
    steps, counts = np.unique(np.diff(fresh), return_counts=True)
    most = int(steps[np.argmax(counts)])
    if most > 1 and counts.max() > max(MIN_REGULAR_SHARE * counts.sum(), MIN_REGULAR_COUNT):
        expected = "a value in every row (logs of sensors of other rates come in files of their own)"
        raise LogError(path, f"column {axis}", expected, f"a new one in one of {most} rows")


def _clock(path: Path, table: pd.DataFrame) -> Stamps:
    """Return the sampling clock of a log; raise a LogError with its path where it has none."""
    try:
        return stamps(table.index.to_numpy(float))
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error


def _require_columns(table: pd.DataFrame, path: Path, names: Sequence[str]) -> None:
    missing = [name for name in names if name not in table]
    if missing:
        raise LogError(path, "columns", f"those of the first log, {', '.join(names)}", f"no {missing[0]}")


def _require_values(table: pd.DataFrame, path: Path, first: pd.DataFrame) -> None:
    """Raise a LogError unless a further log has a temperature if the first has, and a varying axis in common."""
    if log.TEMPERATURE in first and first[log.TEMPERATURE].notna().any() and table[log.TEMPERATURE].isna().all():
        raise LogError(path, f"column {log.TEMPERATURE}", "values, as the first log has", "none")
    if not set(_varying(first)) & set(_varying(table)):
        names = ", ".join(_varying(first))
        raise LogError(
            path, "columns", f"values that vary on an axis on which those of the first log do, {names}", "none"
        )


def _require_describable(model: ErrorModel, path: Path, measured: pd.DataFrame) -> None:
    """Raise a ValueError unless a start model has at most one filter and outlier effect and a step within the range."""
    for axis, values in _varying(measured).items():
        effects = tuple(model.axes.get(axis, ()))
        for role in (Role.FILTER, Role.OUTLIERS):
            same = [one for one in effects if one.role is role]
            if len(same) > 1:
                raise ValueError(f"{path}: {axis}: expected one {same[0].name} at most; found {len(same)}")
        reach = float(np.ptp(values))
        for step in (one.lattice for one in effects):
            if step > reach:
                expected = f"a step below the range of the values of the log, {reach:.4g}"
                raise ValueError(f"{path}: {axis}: resolution: expected {expected}; found {step:.4g}")


def _require_rate(table: pd.DataFrame, path: Path, first: pd.DataFrame) -> None:
    """Raise a LogError unless a further log has nearly the rate of the first, on which its views depend."""
    found, expected = (1 / _clock(path, one).interval for one in (table, first))
    if abs(found / expected - 1) > MAX_RATE_DIFFERENCE:
        raise LogError(path, "time", f"the rate of the first log, {expected:.4g} Hz", f"{found:.4g} Hz")


def _reference(found: Recording, measured: pd.DataFrame) -> pd.DataFrame:
    """Return the reference; raise a LogError unless it is complete and covers the log."""
    path, reference = found.source, log.check(found.table, found.source)
    _require_columns(reference, path, log.axes(measured))
    time = measured.index.to_numpy(float)
    covered = (time >= reference.index[0]) & (time <= reference.index[-1])
    if np.mean(covered) < MIN_COVERAGE:
        expected = f"that of the log, {np.nanmin(time):g} to {np.nanmax(time):g} s"
        raise LogError(path, "time", expected, f"{reference.index[0]:g} to {reference.index[-1]:g} s")
    inside = int(np.count_nonzero(~outside(reference, time)))
    if inside < MIN_SAMPLES:
        expected = f"{MARGIN} samples before and after at least {MIN_SAMPLES} samples of the log"
        raise LogError(path, "time", expected, f"them about {inside}")
    covered &= ~in_reference_gap(reference, time)
    if np.mean(covered) < MIN_COVERAGE:
        found = f"holes, which leave {100 * np.mean(covered):.0f} %"
        raise LogError(path, "time", f"stamps near {100 * MIN_COVERAGE:.0f} % of those of the log", found)
    return reference


def _used_part(found: Discovery) -> dict:
    """Return first stamp and duration [s] of the used part of the first log."""
    conditions = next(iter(found.record.sequences.values())).conditions
    return {"begin_s": found.record.begin, "duration_s": conditions.interval * len(conditions)}


def _log_properties(found: Recording, table: pd.DataFrame) -> dict:
    clock = _clock(found.source, table)
    return {
        "path": str(found.source),
        "sha256": found.sha256,
        "rate_hz": 1 / clock.interval,
        "begin_s": float(clock.grid[0]),
        "duration_s": clock.interval * clock.count,
    }
