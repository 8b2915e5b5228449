"""Command ``indices``: print performance indices of static runs in data-sheet units; write a table or a page."""

import argparse
import sys
from pathlib import Path

import pandas as pd

from imugap.api.indices import indices
from imugap.atomic import atomic, is_stream
from imugap.commands.arguments import add_examples, add_gravity, positive
from imugap.commands.outputs import FOLDER_HELP, add_format, require_files, require_folder
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.estimation.indices import INDICES
from imugap.pages.shown import interval_text, number, table_text
from imugap.units import from_si

FILES = ("report.html", "inputs.json", "indices.csv", "indices.svg")
"""Files of the folder."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap indices run1.csv run2.csv --out indices.csv", "imugap indices run.csv --out found")
    parser.add_argument("log", nargs="+", help=f"{LOG_HELP}; one per run")
    parser.add_argument("--period", type=positive, default=1.0, help="averaging period of the bias stability [s]")
    add_gravity(parser)
    add_reading(parser)
    parser.add_argument(
        "--out", help=f"{FOLDER_HELP.format('table and figure')}; or a file .csv for the table alone, SI"
    )
    add_format(parser)


def run(options: argparse.Namespace) -> None:
    """Compute the indices over the logs, print them, and write them to ``--out``."""
    whole = options.out is not None and not _is_file(options.out)
    folder = require_folder(options.out, FILES, options.log) if whole else None
    require_files({"--out": None if whole else options.out}, options.log)
    settings = settings_of(options)
    found = indices(*(read(path, settings) for path in options.log), period=options.period, gravity=options.gravity)
    for remark in found.remarks:
        print(f"imugap: {remark}", file=sys.stderr)
    if folder is not None:
        found.made_by(options.command_line).report(folder, options.format)
    elif options.out:
        with atomic(options.out) as partial:
            found.table.to_csv(partial, index=False)
    print(_shown(found.table))


def _is_file(path: str) -> bool:
    """Return whether ``--out`` names a file for the table alone."""
    return Path(path).suffix == ".csv" or Path(path).is_file() or is_stream(path)


def _shown(found: pd.DataFrame) -> str:
    """Return the indices in data-sheet units as a table, upper bounds marked."""
    rows = []
    for row in found.itertuples():
        unit = INDICES[row.symbol].unit(row.axis)
        value, low, high = (from_si(one, unit) for one in (row.value, row.low, row.high))
        kind = "" if row.holds else "upper bound"
        rows.append([row.axis, row.symbol, number(value), interval_text(low, high), unit, str(row.runs), kind])
    return table_text(["axis", "index", "value", "95 % interval", "unit", "runs", ""], rows)
