"""Options on how recordings are read, which all commands that read them have; and what was recognised, said."""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from imugap.api import logs
from imugap.api.logs import DeviceLog
from imugap.commands.arguments import rate
from imugap.interchange.plugins import catalogue
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io import configuration
from imugap.io.recognition.frame import AS_IS
from imugap.io.recognition.settings import given_rows
from imugap.io.recognition.unit_text import QUANTITIES
from imugap.io.recognition.units import given_units
from imugap.io.recording import RecordingSettings
from imugap.model import ErrorModel

SCHEMA = Path(__file__).with_name("reading.schema.yaml")
MODEL_HELP = (
    "error model: YAML, or a file of Gazebo (SDF), Kalibr, OpenVINS, VINS, KF-GINS, AirSim, gnss-ins-sim, Pegasus, "
    "Genesis or MATLAB (JSON of imuSensor), recognised by its content; or the name of a device (`imugap models`)"
)
LOG_HELP = "recording of the device: CSV of any dialect, Parquet, or another format that is recognised by its content"


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Add the options; each replaces what is recognised from the file."""
    group = parser.add_argument_group(
        "reading", "How the log is to be read, where its header and its content do not show it."
    )
    group.add_argument(
        "--columns", type=_listed, metavar="NAMES",
        help="separated by commas: a name for each column from left to right (time, gyro_x ..., - for one that is not "
        "read), or canonical=name in the file, or the columns to read",
    )  # fmt: skip
    group.add_argument(
        "--units", type=_listed, metavar="UNITS", help="such as gyro=deg/s,accel=g, accel=g/16384, accel=-g"
    )
    group.add_argument(
        "--frame", help=f"where x, y and z point (FLU, FRD, NED, ENU ...), roll,pitch,heading [deg], or {AS_IS}"
    )
    group.add_argument(
        "--rate", dest="sampling_rate", type=rate, metavar="HZ", help="rate of a log without stamps [Hz]"
    )
    group.add_argument("--time-unit", choices=QUANTITIES["time"], help="unit of the stamps")
    group.add_argument(
        "--topic", help="topic of a bag, message of a log, group of columns, or number of a run, with the samples"
    )
    group.add_argument(
        "--rows", metavar="K/N", help="row K of each N, where the rows of N devices alternate; 1/1 for one device"
    )
    group.add_argument("--reading", metavar="YAML", help="file with these options as keys")


def settings_of(options: argparse.Namespace) -> RecordingSettings:
    """Return the options as settings; those of the command line replace those of the file."""
    kept = {} if options.reading is None else configuration.read(options.reading, SCHEMA)
    given = {
        "columns": options.columns, "units": options.units, "frame": options.frame, "rate": options.sampling_rate,
        "time_unit": options.time_unit, "topic": options.topic, "rows": options.rows,
    }  # fmt: skip
    values = kept | {name: value for name, value in given.items() if value is not None}
    return RecordingSettings(
        tuple(values.get("columns") or ()), given_units(values.get("units") or ()), values.get("frame"),
        values.get("rate"), values.get("time_unit"), values.get("topic"),
        None if values.get("rows") is None else given_rows(values["rows"]),
    )  # fmt: skip


def read(path: str | Path, settings: RecordingSettings) -> DeviceLog:
    """Read a log, and say on the standard error what was recognised."""
    found = logs.read(path, settings)
    say(path, found.recognised)
    return found


def say(path: str | Path, sentences: Iterable[str]) -> None:
    """Print what was recognised in a file as one line on the standard error; nothing where it is canonical."""
    line = ", ".join(sentences)
    if line:
        print(f"imugap: {path}: {line}", file=sys.stderr)


def open_model(path: str | Path, effects: str | None) -> ModelFile:
    """Open an error model, of this library or of a simulator; ``effects`` names a module of further effects."""
    return ModelFile.open(path, catalogue(effects))


def model_at(opened: ModelFile, rate: float | None) -> ErrorModel:
    """Return the model of a file at a sampling rate [Hz], and say on the standard error what was recognised."""
    found = opened.at(rate)
    say(opened.path, found.remarks)
    return found.model


def _listed(text: str) -> list[str]:
    """Split at commas outside of brackets."""
    parts, depth = [""], 0
    for one in text:
        depth += (one in "([") - (one in ")]")
        if one == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += one
    return [part.strip() for part in parts]
