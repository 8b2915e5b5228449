"""The command line: the library on logs of one's own (canonical CSV or Parquet)."""

import argparse
import json
import sys
from math import inf

import pandas as pd

from imugap import integrity, log, readers
from imugap.atomic import atomic
from imugap.indices import INDICES, of_run, over_runs, shortest
from imugap.model import ErrorModel
from imugap.units import from_si


def main(arguments: list[str] | None = None) -> int:
    """Run one subcommand; a fault in the input is one message and exit code 1."""
    options = _parser().parse_args(arguments)
    try:
        options.run(options)
    except (ValueError, OSError) as error:
        print(f"imugap: {error}", file=sys.stderr)
        return 1
    return 0


def check(options: argparse.Namespace) -> None:
    """Print the integrity of each log; then read it strictly, so that a log that passes is usable."""
    for path in options.log:
        report = integrity.report(readers.read_table(path))
        print(f"{path}\n{json.dumps(report.facts(), indent=1)}\n{report.to_frame().to_string()}")
        readers.read(path)


def indices(options: argparse.Namespace) -> None:
    """Print the performance indices over the logs in data-sheet units; write them in SI to ``--out``."""
    tables = [readers.read(path) for path in options.log]
    ideal = pd.Series(0.0, index=list(log.AXES))
    ideal["accel_z"] = -options.gravity
    symbols = tuple(symbol for symbol in INDICES if symbol != "repeatability")
    runs = {
        run: of_run(table, ideal, options.period, _shown_by(symbols, table, options.period))
        for run, table in enumerate(tables, start=1)
    }
    found = over_runs(pd.concat(runs, names=["run"]).reset_index("run").reset_index(drop=True))
    units = [INDICES[row.symbol].unit(row.axis) for row in found.itertuples()]
    shown = found.assign(unit=units)
    for column in ("value", "low", "high"):
        shown[column] = [from_si(value, unit) for value, unit in zip(found[column], units, strict=True)]
    print(
        shown.assign(kind=shown["holds"].map({True: "", False: "upper bound"}))
        .drop(columns="holds")
        .to_string(index=False)
    )
    if options.out:
        with atomic(options.out) as partial:
            found.to_csv(partial, index=False)


def simulate(options: argparse.Namespace) -> None:
    """Write the static log that a device with the given error model would have written."""
    count = round(options.duration * options.rate)
    model = ErrorModel.read(options.model)
    ideal = {axis: [-options.gravity if axis == "accel_z" else 0.0] * count for axis in log.AXES if axis in model.axes}
    measured = model.simulate(log.from_samples(ideal, 1 / options.rate), options.seed, "simulate")
    log.write(measured, options.out)


def _shown_by(symbols: tuple[str, ...], table: pd.DataFrame, period: float) -> tuple[str, ...]:
    """Return the indices that a log of this length can show, and say which it cannot."""
    needed = {symbol: shortest(symbol, period, log.interval(table)) for symbol in symbols}
    able = tuple(symbol for symbol in symbols if log.duration(table) >= needed[symbol])
    for symbol in symbols:
        if symbol not in able:
            found = f"{needed[symbol]:g} s; found {log.duration(table):g} s"
            print(f"imugap: {INDICES[symbol].title}: expected at least {found}", file=sys.stderr)
    if not able:
        raise ValueError(f"log: expected at least {min(needed.values()):g} s; found {log.duration(table):g} s")
    return able


def _positive(text: str) -> float:
    """Read an option that is a finite number above zero."""
    value = float(text)
    if not 0 < value < inf:
        raise argparse.ArgumentTypeError(f"expected a finite number > 0; found {text}")
    return value


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="imugap", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    gravity = {"type": _positive, "default": 9.80665, "help": "local gravity [m/s^2] (default %(default)s)"}

    one = commands.add_parser("check", help="report on stamps, gaps, stuck and saturated samples, lattice, gravity")
    one.add_argument("log", nargs="+", help="canonical CSV or Parquet log")
    one.set_defaults(run=check)

    one = commands.add_parser("indices", help="performance indices of static runs of one device")
    one.add_argument("log", nargs="+", help="canonical CSV or Parquet log, one per run")
    one.add_argument("--period", type=_positive, default=1.0, help="averaging period of the bias stability [s]")
    one.add_argument("--gravity", **gravity)
    one.add_argument("--out", help="CSV file for the indices in SI units")
    one.set_defaults(run=indices)

    one = commands.add_parser("simulate", help="static log of a device with an error model")
    one.add_argument("model", help="error model (YAML)")
    one.add_argument("--duration", type=_positive, required=True, help="length [s]")
    one.add_argument("--rate", type=_positive, required=True, help="sampling rate [Hz]")
    one.add_argument("--gravity", **gravity)
    one.add_argument("--seed", type=int, default=0)
    one.add_argument("--out", required=True, help="Parquet or CSV file")
    one.set_defaults(run=simulate)
    return parser
