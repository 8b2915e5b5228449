"""Command ``walk``: navigate a walk with the device on a foot, write a folder, and print the verdict."""

import argparse
import sys
from math import inf

from imugap.api.walks import walk
from imugap.commands.arguments import add_effects, add_examples, add_gravity, positive
from imugap.commands.outputs import FOLDER_HELP, add_format, add_json, json_text, require_folder
from imugap.commands.reading import LOG_HELP, MODEL_HELP, add_reading, read, say, settings_of
from imugap.pages.shown import summary_text
from imugap.pages.walk import extent

FILES = ("report.html", "solution.parquet", "strides.csv", "summary.json", "inputs.json", "plan.svg", "over_time.svg")
"""Files of the folder."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap walk foot.csv --outdoors --out walk")
    parser.description = (
        "Navigate a walk with the device on a foot. The log begins with a stand of 0.2 s or more (or --heading-free). "
        "Lost samples are filled, up to a tenth of a second."
    )
    parser.add_argument("log", help=f"{LOG_HELP}; six axes")
    parser.add_argument("--model", help=f"{MODEL_HELP} (default that of a cheap device)")
    add_effects(parser)
    add_gravity(parser)
    parser.add_argument(
        "--full-scale", type=positive, default=inf, metavar="G",
        help="full scale of the accelerometers [g], where heel strikes come near to it (default: none do)",
    )  # fmt: skip
    parser.add_argument("--outdoors", action="store_true", help="do not take floors for level but for stairs and ramps")
    parser.add_argument(
        "--heading-free", action="store_true",
        help="accept a log that begins in motion; heading zero is that of the foot at the first sample",
    )  # fmt: skip
    parser.add_argument("--out", required=True, help=FOLDER_HELP.format("solution, summary and figures"))
    add_json(parser)
    add_format(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Navigate the walk, write the folder ``--out``, and print verdict and summary."""
    folder = require_folder(options.out, FILES, (options.log, options.model))
    found = walk(
        read(options.log, settings_of(options)), model=options.model, effects=options.effects,
        gravity=options.gravity, full_scale=options.full_scale, outdoors=options.outdoors,
        heading_free=options.heading_free,
    )  # fmt: skip
    say(options.model, found.recognised("model"))
    if options.json and str(found.found.fit):
        print(f"imugap: {options.log}: {found.found.fit}", file=sys.stderr)
    report = found.made_by(options.command_line).report(folder, options.format)
    rows = ((title, value if std == "–" else f"{value} ± {std}") for title, value, std in extent(found.summary))
    print(json_text(found.summary) if options.json else summary_text(found.verdict, rows, report))
