"""Print the performance indices of static runs of one device in data-sheet units, and write them in SI.

Stages: read the logs; leave out knocks, outliers, stuck samples and gaps; compute the indices of each run; combine the
runs; show and write them.
"""

import argparse
import sys

import pandas as pd

from imugap import log
from imugap.atomic import atomic
from imugap.commands.arguments import add_examples, add_gravity, positive
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.commands.shown import interval_text, number, table_text
from imugap.estimation.gap_draws import with_gaps_drawn
from imugap.estimation.indices import INDICES, ROUND_OFF, IndexSamples, of_samples, over_runs, shortest
from imugap.estimation.screening import screen
from imugap.integrity.regular import Regular
from imugap.stream import stream
from imugap.units import from_si

SEED = 0
"""Seed of the samples that are drawn where the log has none that is undisturbed."""


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
    ideal = pd.Series(0.0, index=list(log.AXES))
    ideal["accel_z"] = -options.gravity
    settings = settings_of(options)
    runs = {
        number: _of_run(path, read(path, settings).require_gravity().regular, ideal, options.period)
        for number, path in enumerate(options.log, start=1)
    }
    found = over_runs(pd.concat(runs, names=["run"]).reset_index("run").reset_index(drop=True))
    if options.out:
        with atomic(options.out) as partial:
            found.to_csv(partial, index=False)
    print(_shown(found))


def _of_run(path: str, found: Regular, ideal: pd.Series, period: float) -> pd.DataFrame:
    """Return the indices of one run, its disturbed samples left out; each is a line on stderr."""
    if not found.samples:
        raise ValueError(f"{path}: columns: expected an axis that varies; found {'; '.join(found.unusable.values())}")
    for remark in found.remarks:
        print(f"imugap: {path}: {remark}", file=sys.stderr)
    duration = min(len(one.values) * one.interval for one in found.samples.values())
    symbols = _computable(duration, period, max(one.interval for one in found.samples.values()))
    parts = []
    for axis, one in found.samples.items():
        screened = screen(one.values, stream(SEED, "indices", axis))
        for sentence in screened.sentences(one.interval, one.begin):
            print(f"imugap: {path}: {axis}: {sentence}", file=sys.stderr)
        values = with_gaps_drawn(screened, one.interval, stream(SEED, "gaps", axis))
        drawn = IndexSamples(axis, values, screened.replaced, one.interval)
        parts.append(of_samples(drawn, ideal[axis], period, symbols))
    return pd.concat(parts, ignore_index=True)


def _computable(duration: float, period: float, interval: float) -> tuple[str, ...]:
    """Return the indices for which a log of a duration [s] is long enough; warn of the others."""
    needed = {symbol: shortest(symbol, period, interval) for symbol in INDICES if symbol != "repeatability"}
    for symbol, least in needed.items():
        if duration < least * (1 - ROUND_OFF):
            title = INDICES[symbol].title
            print(f"imugap: {title}: expected at least {least:g} s; found {duration:g} s", file=sys.stderr)
    if duration < min(needed.values()) * (1 - ROUND_OFF):
        raise ValueError(f"log: expected at least {min(needed.values()):g} s; found {duration:g} s")
    return tuple(symbol for symbol, least in needed.items() if duration >= least * (1 - ROUND_OFF))


def _shown(found: pd.DataFrame) -> str:
    """Return the indices in data-sheet units as a table, upper bounds marked."""
    rows = []
    for row in found.itertuples():
        unit = INDICES[row.symbol].unit(row.axis)
        value, low, high = (from_si(one, unit) for one in (row.value, row.low, row.high))
        kind = "" if row.holds else "upper bound"
        rows.append([row.axis, row.symbol, number(value), interval_text(low, high), unit, str(row.runs), kind])
    return table_text(["axis", "index", "value", "95 % interval", "unit", "runs", ""], rows)
