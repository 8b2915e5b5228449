"""The command line: the library on logs of one's own (canonical CSV or Parquet)."""

import argparse
import json
import sys
from pathlib import Path

import pandas as pd

from imugap import integrity, log, readers
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
        _replace(options.out, found.to_csv(index=False))


def simulate(options: argparse.Namespace) -> None:
    """Write the static log that a device with the given error model would have written."""
    count = round(options.duration * options.rate)
    model = ErrorModel.read(options.model)
    ideal = {axis: [-options.gravity if axis == "accel_z" else 0.0] * count for axis in log.AXES if axis in model.axes}
    measured = model.simulate(log.from_samples(ideal, 1 / options.rate), options.seed, "simulate")
    if Path(options.out).suffix == ".csv":
        _replace(options.out, measured.to_csv())
    else:
        log.write(measured, options.out)


def _shown_by(symbols: tuple[str, ...], table: pd.DataFrame, period: float) -> tuple[str, ...]:
    """Return the indices that a log of this length can show, and say which it cannot."""
    able = tuple(symbol for symbol in symbols if log.duration(table) >= shortest(symbol, period))
    for symbol in symbols:
        if symbol not in able:
            needed = f"{shortest(symbol, period):g} s; found {log.duration(table):g} s"
            print(f"imugap: {INDICES[symbol].title}: expected at least {needed}", file=sys.stderr)
    return able


def _replace(path: str, text: str) -> None:
    """Write under a temporary name, then rename."""
    target = Path(path)
    partial = target.with_name(target.name + ".partial")
    partial.write_text(text)
    partial.rename(target)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="imugap", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    gravity = {"type": float, "default": 9.80665, "help": "local gravity [m/s^2] (default %(default)s)"}

    one = commands.add_parser("check", help="report on stamps, gaps, stuck and saturated samples, lattice, gravity")
    one.add_argument("log", nargs="+", help="canonical CSV or Parquet log")
    one.set_defaults(run=check)

    one = commands.add_parser("indices", help="performance indices of static runs of one device")
    one.add_argument("log", nargs="+", help="canonical CSV or Parquet log, one per run")
    one.add_argument("--period", type=float, default=1.0, help="averaging period of the bias stability [s]")
    one.add_argument("--gravity", **gravity)
    one.add_argument("--out", help="CSV file for the indices in SI units")
    one.set_defaults(run=indices)

    one = commands.add_parser("simulate", help="static log of a device with an error model")
    one.add_argument("model", help="error model (YAML)")
    one.add_argument("--duration", type=float, required=True, help="length [s]")
    one.add_argument("--rate", type=float, required=True, help="sampling rate [Hz]")
    one.add_argument("--gravity", **gravity)
    one.add_argument("--seed", type=int, default=0)
    one.add_argument("--out", required=True, help="Parquet or CSV file")
    one.set_defaults(run=simulate)
    return parser
