"""Print the integrity of logs as read, before any repair; then read them strictly: a log that passes is usable."""

import argparse
import json

from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.integrity.report import report


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("log", nargs="+", help=LOG_HELP)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Print the integrity report of each log; a log that breaks the contract is a LogError."""
    settings = settings_of(options)
    for path in options.log:
        recording = read(path, settings)
        found = report(recording.table)
        print(f"{path}\n{json.dumps(found.facts(), indent=1)}\n{found.to_frame().to_string()}")
        _ = recording.log
