"""Navigate a drive by device and receiver.

Stages, each a function of the value that the one before returns: check columns, gaps and times; screen the fixes;
prepare (fill lost samples, rotate to the axes of the vehicle); correct what device and fixes contradict each other in;
align; filter; smooth; judge.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from imugap.analysis.drive_settings import DriveSettings
from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import (
    CLOSED,
    FAILED,
    OPENED,
    REMOVED,
    RESET,
    SEPARATED,
    SET_ASIDE,
    WEIGHED,
)
from imugap.integrity.timestamps import filled
from imugap.io.fixes import gps_time
from imugap.io.fixes.course import fast_course_rate
from imugap.io.gnss import COMPONENTS, PLACE_STD
from imugap.io.recognition import frame
from imugap.io.recording import Recording
from imugap.kinematics.strapdown import ATTITUDE
from imugap.log import ACCEL, AXES, GYRO, LogError, axes
from imugap.navigation.drive import (
    clock_rate,
    drive_error_search,
    drive_physics,
    drive_verdict,
    fix_screening,
    vehicle,
    vehicle_alignment,
)
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.drive_verdict import DriveVerdict
from imugap.navigation.drive.outages import Outages, outages_of
from imugap.navigation.drive.vehicle import (
    LEVER_ARM,
    TIME_OFFSET,
    DriveInputs,
    DriveSolution,
    InitialState,
)
from imugap.numerics.rotation import from_euler

STD = "_std"
"""Suffix of the name of a standard deviation."""
LONGEST_GAP_S = 0.5
"""Longest gap that is filled [s]."""
FEWEST_FIXES = 2
"""Fewest fixes within the time of a log."""
STEEPEST = 0.5
"""Cosine of the largest angle between up and the mean specific force."""
COUNTED = (FAILED, WEIGHED, REMOVED, RESET, SET_ASIDE, OPENED, SEPARATED, CLOSED)
"""Events that the summary counts."""
FASTEST_TURN, MOST_TURNS = 3.0, 30.0
"""Mean rate over a second that no vehicle has in a drive [rad/s], and its ratio to the rate of the course."""
OUTAGE_INTERVALS = 2.5
"""Shortest outage, in intervals of the fixes."""


@dataclass(frozen=True, eq=False)
class RecordedDrive:
    """Logs of a drive, and its configuration; ``as_given``: without corrections; ``corrections``: of the fixes."""

    log: pd.DataFrame
    fixes: pd.DataFrame
    settings: DriveSettings = field(default_factory=DriveSettings)
    as_given: bool = False
    corrections: tuple[Correction, ...] = ()

    @classmethod
    def of(
        cls, recording: Recording, fixes: pd.DataFrame, settings: DriveSettings, turned: bool, as_given: bool = False
    ) -> "RecordedDrive":
        """Take the true samples of a recording on an even clock; LogError where they cannot be those of a vehicle.

        Parameters
        ----------
        turned
            Whether the user says where the axes of the recording point.
        """
        found = recording.require_gravity()
        if not turned and found.frame not in (frame.AS_IS, frame.CANONICAL, "FLU"):
            expected = "where x points (--frame, or the mounting in --config)"
            known = f"{frame.vertical(found.frame)}, which leaves the heading open"
            raise LogError(found.source, "frame", expected, known)
        measured = found.regular.measured
        _require_radians(measured, fixes, found.source)
        return cls(measured, fixes, settings, as_given)


class PreparedDrive(NamedTuple):
    """Inputs of the filter, the mounting of the device [rad], what was corrected, and whether the receiver's noise is
    stated.
    """

    inputs: DriveInputs
    mounting: tuple[float, float, float]
    corrections: tuple[Correction, ...]
    stated: bool
    as_given: bool


class AlignedDrive(NamedTuple):
    """Inputs of the filter, the mounting of the device [rad], what was corrected, and the initial state."""

    inputs: DriveInputs
    mounting: tuple[float, float, float]
    corrections: tuple[Correction, ...]
    start: InitialState


@dataclass(frozen=True, eq=False)
class NavigatedDrive:
    """Solutions of the filter and of the smoother for a drive, its fixes, the verdict, and the settings in use.

    ``outages`` are windows whose fixes were withheld.
    """

    filtered: DriveSolution
    smoothed: DriveSolution
    fixes: pd.DataFrame
    verdict: DriveVerdict
    inputs: DriveInputs
    outages: Outages
    settings: DriveSettings

    def summary(self) -> dict:
        """Return the verdict, the extent of the drive, the events of the quality control, and the mean NIS.

        ``nis`` is the mean normalised innovation squared over its degrees of freedom, 1 for a consistent filter;
        ``nis_low`` and ``nis_high`` are its 95 % band. ``sensors`` are the filter's estimates at the end, with standard
        deviations.
        """
        one, record = self.filtered, self.filtered.record
        table, events = self.smoothed.trajectory, one.events["event"]
        time = one.fix_time
        gaps = np.diff(np.append(time, one.time[-1]))
        usual = float(np.median(np.diff(self.fixes.index)))
        long = gaps[gaps > OUTAGE_INTERVALS * usual]
        freedom = int(record.freedom.sum())
        low, high = nees_band(freedom, 1)
        end, std, factor = one.trajectory_std.iloc[-1], one.sensors_std.iloc[-1], self.verdict.factor
        found = {
            "start_s": one.time[0],
            "duration_s": one.time[-1] - one.time[0],
            "distance_m": np.hypot(*np.diff(table[["north", "east"]].to_numpy(), axis=0).T).sum(),
            "fixes": len(time),
            "outages": len(long),
            "longest_outage_s": long.max(initial=0.0),
            **{name.replace(" ", "_"): int((events == name).sum()) for name in COUNTED},
            "nis": record.statistic.sum() / freedom,
            "nis_low": low / freedom,
            "nis_high": high / freedom,
            "end_horizontal_std_m": factor * np.hypot(end["north"], end["east"]),
            "end_heading_std_deg": factor * np.degrees(end["heading"]),
        }
        sensors = {name: {"value": value, "std": std[name]} for name, value in one.sensors.iloc[-1].items()}
        plain = {name: value if isinstance(value, int) else float(value) for name, value in found.items()}
        sensors = {name: {key: float(v) for key, v in pair.items()} for name, pair in sensors.items()}
        return self._words() | plain | {"sensors": sensors}

    def _words(self) -> dict:
        """Return the verdict, what was corrected, the tests behind it, and the settings in use."""
        verdict, used = self.verdict, self.inputs.assumptions
        last, std = self.filtered.sensors.iloc[-1], self.filtered.sensors_std.iloc[-1]
        offset, arm = last.get(TIME_OFFSET, 0.0), [last.get(name, 0.0) for name in LEVER_ARM]
        noise = np.median(self.inputs.measured.std, axis=0)
        return {
            "verdict": str(verdict),
            "agrees": verdict.agrees,
            "mends": [
                {"suspect": one.error, "found": one.found, "setting": one.setting} for one in verdict.corrections
            ],
            "outage_test": None if np.isnan(verdict.outage) else verdict.outage,
            "smoother_test": None if np.isnan(verdict.smoother) else verdict.smoother,
            "std_factor": verdict.factor,
            "drift_over_outages": self.outages.drifts.to_dict("records"),
            "time_offset_s": {"value": float(used.time_offset_s + offset), "std": float(std.get(TIME_OFFSET, 0.0))},
            "lever_arm_m": {
                axis: {"value": float(given + error), "std": float(std.get(name, 0.0))}
                for axis, name, given, error in zip("xyz", LEVER_ARM, used.lever_m, arm, strict=True)
            },
            "receiver_std": dict(zip(COMPONENTS, map(float, noise), strict=True)),
            "receiver_slow_std": dict(zip(COMPONENTS[:3], map(float, used.slow_position_std), strict=True)),
            "receiver_slow_s": float(used.slow_position_s),
            "velocity_delay_s": float(used.velocity_delay_s),
            "settings": self.settings.mapping(),
        }

    def table(self, one: DriveSolution) -> pd.DataFrame:
        """Return Trajectory, place (degrees), sensor errors, and standard deviations, by the stamps of the log."""
        factor = self.verdict.factor
        place = one.geodetic.assign(**{name: np.degrees(one.geodetic[name]) for name in ("latitude", "longitude")})
        parts = [one.trajectory, place, factor * one.trajectory_std.add_suffix(STD)]
        found = pd.concat([*parts, one.sensors, factor * one.sensors_std.add_suffix(STD)], axis=1)
        return found.set_axis(clock_rate.as_logged(self.inputs, found.index))


def navigate_drive(recorded: RecordedDrive) -> NavigatedDrive:
    """Screen, check, prepare, correct, align, filter, smooth and judge a drive."""
    return smooth(align(correct(prepare(check(screen(recorded))))))


def _require_radians(log: pd.DataFrame, fixes: pd.DataFrame, path: Path) -> None:
    """Raise a LogError where the device turns many times faster than the course: its rates are in deg/s."""
    course = fast_course_rate(fixes)
    if course is None or not set(GYRO) <= set(log.columns):
        return
    seconds = np.floor(log.index.to_numpy() - log.index[0])
    turn = float(np.linalg.norm(log[list(GYRO)].groupby(seconds).mean(), axis=1).max())
    if turn > FASTEST_TURN and turn > MOST_TURNS * course:
        found = f"turns of {turn:.3g} within a second, where the course turns by {course:.2g} rad/s; is it in deg/s?"
        raise LogError(path, "columns gyro_x to gyro_z", "angular rate in rad/s (--units gyro=deg/s decides)", found)


def check(recorded: RecordedDrive) -> RecordedDrive:
    """Check the columns and gaps of the log, and that the fixes lie within its time."""
    log, due = recorded.log, recorded.fixes.index.to_numpy() + recorded.settings.assumptions.time_offset_s
    if axes(log) != AXES:
        raise LogError("drive", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    steps = np.diff(log.index.to_numpy())
    if steps.max() > LONGEST_GAP_S:
        found = f"{steps.max():.3g} s after {log.index[int(steps.argmax())]:.10g} s"
        raise ValueError(f"drive: expected gaps of at most {LONGEST_GAP_S:g} s; found {found}")
    if due[0] >= log.index[-1] or due[-1] <= log.index[0]:
        own, seen = (f"{one[0]:.10g} s to {one[-1]:.10g} s" for one in (log.index, due))
        raise ValueError(
            f"drive: expected fixes within the time of the log, {own}; found fixes from {seen}"
            f"{_apart(log.index[0], due[0], log.index[-1] - log.index[0])}"
        )
    inside = int(((due >= log.index[0]) & (due <= log.index[-1])).sum())
    if inside < FEWEST_FIXES:
        raise ValueError(
            f"drive: expected at least {FEWEST_FIXES} fixes within the time of the log; found {inside} of {len(due)}"
        )
    return recorded


def _apart(start: float, first: float, duration: float) -> str:
    """Return in words what may have set the clocks of a log and its fixes apart, by their first stamps [s]."""
    for name, converted in gps_time.SCALES.items():
        for whole, offset, left in (
            (start, start - converted(start), converted(start) - first),
            (first, converted(first) - first, converted(first) - start),
        ):
            if whole > gps_time.GPS_EPOCH_S and abs(left) <= duration:
                return f", as of {name} (time_offset: {{offset_s: {offset:.10g}}})"
    return (
        f" (are they on one clock? time_offset: {{offset_s: {start - first:.10g}}} lets both begin together; "
        "--columns time=NAME takes other stamps of the log)"
    )


def screen(recorded: RecordedDrive) -> RecordedDrive:
    """Leave out fixes that no filter can use."""
    if recorded.as_given:
        return recorded
    settings, known = recorded.settings, recorded.settings.assumptions
    fixes, delay, corrections = fix_screening.screen(recorded.fixes, known.position_std, known.velocity_delay_s)
    settings = replace(settings, assumptions=replace(known, velocity_delay_s=delay))
    return replace(recorded, fixes=fixes, settings=settings, corrections=corrections)


def prepare(recorded: RecordedDrive) -> PreparedDrive:
    """Fill lost samples, and rotate the log to the axes of the vehicle."""
    settings, fixes = recorded.settings, recorded.fixes
    inputs = DriveInputs(
        mounted(filled(recorded.log), settings.mounting), fixes, settings.model, fix_screening.first_place(fixes),
        settings.assumptions, settings.quality, settings.alignment,
    )  # fmt: skip
    stated = PLACE_STD[0] in fixes or settings.states_receiver
    if settings.clock_rate:
        inputs = clock_rate.with_clock(inputs, settings.clock_rate)
    return PreparedDrive(inputs, settings.mounting, recorded.corrections, stated, recorded.as_given)


def correct(prepared: PreparedDrive) -> PreparedDrive:
    """Check the physics, and correct what the innovations show."""
    if prepared.as_given:
        return prepared
    inputs, gross = drive_physics.check_physics(prepared.inputs)
    inputs, mounting, turned = drive_physics.with_mounting(inputs, prepared.mounting)
    inputs, fine = drive_error_search.correct(inputs, prepared.stated)
    corrections = (*prepared.corrections, *gross, *turned, *fine)
    return prepared._replace(inputs=inputs, mounting=mounting, corrections=corrections)


def align(prepared: PreparedDrive) -> AlignedDrive:
    """Align at the first fixes."""
    start = vehicle_alignment.align(prepared.inputs)
    return AlignedDrive(prepared.inputs, prepared.mounting, prepared.corrections, start)


def smooth(aligned: AlignedDrive) -> NavigatedDrive:
    """Filter, smooth, withhold fixes in windows, and judge."""
    inputs, mounting, corrections, start = aligned
    filtered, smoothed = (vehicle.navigate(inputs, start, smooth=one) for one in (False, True))
    if not filtered.record.freedom.sum():
        raise ValueError(f"drive: expected fixes after the alignment at {start.time:.10g} s; found none of use")
    outages = outages_of(inputs)
    verdict = drive_verdict.judge(inputs, corrections, filtered, smoothed, outages)
    settings = DriveSettings.in_use(inputs, mounting)
    return NavigatedDrive(filtered, smoothed, inputs.fixes, verdict, inputs, outages, settings)


def mounted(log: pd.DataFrame, mounting: tuple[float, float, float]) -> pd.DataFrame:
    """Return a log in the axes of the vehicle; a ValueError where its mean specific force does not point up there."""
    turn = from_euler(np.array(mounting))
    columns = {}
    for triad in (GYRO, ACCEL):
        turned = turn.apply(log[list(triad)].to_numpy(copy=True))
        columns |= dict(zip(triad, turned.T, strict=True))
    turned = pd.DataFrame(columns, index=log.index)
    force = turned[list(ACCEL)].mean().to_numpy()
    if not points_up(force):
        shown = ", ".join(f"{value:.2f}" for value in force)
        angles = ", ".join(f"{name}_deg: {one:.4g}" for name, one in zip(ATTITUDE, np.degrees(mounting), strict=True))
        raise ValueError(
            f"drive: expected a mean specific force that points up, accel_z near -9.8 m/s^2; found {shown} m/s^2 "
            + (f"with mounting: {{{angles}}}, which gravity contradicts" if any(mounting) else
               "(give the mounting of the device)")
        )  # fmt: skip
    return turned


def points_up(force: np.ndarray) -> bool:
    """Return whether a mean specific force in the axes of the vehicle, shape (3,), is that against gravity."""
    return bool(-force[2] > STEEPEST * np.linalg.norm(force))


def keeps_recognised_axes(recording: Recording, mounting: tuple[float, float, float]) -> bool:
    """Return whether a mounting turns the axes that were recognised upright, and not those of the file.

    A mounting by heading alone of a device with z up is one in the recognised axes, forward, right and down; one with a
    roll of 180 deg is one in those of the file.
    """
    force = recording.table[list(ACCEL)].mean().to_numpy(copy=True)
    own = frame.rotation_of(recording.frame).T @ force
    turn = from_euler(np.array(mounting))
    return (
        recording.frame in (frame.CANONICAL, "FLU") and points_up(turn.apply(force)) and not points_up(turn.apply(own))
    )
