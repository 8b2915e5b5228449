"""Estimate the stochastic effects on each axis of a static log, with intervals.

Stages::

    settings    options -> EstimatorSettings     effects, method, band; refused where the method cannot
    read        path -> log                      checked; a warning where samples are lost
    axes        log -> names                     those asked for, or all
    estimate    axis -> AxisEstimate             imugap.estimation.report.estimate_axis
    write       estimates -> files               JSON, table, model, figure: all or none
    show        estimates -> printed table and verdicts
"""

import argparse
import sys
from math import inf
from pathlib import Path

import pandas as pd

from imugap import log
from imugap.atomic import write_together
from imugap.commands.arguments import positive
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.estimation import report
from imugap.estimation.model_selection import TERMS
from imugap.estimation.report import AxisEstimate, EstimatorSettings, Method
from imugap.integrity.report import timing
from imugap.io.recording import RecordingSettings
from imugap.model import ErrorModel
from imugap.workflow.products import write_svg

AUTO = "auto"
"""The value of ``--terms`` that has the effects selected from the log."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.description = (
        "Estimate the stochastic effects on each axis of a static log. The JSON file is a list of one object per axis, "
        "in SI units; a limit that the log does not set is null."
    )
    names = ", ".join(kind.name for kind in TERMS)
    parser.add_argument("log", help=LOG_HELP)
    parser.add_argument("--axis", nargs="+", help="axes (default all that the log has)")
    parser.add_argument(
        "--terms", default=AUTO,
        help=f"effects, separated by commas, among {names} (gauss_markov may be repeated), or {AUTO}: those that the "
        "log shows (default %(default)s)",
    )  # fmt: skip
    parser.add_argument("--method", choices=[*Method], default=Method.LIKELIHOOD.value)
    parser.add_argument("--highest", type=positive, default=inf, help="leave the log out of account above [Hz]")
    parser.add_argument("--robust", action="store_true", help="bound the effect of outliers (method wavelet)")
    parser.add_argument("--table", help="CSV file for the estimates")
    parser.add_argument("--figure", help="SVG file: Allan deviation of log and model")
    parser.add_argument("--model", help="YAML file for the error model")
    parser.add_argument("--out", required=True, help="JSON file for the estimates")
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Estimate each axis of the log, write the files, and print the estimates."""
    settings = _settings(options)
    require_files({f"--{name}": getattr(options, name) for name in ("out", "table", "model", "figure")}, [options.log])
    table = _read(options.log, settings_of(options))
    interval = log.interval(table)
    estimates = [
        report.estimate_axis(axis, table[axis].to_numpy(), interval, settings) for axis in _axes(table, options.axis)
    ]
    _write(estimates, table, options)
    _show(estimates)


def _settings(options: argparse.Namespace) -> EstimatorSettings:
    if options.figure and Path(options.figure).suffix != ".svg":
        raise ValueError(f"{options.figure}: file name: expected one that ends in .svg; found another")
    kinds = None if options.terms == AUTO else report.kinds_of([name.strip() for name in options.terms.split(",")])
    return EstimatorSettings(kinds, Method(options.method), options.highest, options.robust)


def _read(path: str, settings: RecordingSettings) -> pd.DataFrame:
    """Read a log; warn where samples are lost, because the estimates take them as evenly spaced."""
    table = read(path, settings).log
    found = timing(table.index.to_numpy())
    if found.gaps:
        gaps = f"{found.gaps} gaps, the first at {found.first_gap_s:g} s, the longest {found.largest_gap_s:g} s"
        print(f"imugap: log: expected evenly spaced samples; found {gaps}", file=sys.stderr)
    return table


def _axes(table: pd.DataFrame, asked: list[str] | None) -> list[str]:
    """Return the axes asked for, each once; all of the log where none are given."""
    known = log.axes(table)
    return [report.known_name(axis, known, "axis") for axis in dict.fromkeys(asked or known)]


def _write(estimates: list[AxisEstimate], table: pd.DataFrame, options: argparse.Namespace) -> None:
    """Write the files that are asked for, or none if one of them fails."""
    writers = {options.out: lambda path: path.write_text(report.to_json(estimates))}
    if options.table:
        writers[options.table] = lambda path: report.table(estimates).to_csv(path, index=False)
    if options.model:
        writers[options.model] = ErrorModel({one.axis: one.fit.model for one in estimates}).write
    if options.figure:
        from imugap.figures import estimation  # a figure takes longer to import than the rest

        figure = estimation.fitted(report.curves(table, log.interval(table), estimates))
        writers[options.figure] = lambda path: write_svg(figure, path)
    write_together(writers)


def _show(estimates: list[AxisEstimate]) -> None:
    print(report.table(estimates).drop(columns=["method", "error"]).to_string(index=False))
    for one in estimates:
        print(f"{one.axis}: {one.verdict()}")
