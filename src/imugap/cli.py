"""The command line: the library on logs of one's own (canonical CSV or Parquet)."""

import argparse
import json
import os
import sys
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from imugap import log
from imugap.atomic import atomic, write_together
from imugap.estimation import report as findings
from imugap.estimation.indices import INDICES, of_run, over_runs, shortest
from imugap.integrity import report as integrity
from imugap.interchange.conventions import HOUR, Rule, Triad
from imugap.interchange.export import Target
from imugap.interchange.export import export as exported
from imugap.interchange.plugins import catalogue
from imugap.io import readers
from imugap.model import ErrorModel
from imugap.units import from_si, to_si

AUTO = "auto"
"""The value of ``--terms`` that lets the log decide."""


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


def estimate(options: argparse.Namespace) -> None:
    """Estimate the stochastic effects on each axis of a log; print them and write them to ``--out``."""
    kinds = None if options.terms == AUTO else findings.kinds_of([name.strip() for name in options.terms.split(",")])
    inquiry = findings.EstimatorSettings(kinds, findings.Method(options.method), options.highest, options.robust)
    if options.figure and Path(options.figure).suffix != ".svg":
        raise ValueError(f"{options.figure}: file name: expected one that ends in .svg; found another")
    table = readers.read(options.log)
    asked = options.axis or log.axes(table)
    axes = [findings.known_name(axis, log.axes(table), "axis") for axis in dict.fromkeys(asked)]
    _say_gaps(table)
    interval = log.interval(table)
    found = [findings.estimate_axis(axis, table[axis].to_numpy(), interval, inquiry) for axis in axes]
    shown = findings.table(found)
    writers = {options.out: lambda path: path.write_text(findings.to_json(found))}
    if options.table:
        writers[options.table] = lambda path: shown.to_csv(path, index=False)
    if options.model:
        writers[options.model] = ErrorModel({one.axis: one.fit.model for one in found}).write
    if options.figure:
        from imugap.figures import estimation, save  # a figure takes longer to import than the rest

        figure = estimation.fitted(findings.curves(table, interval, found))
        writers[options.figure] = lambda path: save(figure, path)
    write_together(writers)
    print(shown.drop(columns=["method", "error"]).to_string(index=False))
    for one in found:
        print(f"{one.axis}: {one.verdict()}")


def simulate(options: argparse.Namespace) -> None:
    """Write the static log that a device with the given error model would have written."""
    model = ErrorModel.read(options.model, catalogue(options.effects))
    if not model.sensors:
        raise ValueError(f"{options.model}: expected a model of at least one sensor axis; found none")
    count = _count(options.duration * options.rate, len(model.sensors))
    still = {axis: -options.gravity if axis == "accel_z" else 0.0 for axis in log.AXES if axis in model.axes}
    ideal = {axis: np.full(count, value) for axis, value in still.items()}
    measured = model.simulate(log.from_samples(ideal, 1 / options.rate), options.seed, "simulate")
    log.write(measured, options.out)


def discover(options: argparse.Namespace) -> None:
    """Find where a simulator and a device disagree and name what is missing; write the folder ``--out``."""
    from imugap.commands import discover as dossier
    from imugap.discovery import report  # discovery takes longer to import than the rest
    from imugap.discovery.device import Question
    from imugap.discovery.inputs import Files

    reference, model = (None if path is None else Path(path) for path in (options.reference, options.model))
    files = Files(tuple(map(Path, options.log)), tuple(map(Path, options.test)), reference, model, options.effects)
    question = Question(alpha=options.alpha, seed=options.seed, workers=options.workers)
    with tqdm(bar_format="{l_bar}{bar}| {n_fmt}/{total_fmt} [{elapsed}]", leave=False) as bar:

        def progress(step: str, done: int, steps: int) -> None:
            bar.total, bar.n = steps, done
            bar.set_description(step)

        inquiry = dossier.compose(files, question, options.out, progress)
    print(report.verdict(inquiry.found))


