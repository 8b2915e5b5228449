"""Estimate the stochastic effects on each axis of a static log, with intervals.

Stages::

    settings    options -> EstimatorSettings     effects, method, band; refused where the method cannot
    read        path -> Regular                  true samples of each axis, gaps as gaps
    estimate    axis -> AxisEstimate             imugap.estimation.report.estimate_axis; an axis may fail alone
    export      estimates -> text of a filter    with upper bounds for what the log does not show
    write       estimates -> files               JSON, table, model, figure, exports: all or none
    show        estimates -> verdicts, then a printed table
"""

import argparse
import sys
from math import inf

import numpy as np

from imugap import log
from imugap.atomic import write_together
from imugap.commands.arguments import add_examples, add_gravity, positive
from imugap.commands.outputs import format_of, require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.commands.reduction import add_rule, rule_of
from imugap.commands.shown import habit, interval_text, number, table_text
from imugap.effects.effect import AxisModel, Effect
from imugap.estimation import report
from imugap.estimation.model_selection import TERMS
from imugap.estimation.report import AxisEstimate, EstimatorSettings, Method
from imugap.integrity.regular import Regular
from imugap.interchange.export import PROGRAMS, Target, export
from imugap.interchange.start_bias import start_bias
from imugap.model import ErrorModel
from imugap.workflow.products import write_figure

