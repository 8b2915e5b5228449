"""Command ``convert``: write a recording of any format as a canonical Parquet log, in constant memory.

Stages: recognise the conversion on stretches of the recording; read, convert and write it part by part.
"""

import argparse

from imugap.atomic import is_stream
from imugap.commands.arguments import add_examples
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, say, settings_of
from imugap.io import recording
from imugap.log import write_parts


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap convert flight.ulg --out flight.parquet",
        "imugap convert raw.txt --columns time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z --out raw.parquet",
    )
    parser.description = (
        "Write a recording as a canonical log: seconds, rad/s, m/s^2, z down. Stamps and samples stay as they are."
    )
    parser.add_argument("log", help=LOG_HELP)
    parser.add_argument("--out", required=True, help="Parquet file")
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Convert the recording, and say what was recognised."""
    if not options.out.endswith(".parquet") or is_stream(options.out):
        raise ValueError(f"{options.out}: file name: expected one that ends in .parquet; found another")
    require_files({"--out": options.out}, [options.log])
    found, parts = recording.stream(options.log, settings_of(options))
    rows = write_parts(parts, options.out)
    say(options.log, (f"{found.rate_hz:.5g} Hz", f"{rows} samples", *found.recognised))
