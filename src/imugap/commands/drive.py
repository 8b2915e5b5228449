"""The folder that a drive leaves: what filter and smoother say of it, what the quality control did, and figures."""

import argparse
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.atomic import write_together
from imugap.commands.arguments import add_effects
from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import (
    CLOSED,
    FAILED,
    LOOKED_BACK,
    OPENED,
    REMOVED,
    RESET,
    SET_ASIDE,
    WEIGHED,
    Quality,
)
from imugap.integrity.timestamps import filled
from imugap.interchange.plugins import catalogue
from imugap.io import gnss, readers
from imugap.io.configuration import ConfigurationError, configure
from imugap.log import ACCEL, AXES, GYRO, LogError, axes
from imugap.model import ErrorModel
from imugap.navigation.vehicle import Assumptions, Solution, navigate
from imugap.navigation.vehicle_alignment import Departure, depart
from imugap.numerics.rotation import from_euler

FILES = (
    "solution.parquet", "smoothed.parquet", "events.csv", "summary.json", "track.svg", "motion.svg", "sensors.svg",
    "quality.svg",
)  # fmt: skip
"""What is in the folder."""
STD = "_std"
"""Ending of the name of a standard deviation."""
SCHEMA = Path(__file__).with_name("drive.schema.yaml")
LONGEST_GAP_S = 0.5
"""Longest time without samples that a drive is navigated across [s]."""
STEEPEST = 0.5
"""Cosine of the largest angle between up and the mean specific force of a vehicle."""
COUNTED = (FAILED, WEIGHED, REMOVED, RESET, SET_ASIDE, OPENED, LOOKED_BACK, CLOSED)
"""Events whose number is in the summary."""
OUTAGE_S = 2.5
"""Time without a fix, in intervals of the fixes, from which on it counts as an outage."""
GYRO_CLASS = {"white_noise": {"density": 2e-4}, "gauss_markov": {"std": 5e-3, "correlation_time": 3600}}
ACCEL_CLASS = {"white_noise": {"density": 2e-3}, "gauss_markov": {"std": 0.1, "correlation_time": 3600}}
USUAL = ErrorModel.from_mapping(
    {axis: [GYRO_CLASS] for axis in GYRO} | {axis: [ACCEL_CLASS] for axis in ACCEL}
)  # fmt: skip
"""Errors of a sensor in a car of which nothing is known: those of a cheap device, shaken."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.description = (
        "Navigate a drive. The axes of the device are x forward, z down, or turned as --config says. The fixes have "
        "latitude and longitude in degrees, the height in metres above the ellipsoid and, if known, vel_n vel_e vel_d "
        "[m/s] and standard deviations sd_n sd_e sd_d [m], sd_vel_n sd_vel_e sd_vel_d [m/s]."
    )
    parser.add_argument("log", help="canonical CSV or Parquet log of six axes")
    parser.add_argument("fixes", help="CSV or Parquet log of a GNSS receiver, on the clock of the device")
    parser.add_argument("--config", help="device, mounting, lever arm, quality control (YAML)")
    add_effects(parser)
    parser.add_argument("--out", required=True, help="folder for solution, events, summary and figures")


def run(options: argparse.Namespace) -> None:
    """Navigate the drive, write the folder ``--out``, and print the summary."""
    found = compose(options.log, options.fixes, options.out, options.config, options.effects)
    print(json.dumps(found, indent=1))


@dataclass(frozen=True)
class Setting:
    """What a configuration says: model, mounting (Euler angles [rad]), and what goes to start and filter."""

    model: ErrorModel = USUAL
    mounting: tuple[float, float, float] = (0.0, 0.0, 0.0)
    assumptions: Assumptions = field(default_factory=Assumptions)
    quality: Quality = field(default_factory=Quality)
    departure: Departure = field(default_factory=Departure)

    @classmethod
    def read(cls, path: str | Path | None, effects: str | None = None) -> "Setting":
        """Read a configuration (YAML, described by ``drive.schema.yaml``); None stands for all defaults."""
        try:
            given = {} if path is None else yaml.safe_load(Path(path).read_text()) or {}
            if not isinstance(given, dict):
                raise ConfigurationError(f"expected keys and values; found {type(given).__name__}")
            values = configure(given, SCHEMA)
        except (ConfigurationError, yaml.YAMLError) as error:
            raise ConfigurationError(f"{path}: {' '.join(str(error).split())}") from error
        if values["model"] is None:
            return cls.of(values, USUAL)
        return cls.of(values, ErrorModel.read(Path(path).parent / values["model"], catalogue(effects)))

    @classmethod
    def of(cls, values: dict, model: ErrorModel) -> "Setting":
        """Take over a complete configuration."""
        arm, offset, scale = values["lever_arm"], values["time_offset"], values["scale_factor"]
        fix, quality, start, wheels = (values[name] for name in ("receiver", "quality", "start", "wheels"))
        assumptions = Assumptions(
            lever_m=(arm["x_m"], arm["y_m"], arm["z_m"]),
            lever_std=arm["std_m"],
            offset_s=offset["offset_s"],
            offset_std=offset["std_s"],
            scale_std=(scale["gyro_std"], scale["accel_std"]),
            scale_s=np.inf if scale["correlation_s"] is None else scale["correlation_s"],
            position_std=(fix["horizontal_m"], fix["horizontal_m"], fix["vertical_m"]),
            velocity_std=(fix["horizontal_m_per_s"], fix["horizontal_m_per_s"], fix["vertical_m_per_s"]),
            epoch_s=values["epoch_s"],
            wheels_std=wheels["std_m_per_s"],
            wheels_s=wheels["correlation_s"],
            axle_m=(wheels["x_m"], wheels["y_m"], wheels["z_m"]),
        )
        control = Quality(
            component=quality["component_sigma"],
            **{
                name: quality[name]
                for name in ("robust", "steepness", "false_alarm", "gated", "reset_s", "hindsight_s")
            },
        )
        course, heading, tilt = (np.radians(start[f"{name}_std_deg"]) for name in ("course", "heading", "tilt"))
        departure = Departure(
            speed=start["speed_m_per_s"], rest_s=start["rest_s"], course_std=course, heading_std=heading, tilt_std=tilt
        )
        mounting = tuple(np.radians([values["mounting"][f"{name}_deg"] for name in ("roll", "pitch", "heading")]))
        return cls(model, mounting, assumptions, control, departure)


@dataclass(frozen=True, eq=False)
class Driven:
    """A drive: what the filter says as it goes, what the smoother says when all is known, and the fixes."""

    filtered: Solution
    smoothed: Solution
    fixes: pd.DataFrame
    setting: Setting

    def summary(self) -> dict:
        """Return how far the drive went, what the quality control did, and how well filter and fixes agree.

        ``nis`` is the mean of the normalised innovations squared over their degrees of freedom, 1 for a filter that
        knows itself; ``nis_low`` and ``nis_high`` hold it in 95 of 100 such drives. ``sensors`` are the errors at the
        end, by the filter, with standard deviations.
        """
        one, record = self.filtered, self.filtered.record
        table, events = self.smoothed.trajectory, one.events["event"]
        time = one.fix_time
        gaps = np.diff(np.append(time, one.time[-1]))
        usual = float(np.median(np.diff(self.fixes.index)))
        long = gaps[gaps > OUTAGE_S * usual]
        freedom = int(record.freedom.sum())
        low, high = nees_band(freedom, 1)
        end, std = one.trajectory_std.iloc[-1], one.sensors_std.iloc[-1]
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
            "end_horizontal_std_m": np.hypot(end["north"], end["east"]),
            "end_heading_std_deg": np.degrees(end["heading"]),
        }
        sensors = {name: {"value": value, "std": std[name]} for name, value in one.sensors.iloc[-1].items()}
        plain = {name: value if isinstance(value, int) else float(value) for name, value in found.items()}
        return plain | {"sensors": {name: {key: float(v) for key, v in pair.items()} for name, pair in sensors.items()}}

    @staticmethod
    def table(one: Solution) -> pd.DataFrame:
        """Return Trajectory, place (degrees), standard deviations and errors of the sensors."""
        place = one.geodetic.assign(**{name: np.degrees(one.geodetic[name]) for name in ("latitude", "longitude")})
        parts = [one.trajectory, place, one.trajectory_std.add_suffix(STD)]
        return pd.concat([*parts, one.sensors, one.sensors_std.add_suffix(STD)], axis=1)


def driven(log: pd.DataFrame, fixes: pd.DataFrame, setting: Setting | None = None) -> Driven:
    """Navigate a drive; lost samples are filled, up to :data:`LONGEST_GAP_S` at a time."""
    setting = setting or Setting()
    if axes(log) != AXES:
        raise LogError("drive", "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    steps = np.diff(log.index.to_numpy())
    if steps.max() > LONGEST_GAP_S:
        found = f"{steps.max():.3g} s after {log.index[int(steps.argmax())]:g} s"
        raise ValueError(f"drive: expected gaps of at most {LONGEST_GAP_S:g} s; found {found}")
    due = fixes.index.to_numpy() + setting.assumptions.offset_s
    if due[0] >= log.index[-1] or due[-1] <= log.index[0]:
        spans = f"{log.index[0]:g} s to {log.index[-1]:g} s; found fixes from {due[0]:g} s to {due[-1]:g} s"
        raise ValueError(f"drive: expected fixes within the time of the log, {spans}")
    log = mounted(filled(log), setting.mounting)
    ellipsoid, states = gnss.origin(fixes), setting.assumptions.states(setting.model)
    start = depart(log, fixes, states, setting.assumptions, ellipsoid, setting.departure)
    given = log, fixes, setting.model, setting.assumptions, setting.quality, start, ellipsoid
    return Driven(navigate(*given), navigate(*given, smooth=True), fixes, setting)


def mounted(log: pd.DataFrame, mounting: tuple[float, float, float]) -> pd.DataFrame:
    """Return a log in the axes of the vehicle; a ValueError where its mean specific force does not point up there."""
    turn = from_euler(np.array(mounting))
    columns = {}
    for triad in (GYRO, ACCEL):
        turned = turn.apply(log[list(triad)].to_numpy(copy=True))
        columns |= dict(zip(triad, turned.T, strict=True))
    turned = pd.DataFrame(columns, index=log.index)
    force = turned[list(ACCEL)].mean().to_numpy()
    if not -force[2] > STEEPEST * np.linalg.norm(force):
        shown = ", ".join(f"{value:.2f}" for value in force)
        raise ValueError(
            f"drive: expected a mean specific force that points up, accel_z near -9.8 m/s^2; found {shown} m/s^2 "
            "(give the mounting of the device)"
        )
    return turned


def compose(
    log: str | Path, fixes: str | Path, out: str | Path, config: str | Path | None = None, effects: str | None = None
) -> dict:
    """Navigate the drive of two files, write all :data:`FILES` into the folder ``out``, and return the summary."""
    out = Path(out)
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out}: expected a folder; found a file")
    setting = Setting.read(config, effects)
    samples, seen = readers.read(log), readers.read_fixes(fixes)
    try:
        found = driven(samples, seen, setting)
    except ValueError as error:
        raise ValueError(f"{log}, {fixes}: {error}") from error
    write(found, out)
    return found.summary()


def write(found: Driven, out: str | Path) -> None:
    """Write all :data:`FILES` into the folder ``out``, or none if one of them fails."""
    from imugap.figures import drive, save  # figures take longer to import than to read and check the logs

    text = json.dumps(found.summary(), indent=1, allow_nan=False) + "\n"
    one, both = found.filtered, (found.filtered, found.smoothed)
    drawn = drive.track(*both, found.fixes), drive.motion(*both), drive.sensors(*both), drive.quality(one)
    writers = (
        found.table(one).to_parquet,
        found.table(found.smoothed).to_parquet,
        lambda path: one.events.to_csv(path, index=False),
        lambda path: path.write_text(text),
        *(lambda path, figure=figure: save(figure, path) for figure in drawn),
    )
    write_together({Path(out) / name: writer for name, writer in zip(FILES, writers, strict=True)})
