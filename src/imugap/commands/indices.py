"""Print the performance indices of static runs of one device in data-sheet units, and write them in SI.

Stages: read the logs; compute the indices of each run; combine the runs; show and write them.
"""

import argparse
import sys

import pandas as pd

from imugap import log
from imugap.atomic import atomic
from imugap.commands.arguments import add_gravity, positive
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.estimation.indices import INDICES, of_run, over_runs, shortest
from imugap.units import from_si


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("log", nargs="+", help=f"{LOG_HELP}; one per run")
    parser.add_argument("--period", type=positive, default=1.0, help="averaging period of the bias stability [s]")
    add_gravity(parser)
    add_reading(parser)
    parser.add_argument("--out", help="CSV file for the indices in SI units")


def run(options: argparse.Namespace) -> None:
    """Compute the indices over the logs, print them, and write them to ``--out``."""
    require_files({"--out": options.out}, options.log)
    ideal = pd.Series(0.0, index=list(log.AXES))
    ideal["accel_z"] = -options.gravity
    settings = settings_of(options)
    tables = [read(path, settings).require_gravity().log for path in options.log]
    runs = {
        number: of_run(table, ideal, options.period, _computable(table, options.period))
        for number, table in enumerate(tables, start=1)
    }
    found = over_runs(pd.concat(runs, names=["run"]).reset_index("run").reset_index(drop=True))
    if options.out:
        with atomic(options.out) as partial:
            found.to_csv(partial, index=False)
    print(_shown(found).to_string(index=False))


def _computable(table: pd.DataFrame, period: float) -> tuple[str, ...]:
    """Return the indices for which a log is long enough; warn of the others."""
    needed = {symbol: shortest(symbol, period, log.interval(table)) for symbol in INDICES if symbol != "repeatability"}
    duration = log.duration(table)
    for symbol, least in needed.items():
        if duration < least:
            title = INDICES[symbol].title
            print(f"imugap: {title}: expected at least {least:g} s; found {duration:g} s", file=sys.stderr)
    if duration < min(needed.values()):
        raise ValueError(f"log: expected at least {min(needed.values()):g} s; found {duration:g} s")
    return tuple(symbol for symbol, least in needed.items() if duration >= least)


def _shown(found: pd.DataFrame) -> pd.DataFrame:
    """Return the indices in data-sheet units, upper bounds marked."""
    shown = found.assign(unit=[INDICES[row.symbol].unit(row.axis) for row in found.itertuples()])
    for column in ("value", "low", "high"):
        shown[column] = [from_si(value, unit) for value, unit in zip(found[column], shown["unit"], strict=True)]
    return shown.assign(kind=shown["holds"].map({True: "", False: "upper bound"})).drop(columns="holds")
