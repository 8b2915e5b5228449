"""The command line: the library on logs of one's own (canonical CSV or Parquet)."""

import argparse
import sys
from importlib import import_module

COMMANDS = {
    "check": "report on stamps, gaps, stuck and saturated samples, lattice, gravity",
    "indices": "performance indices of static runs of one device",
    "estimate": "stochastic effects on each axis of a static log, with intervals",
    "discover": "where a simulator and a device disagree, what the model lacks, and how far the discrepancy shrinks",
    "walk": "path of a foot with the device on it, corrected whenever the foot stands",
    "drive": "path of a vehicle with the device and a GNSS receiver aboard, with quality control of the fixes",
    "simulate": "static log of a device with an error model",
    "export": "error model as a filter or a simulator takes it",
}
"""Name of each module of :mod:`imugap.commands`, and its line of help."""


def main(arguments: list[str] | None = None) -> int:
    """Run one command; a fault in the input is one message and exit code 1."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = _parser(arguments[:1]).parse_args(arguments)
    try:
        options.run(options)
    except (ValueError, OSError) as error:
        print(f"imugap: {error}", file=sys.stderr)
        return 1
    return 0


def _parser(chosen: list[str]) -> argparse.ArgumentParser:
    """Return the parser of all commands; only the chosen one is imported and has its arguments."""
    parser = argparse.ArgumentParser(prog="imugap", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, title in COMMANDS.items():
        command = commands.add_parser(name, help=title)
        if name in chosen:
            module = import_module(f"imugap.commands.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return parser