AUTO = "auto"
"""The value of ``--terms`` that has the effects selected from the log."""
SYMBOLS = {
    "density": "N", "density_b": "B", "density_k": "K", "q": "Q", "slope": "R", "std": "std", "correlation_time": "T",
}  # fmt: skip
"""Symbol of a parameter in the printed table."""
OUTPUTS = ("out", "table", "model", "figure")


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
    axis.completer = lambda **_: list(log.AXES)
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
    parser.add_argument("--out", help="JSON file for the estimates")
    parser.add_argument(
        "--to", nargs=2, action="append", default=[], metavar=("TARGET", "FILE"),
        help=f"parameters for a filter or simulator ({', '.join(Target)}), and the file for them; may be repeated",
    )  # fmt: skip
    add_rule(parser)
    add_gravity(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Estimate each axis of the log, write the files, and print the estimates."""
    settings, exports = _settings(options), {path: Target.of(name) for name, path in options.to}
    outputs = {f"--{name}": getattr(options, name) for name in OUTPUTS}
    require_files(outputs | {f"--to {name}": path for name, path in options.to}, [options.log])
    found = read(options.log, settings_of(options)).regular
    if not found.samples:
        unusable = "; ".join(found.unusable.values())
        raise ValueError(f"{options.log}: columns: expected an axis that varies; found {unusable}")
    axes = _axes(found, options.axis)
    for remark in found.remarks:
        print(f"imugap: {remark}", file=sys.stderr)
    estimates = _estimated(found, axes, settings)
    texts = {path: _exported(estimates, found, target, options) for path, target in exports.items()}
    _write(estimates, texts, options)
    print(_shown(estimates))


def _settings(options: argparse.Namespace) -> EstimatorSettings:
    if options.figure:
        format_of(options.figure)
    kinds = None if options.terms == AUTO else report.kinds_of([name.strip() for name in options.terms.split(",")])
    return EstimatorSettings(kinds, Method(options.method), options.highest, options.robust)


def _axes(found: Regular, asked: list[str] | None) -> list[str]:
    """Return the axes asked for, each once; all that have samples where none are given."""
    for axis in asked or ():
        if axis in found.unusable:
            raise ValueError(f"axis: expected one that varies; found {found.unusable[axis]}")
    known = tuple(found.samples)
    return [report.known_name(axis, known, "axis") for axis in dict.fromkeys(asked or known)]


def _estimated(found: Regular, axes: list[str], settings: EstimatorSettings) -> list[AxisEstimate]:
    """Return the estimates of the axes that have one; an axis without is a line on stderr, none a ValueError."""
    estimates, errors = [], []
    for axis in axes:
        one = found.samples[axis]
        temperature = _temperature(found, len(one.values))
        try:
            estimates.append(report.estimate_axis(axis, one.values, one.interval, settings, temperature, one.begin))
        except ValueError as error:
            errors.append(error)
    if not estimates:
        raise errors[0]
    for error in errors:
        print(f"imugap: {error} (no estimate of this axis)", file=sys.stderr)
    return estimates


def _temperature(found: Regular, count: int) -> np.ndarray | None:
    """Return the readings of the temperature at ``count`` samples, or None where there are none at the same times."""
    if log.TEMPERATURE not in found.log or len(found.log) != count:
        return None
    readings = found.log[log.TEMPERATURE].interpolate(limit_direction="both").to_numpy()
    return readings if np.isfinite(readings).all() else None


def _exported(estimates: list[AxisEstimate], found: Regular, target: Target, options: argparse.Namespace) -> str:
    """Return the text of a file for a filter: estimates, bounds for what the log hides, and the bias that it shows."""
    rule = rule_of(options, float(number(1 / found.interval, digits=9)))
    axes = {one.axis: _present(one.fit.model) for one in estimates}
    levels = {one.axis: float(one.used.values.mean()) for one in estimates}
    for axis, (bias, spread) in start_bias(levels, options.gravity).items():
        axes[axis] = AxisModel((*axes[axis], bias, *((spread,) if target is Target.KF_GINS else ())))
    bounds: dict[str, tuple[Effect, ...]] = {}
    if target is not Target.IMUGAP and target not in PROGRAMS:
        bounds = {one.axis: limits for one in estimates if (limits := report.bounds(one))}
    return export(ErrorModel(axes), target, rule, bounds)


def _present(model: AxisModel) -> AxisModel:
    """Return a model without the processes of density zero."""
    return AxisModel(tuple(one for one in model if any(one.parameters().values())))


def _write(estimates: list[AxisEstimate], texts: dict[str, str], options: argparse.Namespace) -> None:
    """Write the files that are asked for, or none if one of them fails."""
    writers = {path: lambda to, text=text: to.write_text(text) for path, text in texts.items()}
    if options.out:
        writers[options.out] = lambda path: path.write_text(report.to_json(estimates))
    if options.table:
        writers[options.table] = lambda path: report.table(estimates).to_csv(path, index=False)
    if options.model:
        writers[options.model] = ErrorModel({one.axis: one.fit.model for one in estimates}).write
    if options.figure:
        from imugap.figures import estimation  # a figure takes longer to import than the rest

        figure = estimation.fitted(report.curves(estimates))
        writers[options.figure] = lambda path: write_figure(figure, path, format_of(options.figure))
    write_together(writers)


def _shown(estimates: list[AxisEstimate]) -> str:
    """Return the verdicts, those of models that do not fit their log first, and a table of the estimates."""
    bad = [one for one in estimates if not one.fits]
    good = [one for one in estimates if one.fits]
    lines = [f"{one.axis}: THE MODEL DOES NOT FIT THE LOG: {one.verdict()}" for one in bad]
    lines += [f"{one.axis}: {one.verdict()}" for one in good]
    rows = [row for one in estimates for row in _rows(one)]
    return "\n".join([*lines, "", table_text(["axis", "effect", "value", "95 % interval", "unit", "in use"], rows)])


def _rows(estimate: AxisEstimate) -> list[list[str]]:
    rows = []
    for one, unit in estimate.parameters():
        ordinal = f" {one.ordinal}" if one.effect == "gauss_markov" else ""
        name = f"{one.effect}{ordinal} {SYMBOLS.get(one.parameter, one.parameter)}"
        rows.append(
            [estimate.axis, name, number(one.value), interval_text(one.low, one.high), unit, habit(one.value, unit)]
        )
    return rows