def walk(options: argparse.Namespace) -> None:
    """Navigate a walk with the device on a foot; print its summary and write the folder ``--out``."""
    from imugap.commands import walk as walks  # compiled kernels take longer to import than the rest
    from imugap.navigation.pedestrian import Assumptions

    ground = Assumptions() if options.outdoors else walks.INDOORS
    assumptions = replace(ground, gravity=options.gravity, full_scale=to_si(options.full_scale, "g"))
    found = walks.compose(options.log, options.out, options.model, options.effects, assumptions)
    print(json.dumps(found, indent=1))


def drive(options: argparse.Namespace) -> None:
    """Navigate a drive by device and receiver; print its summary and write the folder ``--out``."""
    from imugap.commands import drive as drives  # compiled kernels take longer to import than the rest

    found = drives.compose(options.log, options.fixes, options.out, options.config, options.effects)
    print(json.dumps(found, indent=1))


def export(options: argparse.Namespace) -> None:
    """Write an error model as a filter or a simulator takes it."""
    rule = Rule(options.rate, options.horizon, options.correlation_time, Triad(options.triad))
    text = exported(ErrorModel.read(options.model), Target.of(options.to), rule)
    with atomic(options.out) as partial:
        partial.write_text(text)


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


def _say_gaps(table: pd.DataFrame) -> None:
    """Say where samples are lost: the estimates take them as evenly spaced."""
    timing = integrity.timing(table.index.to_numpy())
    if timing.gaps:
        found = f"{timing.gaps} gaps, the first at {timing.first_gap_s:g} s, the longest {timing.largest_gap_s:g} s"
        print(f"imugap: log: expected evenly spaced samples; found {found}", file=sys.stderr)


def _count(samples: float, axes: int) -> int:
    """Return the number of samples of a log that this machine can hold: its columns, and as many again to draw them."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    most = memory // (2 * 8 * (axes + 1))
    if samples > most:
        raise ValueError(f"simulate: expected a duration and rate of at most {most:.3g} samples; found {samples:.3g}")
    return round(samples)


def _positive(text: str) -> float:
    """Read an option that is a finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < inf:
        raise argparse.ArgumentTypeError(f"expected a finite number > 0; found {text}")
    return value


def _share(text: str) -> float:
    """Read an option that is a probability."""
    value = _positive(text)
    if value >= 1:
        raise argparse.ArgumentTypeError(f"expected a probability < 1; found {text}")
    return value


