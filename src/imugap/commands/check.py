"""Print the integrity of logs as read, before any repair; then read them strictly: a log that passes is usable."""

import argparse
import json

from imugap.integrity.report import report
from imugap.io import recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("log", nargs="+", help="canonical CSV or Parquet log")


def run(options: argparse.Namespace) -> None:
    """Print the integrity report of each log; a log that breaks the contract is a LogError."""
    for path in options.log:
        read = recording.read(path)
        found = report(read.table)
        print(f"{path}\n{json.dumps(found.facts(), indent=1)}\n{found.to_frame().to_string()}")
        _ = read.log
