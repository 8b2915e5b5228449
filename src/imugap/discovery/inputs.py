"""Discovery on files: logs, reference and start model as a user has them, checked before anything is computed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import file_digest
from pathlib import Path

import numpy as np
import pandas as pd

from imugap import log
from imugap.discovery import report
from imugap.discovery.device import Discovery, Question, discover
from imugap.discovery.preparation.prepare import in_reference_gap
from imugap.discovery.steps import Progress
from imugap.effects.effect import Role
from imugap.integrity.timestamps import Stamps, stamps
from imugap.interchange.plugins import catalogue
from imugap.io import readers
from imugap.log import LogError
from imugap.model import ErrorModel

FEWEST = 320
"""Samples that a log has to have: held-in and held-out part have to show their views."""
ALIKE, NEAR = 0.02, 0.2
"""Largest relative difference of the rates of a test and the log, and of logs of which the clocks are compared."""
REGULAR, SEVERAL = 0.9, 40
"""Share and number of the values that come equally many rows apart, from which that is the rate of the axis."""
COVERED = 0.9
"""Least share of the log that its reference has to cover; what it leaves out is not used."""


@dataclass(frozen=True)
class Files:
    """The files that discovery works on, and where it finds effects of the user's own.

    Attributes
    ----------
    logs, tests, reference, model
        Canonical CSV or Parquet logs of one device; further runs of it, on which distances are taken; error-free log
        of the first run, for a device in motion; start model (YAML).
    effects
        Name of a module whose effects join the catalogue.
    """

    logs: tuple[Path, ...]
    tests: tuple[Path, ...] = ()
    reference: Path | None = None
    model: Path | None = None
    effects: str | None = None


@dataclass(frozen=True, eq=False)
class Inquiry:
    """What was asked and what was found.

    Attributes
    ----------
    logs, tests
        Path, sha256, rate [Hz], first stamp and duration [s] of each log, of the first one those of what is used of
        it. All times of the report and of the models count from its first stamp.
    alpha
        The level of the question.
    found
        The discovery.
    """

    logs: tuple[dict, ...]
    tests: tuple[dict, ...]
    alpha: float
    found: Discovery

    def report(self) -> dict:
        """Return the report as plain data, schema ``imugap/discovery/1``."""
        return report.to_mapping(self.found, self.logs, self.tests)


def ask(files: Files, question: Question, progress: Progress = lambda step, done, steps: None) -> Inquiry:
    """Read the files, discover, and return what was found.

    The start model and the catalogue of ``question`` are those of the files. Anything wrong with a file is a
    ValueError or OSError that says which, where in it, what was expected and what was found.
    """
    kinds = catalogue(files.effects)
    start = None if files.model is None else ErrorModel.read(files.model, kinds)
    question = replace(question, start=start, catalogue=tuple(kinds.values()))
    if files.tests and files.reference:
        raise ValueError("test: expected runs at rest; found a reference, which tells of a device in motion")
    if len(files.logs) > 1 and files.reference:
        raise ValueError(f"reference: expected one log, which it is the error-free one of; found {len(files.logs)}")
    logs, tests = _read(files.logs), _read(files.tests)
    for path, table in zip((*files.logs[1:], *files.tests), (*logs[1:], *tests), strict=True):
        _require_columns(table, path, list(logs[0].columns))
        _require_values(table, path, logs[0])
        _require_rate(table, path, logs[0], ALIKE if path in files.tests else NEAR)
    if start is not None:
        _require_described(start, files.model, logs[0])
    reference = None if files.reference is None else _reference(files.reference, logs[0])
    found = discover(logs, question, tests, reference, progress)
    first, *others = map(_described, files.logs, logs)
    return Inquiry((first | _used(found), *others), tuple(map(_described, files.tests, tests)), question.alpha, found)


def _read(paths: Sequence[Path]) -> list[pd.DataFrame]:
    """Read logs; each has to have an axis whose values vary, and every such axis enough samples."""
    tables = [readers.read_table(path) for path in paths]
    for path, table in zip(paths, tables, strict=True):
        _clock(path, table)
        axes = log.axes(table)
        if not axes:
            raise LogError(path, "columns", f"at least one of {', '.join(log.AXES)}", "none of them")
        varying = _varying(table)
        if not varying:
            raise LogError(path, "columns", "values that vary on one axis at least", "one value everywhere")
        for axis, values in varying.items():
            if len(values) < FEWEST:
                raise LogError(path, f"column {axis}", f"at least {FEWEST} samples", str(len(values)))
            _require_own_rate(table, path, axis)
    return tables


def _varying(table: pd.DataFrame) -> dict[str, pd.Series]:
    """Return the values of the axes that have more than one."""
    finite = {axis: table[axis][np.isfinite(table[axis])] for axis in log.axes(table)}
    return {axis: values for axis, values in finite.items() if values.nunique() > 1}


def _require_own_rate(table: pd.DataFrame, path: Path, axis: str) -> None:
    """Raise a LogError if an axis has a new value in every so many rows only, the others being empty or alike."""
    values = table[axis].to_numpy(float)
    known = np.isfinite(values)
    fresh = np.flatnonzero(known)
    fresh = fresh[np.r_[True, np.diff(values[fresh]) != 0]]
    steps, counts = np.unique(np.diff(fresh), return_counts=True)
    most = int(steps[np.argmax(counts)])
    if most > 1 and counts.max() > max(REGULAR * counts.sum(), SEVERAL):
        expected = "a value in every row (logs of sensors of other rates come in files of their own)"
        raise LogError(path, f"column {axis}", expected, f"a new one in one of {most} rows")


def _clock(path: Path, table: pd.DataFrame) -> Stamps:
    """Return the clock of a log, which has to have one."""
    try:
        return stamps(table.index.to_numpy(float))
    except LogError as error:
        raise LogError(path, error.place, error.expected, error.found) from error


def _require_columns(table: pd.DataFrame, path: Path, names: Sequence[str]) -> None:
    missing = [name for name in names if name not in table]
    if missing:
        raise LogError(path, "columns", f"those of the first log, {', '.join(names)}", f"no {missing[0]}")


def _require_values(table: pd.DataFrame, path: Path, first: pd.DataFrame) -> None:
    """Raise a LogError unless a further log has a temperature where the first has, and a varying axis of it."""
    if log.TEMPERATURE in first and first[log.TEMPERATURE].notna().any() and table[log.TEMPERATURE].isna().all():
        raise LogError(path, f"column {log.TEMPERATURE}", "values, as the first log has", "none")
    if not set(_varying(first)) & set(_varying(table)):
        names = ", ".join(_varying(first))
        raise LogError(
            path, "columns", f"values that vary on an axis on which those of the first log do, {names}", "none"
        )


def _require_described(model: ErrorModel, path: Path, measured: pd.DataFrame) -> None:
    """Raise a ValueError unless a start model has what a description has, and a lattice that the log can be on."""
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


def _require_rate(table: pd.DataFrame, path: Path, first: pd.DataFrame, most: float) -> None:
    """Raise a LogError unless a further log has the rate of the first: spectra and filters are those of a rate."""
    found, expected = (1 / _clock(path, one).interval for one in (table, first))
    if abs(found / expected - 1) > most:
        raise LogError(path, "time", f"the rate of the first log, {expected:.4g} Hz", f"{found:.4g} Hz")


def _reference(path: Path, measured: pd.DataFrame) -> pd.DataFrame:
    """Read the reference, which has to be whole and to cover the log."""
    reference = log.check(readers.read_table(path), path)
    _require_columns(reference, path, log.axes(measured))
    time = measured.index.to_numpy(float)
    covered = (time >= reference.index[0]) & (time <= reference.index[-1])
    if np.mean(covered) < COVERED:
        expected = f"that of the log, {np.nanmin(time):g} to {np.nanmax(time):g} s"
        raise LogError(path, "time", expected, f"{reference.index[0]:g} to {reference.index[-1]:g} s")
    covered &= ~in_reference_gap(reference, time)
    if np.mean(covered) < COVERED:
        found = f"holes, which leave {100 * np.mean(covered):.0f} %"
        raise LogError(path, "time", f"stamps near {100 * COVERED:.0f} % of those of the log", found)
    return reference


def _used(found: Discovery) -> dict:
    """Return first stamp and duration [s] of what is used of the first log."""
    conditions = next(iter(found.record.sequences.values())).conditions
    return {"begin_s": found.record.begin, "duration_s": conditions.interval * len(conditions)}


def _described(path: Path, table: pd.DataFrame) -> dict:
    with Path(path).open("rb") as file:
        digest = file_digest(file, "sha256").hexdigest()
    clock = _clock(path, table)
    return {
        "path": str(path),
        "sha256": digest,
        "rate_hz": 1 / clock.interval,
        "begin_s": float(clock.grid[0]),
        "duration_s": clock.interval * clock.count,
    }
