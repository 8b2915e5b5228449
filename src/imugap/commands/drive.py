"""Command ``drive``: navigate a drive by device and receiver, write a folder, and print the verdict."""

import argparse
import sys

from imugap.analysis.drive_settings import DriveSettings
from imugap.api import logs
from imugap.api.drives import MODEL_FILE, SETTINGS_FILE, drive, in_axes_of_mounting
from imugap.commands.arguments import add_effects, add_examples
from imugap.commands.outputs import FOLDER_HELP, add_format, add_json, json_text, require_folder
from imugap.commands.reading import LOG_HELP, add_reading, say, settings_of
from imugap.io.fixes import reading as fixes
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.pages.drive import consistency, drift_text, events, extent
from imugap.pages.shown import summary_text

FILES = (
    "report.html", "solution.parquet", "smoothed.parquet", "events.csv", "outages.csv", "settings.yaml", "model.yaml",
    "summary.json", "inputs.json", "path.geojson", "path.kml", "track.svg", "motion.svg", "sensors.svg", "quality.svg",
)  # fmt: skip
"""Files of the folder."""
DISAGREES = 3
"""Exit code of ``--strict`` where device and fixes do not agree."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap drive imu.csv solution.pos --config car.yaml --out drive")
    parser.description = (
        "Navigate a drive. The axes of the device are x forward, z down, or turned as --config says. The fixes have "
        "latitude and longitude in degrees, the height in metres above the ellipsoid and, if known, vel_n vel_e vel_d "
        "[m/s] and standard deviations sd_n sd_e sd_d [m], sd_vel_n sd_vel_e sd_vel_d [m/s]. The first line says "
        "whether device and fixes agree. What they contradict each other in (a time offset, a lever arm, held fixes, "
        "the noise of the receiver ...) is named there, with the setting that corrects it, and corrected."
    )
    parser.add_argument("log", help=f"{LOG_HELP}; six axes")
    parser.add_argument(
        "fixes",
        help="fixes of a GNSS receiver on the clock of the device: table with a header, RTKLIB .pos, NMEA, GPX, text "
        "of KF-GINS, a bag with sensor_msgs/NavSatFix, a PX4 log, or output of gnss-ins-sim",
    )
    parser.add_argument("--config", help="device, mounting, lever arm, quality control (YAML)")
    add_effects(parser)
    parser.add_argument("--as-given", action="store_true", help="use settings and fixes as they are, and only judge")
    parser.add_argument("--strict", action="store_true", help=f"exit with code {DISAGREES} where they do not agree")
    contents = "solution, events, summary, figures, and the path for maps"
    parser.add_argument("--out", required=True, help=FOLDER_HELP.format(contents))
    add_json(parser)
    add_format(parser)
    add_reading(parser)
    parser.add_argument("--fixes-topic", help="topic of a bag, or message of a log, with the fixes")
    parser.add_argument("--fixes-angles", choices=("deg", "rad"), help="unit of latitude and longitude in a table")


def run(options: argparse.Namespace) -> int:
    """Navigate the drive, write the folder ``--out``, print verdict and summary; return the exit code."""
    folder = require_folder(options.out, FILES, (options.log, options.fixes, options.config))
    settings, reading = DriveSettings.read(options.config, options.effects), settings_of(options)
    say(options.config, settings.recognised)
    log = in_axes_of_mounting(logs.read(options.log, reading), settings)
    say(options.log, log.recognised)
    receiver = fixes.read(options.fixes, ReceiverSettings(options.fixes_topic, options.fixes_angles))
    say(options.fixes, receiver.recognised)
    found = drive(log, receiver, config=options.config, effects=options.effects, as_given=options.as_given)
    report = found.made_by(options.command_line).report(folder, options.format)
    summary = found.summary
    if options.json and not found.agrees:
        print(f"imugap: {options.log}, {options.fixes}: {' '.join(found.verdict.splitlines())}", file=sys.stderr)
    happened = ", ".join(" ".join(row) for row in events(summary)) or "none"
    rows = (
        *extent(summary), drift_text(summary), ("NIS", consistency(summary)), ("events at fixes", happened),
        ("settings in use", f"{report.parent / SETTINGS_FILE}, with {MODEL_FILE}"),
    )  # fmt: skip
    print(json_text(summary) if options.json else summary_text(found.verdict, rows, report))
    return DISAGREES if options.strict and not found.agrees else 0