def _count_of(text: str) -> int:
    """Read an option that is a whole number above zero."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"expected a whole number > 0; found {text}")
    return int(text)


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

    one = commands.add_parser(
        "estimate",
        help="stochastic effects on each axis of a static log, with intervals",
        description="Estimate the stochastic effects on each axis of a static log. The JSON file is a list of one "
        "object per axis, in SI units; a limit that the log does not set is null.",
    )
    one.add_argument("log", help="canonical CSV or Parquet log")
    one.add_argument("--axis", nargs="+", help="axes (default all that the log has)")
    one.add_argument(
        "--terms",
        default=AUTO,
        help=f"effects, separated by commas, among {', '.join(kind.name for kind in findings.TERMS)} (gauss_markov may "
        f"be repeated), or {AUTO}: those that the log shows (default %(default)s)",
    )
    one.add_argument("--method", choices=[*findings.Method], default=findings.Method.LIKELIHOOD.value)
    one.add_argument("--highest", type=_positive, default=inf, help="leave the log out of account above [Hz]")
    one.add_argument("--robust", action="store_true", help="bound the effect of outliers (method wavelet)")
    one.add_argument("--table", help="CSV file for the estimates")
    one.add_argument("--figure", help="SVG file: Allan deviation of log and model")
    one.add_argument("--model", help="YAML file for the error model")
    one.add_argument("--out", required=True, help="JSON file for the estimates")
    one.set_defaults(run=estimate)

    one = commands.add_parser(
        "discover",
        help="where a simulator and a device disagree, what is missing from the model, and how far the gap shrinks",
        description="Find where logs of a device and simulations of its error model disagree, name the effects that "
        "are missing, add them, and show that the gap shrinks on data that no fit has seen.",
    )
    one.add_argument("log", nargs="+", help="canonical CSV or Parquet log, one per run of the device")
    one.add_argument("--test", nargs="+", default=[], help="further runs for the distances (default: end of the log)")
    one.add_argument("--reference", help="error-free log of the first run, for a device in motion")
    one.add_argument("--model", help="start model (YAML; default constant bias and white noise)")
    one.add_argument("--effects", help="module whose effects join the catalogue")
    one.add_argument(
        "--alpha", type=_share, default=0.01, help="probability of any name where nothing is missing (default 0.01)"
    )
    one.add_argument("--seed", type=int, default=0)
    one.add_argument("--workers", type=_count_of, default=2, help="processes (default %(default)s)")
    one.add_argument("--out", required=True, help="folder for report, model, tables and figures")
    one.set_defaults(run=discover)

    one = commands.add_parser(
        "walk",
        help="path of a foot with the device on it, corrected whenever the foot stands",
        description="Navigate a walk with the device on a foot. The log begins with a stand of half a second or more. "
        "Rows whose stamp does not exceed those before are left out, and lost samples filled.",
    )
    one.add_argument("log", help="canonical CSV or Parquet log of six axes")
    one.add_argument("--model", help="error model of the device (YAML; default that of a cheap one)")
    one.add_argument("--effects", help="module whose effects join the catalogue")
    one.add_argument("--gravity", **gravity)
    one.add_argument(
        "--full-scale",
        type=_positive,
        default=inf,
        metavar="G",
        help="full scale of the accelerometers [g], where heel strikes come near to it (default: none do)",
    )
    one.add_argument("--outdoors", action="store_true", help="do not take floors for level but for stairs and ramps")
    one.add_argument("--out", required=True, help="folder for solution, summary and figures")
    one.set_defaults(run=walk)

    one = commands.add_parser(
        "drive",
        help="path of a vehicle with the device and a GNSS receiver aboard, with quality control of the fixes",
        description="Navigate a drive. The axes of the device are x forward, z down, or turned as --config says. The "
        "fixes have latitude and longitude in degrees, the height in metres above the ellipsoid and, if known, "
        "vel_n vel_e vel_d [m/s] and standard deviations sd_n sd_e sd_d [m], sd_vel_n sd_vel_e sd_vel_d [m/s].",
    )
    one.add_argument("log", help="canonical CSV or Parquet log of six axes")
    one.add_argument("fixes", help="CSV or Parquet log of a GNSS receiver, on the clock of the device")
    one.add_argument("--config", help="device, mounting, lever arm, quality control (YAML)")
    one.add_argument("--effects", help="module whose effects join the catalogue")
    one.add_argument("--out", required=True, help="folder for solution, events, summary and figures")
    one.set_defaults(run=drive)

    one = commands.add_parser("simulate", help="static log of a device with an error model")
    one.add_argument("model", help="error model (YAML)")
    one.add_argument("--effects", help="module whose effects join the catalogue")
    one.add_argument("--duration", type=_positive, required=True, help="length [s]")
    one.add_argument("--rate", type=_positive, required=True, help="sampling rate [Hz]")
    one.add_argument("--gravity", **gravity)
    one.add_argument("--seed", type=int, default=0)
    one.add_argument("--out", required=True, help="Parquet or CSV file")
    one.set_defaults(run=simulate)

    one = commands.add_parser("export", help="error model as a filter or a simulator takes it")
    one.add_argument("model", help="error model (YAML)")
    one.add_argument("--to", required=True, help=", ".join(Target))
    one.add_argument("--rate", type=_positive, required=True, help="sampling rate [Hz]")
    one.add_argument(
        "--horizon", type=_positive, default=10.0,
        help="averaging time at which the Allan variance of the slow part is kept [s] (default %(default)s)",
    )  # fmt: skip
    one.add_argument(
        "--correlation-time", type=_positive,
        help=f"of the slow process, where the target has one [s] (default: its own if it is alone, or {HOUR:g})",
    )  # fmt: skip
    one.add_argument(
        "--triad", choices=list(Triad), default=Triad.MEAN_SQUARE, help="three axes to one number (default %(default)s)"
    )
    one.add_argument("--out", required=True, help="file to write")
    one.set_defaults(run=export)
    return parser
