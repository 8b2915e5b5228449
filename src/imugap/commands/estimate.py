"""Command ``estimate``: estimate the stochastic effects on each axis of a static log, write files, print the table.

All files are written, or none.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from math import inf
from pathlib import Path

from imugap.api.estimates import Estimated, estimate
from imugap.atomic import is_stream, write_together
from imugap.commands.arguments import add_examples, add_gravity, positive
from imugap.commands.outputs import (
    FOLDER_HELP,
    add_format,
    format_of,
    require_files,
    require_folder,
    say_left_out,
    text_writers,
)
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.commands.reduction import add_rule
from imugap.estimation import report
from imugap.estimation.model_selection import TERMS
from imugap.estimation.report import Method
from imugap.interchange.export import Target
from imugap.log import AXES
from imugap.workflow.products import write_figure

AUTO = "auto"
"""The value of ``--terms`` that has the effects selected from the log."""
RECORDS = ".json"
"""Ending of a file for the estimates alone."""
OUTPUTS = ("table", "model", "figure")
FILES = ("report.html", "inputs.json", "estimates.json", "estimates.csv", "model.yaml", "allan.svg")
"""Files of the folder."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap estimate run.csv",
        "imugap estimate run.csv --to kalibr imu.yaml",
        "imugap estimate run.csv --axis gyro_x --terms white_noise,random_walk --out run.json --figure run.png",
    )
    parser.description = (
        "Estimate the stochastic effects on each axis of a static log. Knocks, outliers, stuck samples and gaps are "
        "left out and listed. The JSON file is a list of one object per axis, in SI units; a limit that the log does "
        "not set is null."
    )
    names = ", ".join(kind.name for kind in TERMS)
    parser.add_argument("log", help=LOG_HELP)
    axis = parser.add_argument("--axis", nargs="+", help="axes (default all that the log has)")
    axis.completer = lambda **_: list(AXES)
    parser.add_argument(
        "--terms", default=AUTO,
        help=f"effects, separated by commas, among {names} (gauss_markov may be repeated), or {AUTO}: those that the "
        "log shows (default %(default)s)",
    )  # fmt: skip
    parser.add_argument("--method", choices=[*Method], default=Method.LIKELIHOOD.value)
    parser.add_argument("--highest", type=positive, default=inf, help="leave the log out of account above [Hz]")
    parser.add_argument("--robust", action="store_true", help="bound the effect of outliers (method wavelet)")
    parser.add_argument("--table", help="CSV file for the estimates")
    parser.add_argument("--figure", help="file for the Allan deviation of log and model (.svg, .png, .pdf)")
    parser.add_argument("--model", help="YAML file for the error model")
    folder = FOLDER_HELP.format("estimates, model and figure")
    parser.add_argument("--out", help=f"{folder}; or a file {RECORDS} for the estimates alone")
    parser.add_argument(
        "--to", nargs=2, action="append", default=[], metavar=("TARGET", "FILE"),
        help=f"parameters for a filter or simulator ({', '.join(Target)}), and the file for them; may be "
        "repeated. What a target cannot hold is named as `export` does",
    )  # fmt: skip
    add_rule(parser)
    add_gravity(parser)
    add_format(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Estimate each axis of the log, write the files, and print the estimates."""
    if options.figure:
        format_of(options.figure)
    whole = options.out is not None and not _is_file(options.out)
    single = {f"--{name}": getattr(options, name) for name in (*(() if whole else ("out",)), *OUTPUTS)}
    require_files(single | {f"--to {Target.of(name)}": path for name, path in options.to}, [options.log])
    folder = require_folder(options.out, FILES, [options.log]) if whole else None
    terms = None if options.terms == AUTO else [name.strip() for name in options.terms.split(",")]
    found = estimate(
        read(options.log, settings_of(options)), axes=options.axis or (), terms=terms, method=options.method,
        highest=options.highest, robust=options.robust, gravity=options.gravity,
    )  # fmt: skip
    for remark in found.remarks:
        print(f"imugap: {remark}", file=sys.stderr)
    rule = {"horizon": options.horizon, "correlation_time": options.correlation_time, "triad": options.triad}
    files = {path: found.exported(name, **rule) for name, path in options.to}
    found = replace(found, asked={name: files[path].text for name, path in options.to})
    for file in files.values():
        say_left_out(file)
    texts = {place: text for path, file in files.items() for place, text in file.texts(path).items()}
    write_together(_writers(found, texts, options, whole))
    if folder is not None:
        found.made_by(options.command_line).report(folder, options.format)
    print(found)


def _is_file(path: str) -> bool:
    """Return whether ``--out`` names a file for the estimates alone."""
    return Path(path).suffix == RECORDS or Path(path).is_file() or is_stream(path)


def _writers(
    found: Estimated, texts: dict[str | Path, str], options: argparse.Namespace, whole: bool
) -> dict[str | Path, Callable[[Path], object]]:
    """Return the writer of each single file that is asked for."""
    writers = text_writers(texts)
    if options.out and not whole:
        writers[options.out] = lambda path: path.write_text(report.to_json(found.axes))
    if options.table:
        writers[options.table] = lambda path: found.table.to_csv(path, index=False)
    if options.model:
        writers[options.model] = found.model.write
    if options.figure:
        writers[options.figure] = lambda path: write_figure(found.plot(), path, format_of(options.figure))
    return writers
