"""Command ``check``: print a verdict on each recording, its findings with their consequences, and its axes."""

import argparse
from textwrap import wrap

import pandas as pd

from imugap.analysis.check import COMMANDS, RecordingCheck
from imugap.api.checks import Checked, check
from imugap.commands.arguments import add_examples
from imugap.commands.outputs import FOLDER_HELP, add_json, json_text, require_folder
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.log import LogError

FILES = ("report.html", "inputs.json", "facts.json")
"""Files of the folder."""
SMALLEST_STEP = 1e-6
"""Step of a lattice, relative to the range of the values, below which it is that of the file."""
WIDTH, COLUMN = 100, 10
"""Columns of a line, and of a consequence in it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap check imu.bag --topic /imu/data",
        "imugap check log.csv --units gyro=deg/s,accel=g --frame FLU",
    )
    parser.description = (
        "Check recordings. First a verdict: usable or not, and for which commands; then, if any, the findings with "
        "their consequences, and a table of the axes. The page has the table in any case."
    )
    parser.add_argument("log", nargs="+", help=LOG_HELP)
    add_json(parser)
    parser.add_argument("--out", help=FOLDER_HELP.format("facts"))
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Check each recording and print the result; the first LogError ends the command after all are checked."""
    folder = None if options.out is None else require_folder(options.out, FILES, options.log)
    failed, facts, sound = None, [], []
    for path in options.log:
        try:
            sound.append(check(read(path, settings_of(options))))
        except LogError as error:
            failed = failed or error
            facts.append({"source": path, "verdict": f"not usable: {error}"})
            if not options.json:
                print(f"{path}: not usable")
            continue
        facts += sound[-1].facts()
        if not options.json:
            print(shown(*sound[-1].checks))
    if options.json:
        print(json_text(facts))
    if folder is not None and sound:
        Checked.together(sound).made_by(options.command_line).report(folder)
    if failed is not None:
        raise failed


def shown(found: RecordingCheck) -> str:
    """Return the verdict, the findings with their consequences, and the table of the axes, as text."""
    lines = wrap(f"{found.source}: {found.verdict}", WIDTH, subsequent_indent="  ")
    if not found.findings:
        return "\n".join(lines)
    width = WIDTH - COLUMN * len(COMMANDS)
    lines += ["", "finding".ljust(width) + "".join(name.rjust(COLUMN) for name in COMMANDS)]
    for one in found.findings:
        first, *others = wrap(one.text, width - 1)
        lines.append((first.ljust(width) + "".join((text or "-").rjust(COLUMN) for text in one.consequences)).rstrip())
        lines += [f"  {other}" for other in others]
    shown_as = {"axis": "axis", "nan": "lost", "minimum": "least", "maximum": "most", "lattice": "step"}
    table = pd.DataFrame(found.facts["axes"])[list(shown_as)].rename(columns=shown_as)
    step = table["step"].astype(float)
    table["step"] = step.where(step > SMALLEST_STEP * (table["most"] - table["least"]))
    return "\n".join([*lines, "", table.to_string(index=False, float_format=lambda value: f"{value:.4g}", na_rep="-")])
