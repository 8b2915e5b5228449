"""Command ``indices``: print performance indices of static runs in data-sheet units, and write them in SI."""

import argparse
import sys

import pandas as pd

from imugap.analysis.indices import indices
from imugap.atomic import atomic
from imugap.commands.arguments import add_examples, add_gravity, positive
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.commands.shown import interval_text, number, table_text
from imugap.estimation.indices import INDICES
from imugap.units import from_si


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap indices run1.csv run2.csv --out indices.csv")
    parser.add_argument("log", nargs="+", help=f"{LOG_HELP}; one per run")
    parser.add_argument("--period", type=positive, default=1.0, help="averaging period of the bias stability [s]")
    add_gravity(parser)
    add_reading(parser)
    parser.add_argument("--out", help="CSV file for the indices in SI units")


def run(options: argparse.Namespace) -> None:
    """Compute the indices over the logs, print them, and write them to ``--out``."""
    require_files({"--out": options.out}, options.log)
    settings = settings_of(options)
    found = indices((read(path, settings).recording for path in options.log), options.period, options.gravity)
    for remark in found.remarks:
        print(f"imugap: {remark}", file=sys.stderr)
    if options.out:
        with atomic(options.out) as partial:
            found.table.to_csv(partial, index=False)
    print(_shown(found.table))


def _shown(found: pd.DataFrame) -> str:
    """Return the indices in data-sheet units as a table, upper bounds marked."""
    rows = []
    for row in found.itertuples():
        unit = INDICES[row.symbol].unit(row.axis)
        value, low, high = (from_si(one, unit) for one in (row.value, row.low, row.high))
        kind = "" if row.holds else "upper bound"
        rows.append([row.axis, row.symbol, number(value), interval_text(low, high), unit, str(row.runs), kind])
    return table_text(["axis", "index", "value", "95 % interval", "unit", "runs", ""], rows)
