"""Logs of a device: read a recording of any known format, or simulate one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import pandas as pd

from imugap import log as canonical
from imugap.analysis import static
from imugap.api.result import SourcePath
from imugap.interchange.plugins import catalogue
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io import recording as recordings
from imugap.io.formats.source import sha256_of
from imugap.io.recognition.frame import AS_IS
from imugap.io.recognition.settings import DEFAULTS, RecordingSettings
from imugap.io.recording import Recording
from imugap.model import ErrorModel
from imugap.pages.provenance import InputFile
from imugap.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIMULATED = "simulated"
"""Name of a simulated log."""
MODEL = "model"
"""Name of an error model that is no file."""


@dataclass(frozen=True, eq=False)
class DeviceLog:
    """Log of a device.

    Attributes
    ----------
    recording
        The recording as read.
    settings
        What the user says of it.
    given
        The table from which it was made, or None for a file.
    """

    recording: Recording
    settings: RecordingSettings = DEFAULTS
    given: pd.DataFrame | None = None

    @property
    def table(self) -> pd.DataFrame:
        """Samples: index ``time`` [s], columns ``gyro_x`` ... [rad/s], ``accel_x`` ... [m/s^2], ``temperature`` [degC].

        Unchecked: stamps may repeat, samples may be NaN; :func:`imugap.check` says so.
        """
        return self.recording.table

    @property
    def source(self) -> str:
        """Path of the file; ``table`` or ``simulated`` for a log that is none."""
        return str(self.recording.source)

    @property
    def recognised(self) -> tuple[str, ...]:
        """Sentences on what was recognised in the file: rate, units, stamps, axes."""
        return self.recording.recognised

    @cached_property
    def rate_hz(self) -> float:
        """Sampling rate of the rows [Hz]."""
        return 1 / self.recording.regular.interval

    @cached_property
    def duration_s(self) -> float:
        """Length, gaps included [s]."""
        return len(self.recording.regular.log) / self.rate_hz

    def write(self, path: SourcePath) -> None:
        """Write the canonical log as CSV or Parquet, by the ending of ``path``."""
        canonical.write(self.recording.log, Path(path))

    def plot(self) -> "Figure":
        """Draw the samples over time, of long logs the extremes of each stretch."""
        from imugap.figures.log import samples

        return samples(self.recording.regular.log)

    def in_own_axes(self) -> "DeviceLog":
        """Return the log in the axes of its file; as it is where the user says where they point."""
        if self.settings.frame is not None or self.recording.frame == AS_IS:
            return self
        return read(self.source if self.given is None else self.given, replace(self.settings, frame=AS_IS))

    def as_input(self, role: str) -> InputFile:
        """Return path, digest and what was recognised, for the provenance of a result."""
        return InputFile(role, self.source, self.recording.sha256, self.recognised)

    def __repr__(self) -> str:
        """Return source, length and rate."""
        return f"<{type(self).__name__}: {self.source}, {self.duration_s:.4g} s at {self.rate_hz:.4g} Hz>"

    def _repr_html_(self) -> str:
        from imugap.analysis.check import check
        from imugap.pages import check as pages
        from imugap.pages.render import fragment

        return fragment(pages.page([check(self.recording)], [self.recording.regular]))


LogSource: TypeAlias = DeviceLog | pd.DataFrame | SourcePath
"""A log, a table, or the path of a recording."""
ModelSource: TypeAlias = ErrorModel | Mapping | SourcePath
"""An error model, one as plain data, the path of one (YAML, or a file of a simulator or filter), or the name of a
device of which a model is shipped (``imugap models``)."""


def read(
    source: LogSource,
    settings: RecordingSettings | None = None,
    *,
    columns: Sequence[str] = (),
    units: Mapping[str, str] | None = None,
    frame: str | None = None,
    rate: float | None = None,
    time_unit: str | None = None,
    topic: str | None = None,
    rows: tuple[int, int] | None = None,
) -> DeviceLog:
    """Read the recording of a device in any known format; what is not given is recognised from the file.

    Parameters
    ----------
    source
        Path of CSV of any dialect, Parquet, a ROS bag, a PX4 log, an array of NumPy, MATLAB or R; or a table with
        such columns, the stamps as a column or as an index with a name.
    settings
        All of what follows, as one value.
    columns
        A name for each column from left to right (``-`` for one that is not read), or ``canonical=name``.
    units
        Unit of each quantity, such as ``{"gyro": "deg/s", "accel": "g"}``.
    frame
        Where x, y and z point: ``FLU``, ``FRD``, ``NED``, ``ENU`` ..., or ``roll,pitch,heading`` [deg], or ``as-is``.
    rate
        Sampling rate of a file without stamps [Hz].
    time_unit
        Unit of the stamps.
    topic
        Topic of a bag, or message of a log, with the samples.
    rows
        ``(1, 2)`` for the first of each two rows, where those of two devices alternate; ``(1, 1)`` for one device.

    Raises
    ------
    imugap.LogError
        Where something cannot be recognised; it says where, what was expected and found, and what decides.
    """
    if isinstance(source, DeviceLog):
        return source
    given = RecordingSettings(tuple(columns), dict(units or {}), frame, rate, time_unit, topic, rows)
    settings = given if settings is None else settings
    if isinstance(source, pd.DataFrame):
        return DeviceLog(recordings.of_table(source, settings), settings, source)
    return DeviceLog(recordings.read(Path(source), settings), settings)


def simulate(
    model: ModelSource,
    duration: float,
    rate: float,
    *,
    gravity: float = STANDARD_GRAVITY,
    seed: int = 0,
    effects: str | None = None,
) -> DeviceLog:
    """Simulate the log of a device at rest, z down, with an error model.

    Parameters
    ----------
    model
        Error model.
    duration, rate
        Length [s] and sampling rate [Hz].
    gravity
        Gravity of the site [m/s^2].
    seed
        Seed of all random numbers; the same seed gives the same log.
    effects
        Name of a module whose effects join the catalogue.
    """
    opened = open_model(model, effects)
    found = opened.at(rate)
    if not found.model.sensors:
        raise ValueError(f"{opened.path}: expected a model of at least one sensor axis; found none")
    table = static.simulate(found.model, duration, rate, gravity, seed)
    return DeviceLog(Recording(Path(SIMULATED), table, found.remarks))


def open_model(model: ModelSource, effects: str | None = None) -> ModelFile:
    """Open an error model, with the effects of a module in the catalogue.

    A file may be one of this library or of a simulator or filter, recognised by its content; the name of a device
    stands for its model that is shipped.
    """
    if isinstance(model, ErrorModel):
        return ModelFile(Path(MODEL), model)
    kinds = catalogue(effects)
    if isinstance(model, Mapping):
        return ModelFile(Path(MODEL), ErrorModel.from_mapping(model, kinds))
    return ModelFile.open(Path(model), kinds)


def input_of(opened: ModelFile | None, remarks: tuple[str, ...]) -> tuple[InputFile, ...]:
    """Return path, digest and remarks of a model that is a file, for the provenance of a result."""
    if opened is None or opened.file is None:
        return ()
    return (InputFile("model", str(opened.path), sha256_of(opened.file), remarks),)
