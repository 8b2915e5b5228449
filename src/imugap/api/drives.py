"""Navigate a drive with the device and a GNSS receiver in a vehicle."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from imugap.analysis import track
from imugap.analysis.drive import NavigatedDrive, RecordedDrive, keeps_recognised_axes, navigate_drive
from imugap.analysis.drive_settings import DriveSettings
from imugap.api.logs import DeviceLog, LogSource, read
from imugap.api.result import Result, SourcePath, call
from imugap.io.fixes import reading
from imugap.io.fixes.reading import ReceiverLog
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.io.recognition.frame import AS_IS
from imugap.model import ErrorModel
from imugap.pages.provenance import InputFile, Provenance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page


SETTINGS_FILE, MODEL_FILE = "settings.yaml", "model.yaml"
"""Files of the settings in use and of their error model."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Driven(Result):
    """Path of a drive.

    Attributes
    ----------
    found
        Solutions of filter and smoother, fixes, verdict, and the settings in use.
    """

    found: NavigatedDrive

    @property
    def trajectory(self) -> pd.DataFrame:
        """Smoothed Trajectory, geodetic position [deg, m], sensor errors, and standard deviations (``_std``)."""
        return self.found.table(self.found.smoothed)

    @property
    def filtered(self) -> pd.DataFrame:
        """The same of the filter, which at each time knows the past only."""
        return self.found.table(self.found.filtered)

    @property
    def summary(self) -> dict:
        """Verdict, extent, events of the quality control, and consistency."""
        return self.found.summary()

    @property
    def outages(self) -> pd.DataFrame:
        """Windows of 10, 30 and 60 s whose fixes were withheld: drift of the prediction, and what the filter states."""
        return self.found.outages.windows

    @property
    def model(self) -> ErrorModel:
        """Error model of the device in use, with noise that the drive has shown."""
        return self.found.settings.model

    @property
    def settings(self) -> str:
        """Configuration (YAML) by which the same follows from the same files; its model is that in ``model.yaml``."""
        return self.found.settings.text(MODEL_FILE)

    @property
    def agrees(self) -> bool:
        """Whether device and fixes agree as they were given."""
        return self.found.verdict.agrees

    @property
    def verdict(self) -> str:
        """Whether device and fixes agree, and what was corrected."""
        return str(self.found.verdict)

    def plot(self) -> "Figure":
        """Draw the drive from above."""
        from imugap.figures import drive

        return drive.track(self.found.filtered, self.found.smoothed, self.found.fixes)

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return solutions, events, drift over outages, settings and error model in use, summary, maps, and figures."""
        from imugap.figures import drive

        filtered, smoothed = self.found.filtered, self.found.smoothed
        return {
            "solution.parquet": self.filtered,
            "smoothed.parquet": self.trajectory,
            "events.csv": filtered.events,
            "outages.csv": self.found.outages.drifts,
            SETTINGS_FILE: self.settings,
            MODEL_FILE: self.model,
            "summary.json": self.summary,
            "path.geojson": track.geojson(smoothed),
            "path.kml": track.kml(smoothed),
            "track.svg": self.plot(),
            "motion.svg": drive.motion(filtered, smoothed),
            "sensors.svg": drive.sensors(filtered, smoothed),
            "quality.svg": drive.quality(filtered),
        }

    def _page(self) -> "Page":
        from imugap.pages.drive import page

        return page(self.found)


def drive(
    log: LogSource,
    fixes: ReceiverLog | pd.DataFrame | SourcePath,
    *,
    config: SourcePath | None = None,
    effects: str | None = None,
    as_given: bool = False,
    fixes_topic: str | None = None,
    fixes_angles: str | None = None,
) -> Driven:
    """Navigate a drive by device and receiver, with quality control of the fixes.

    Parameters
    ----------
    log
        Log of all six axes, x forward and z down, or turned as ``config`` says.
    fixes
        Log of the receiver on the clock of the device: a table, RTKLIB, NMEA, GPX, text of KF-GINS, or a bag; or a
        DataFrame with index ``time`` [s] and columns as those of a table, latitude and longitude in degrees.
    config
        Device, mounting, lever arm and quality control (YAML).
    effects
        Name of a module whose effects join the catalogue.
    as_given
        Whether settings and fixes are used as they are, and only judged.
    fixes_topic
        Topic of a bag with the fixes.
    fixes_angles
        Unit of latitude and longitude in a table, ``deg`` or ``rad``.
    """
    settings = DriveSettings.read(None if config is None else Path(config), effects)
    found, turned = in_axes_of_mounting(read(log), settings), any(settings.mounting)
    receiver = _receiver(fixes, ReceiverSettings(fixes_topic, fixes_angles))
    known = turned or found.settings.frame is not None
    recorded = RecordedDrive.of(found.recording, receiver.fixes, settings, known, as_given)
    try:
        navigated = navigate_drive(recorded)
    except ValueError as error:
        raise ValueError(f"{found.source}, {receiver.source}: {error}") from error
    files = [found.as_input("log"), InputFile("fixes", str(receiver.source), receiver.sha256, receiver.recognised)]
    if config is not None:
        files.append(InputFile.of("configuration", config, settings.recognised))
    made = call("drive", [found.source, str(receiver.source)], config=config, effects=effects, as_given=as_given)
    return Driven(found=navigated, provenance=Provenance(made, tuple(files)))


def in_axes_of_mounting(found: DeviceLog, settings: DriveSettings) -> DeviceLog:
    """Return a log in the axes that the mounting of a device turns: those of its file, or the recognised ones.

    Gravity decides; where it contradicts the mounting in both, they are those of the file.
    """
    if not any(settings.mounting) or found.settings.frame is not None or found.recording.frame == AS_IS:
        return found
    return found if keeps_recognised_axes(found.recording, settings.mounting) else found.in_own_axes()


def _receiver(fixes: ReceiverLog | pd.DataFrame | SourcePath, settings: ReceiverSettings) -> ReceiverLog:
    if isinstance(fixes, ReceiverLog):
        return fixes
    return reading.of_table(fixes) if isinstance(fixes, pd.DataFrame) else reading.read(Path(fixes), settings)
