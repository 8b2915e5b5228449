"""Command ``discover``: find what the error model of a device lacks, write a folder, and print the verdict."""

import argparse
from dataclasses import replace

from tqdm import tqdm

from imugap.api.discoveries import ALPHA, discover
from imugap.api.logs import read
from imugap.commands.arguments import add_effects, add_examples, add_gravity, add_seed, count, probability
from imugap.commands.outputs import FOLDER_HELP, add_format, require_folder
from imugap.commands.reading import LOG_HELP, MODEL_HELP, add_reading, say, settings_of
from imugap.io.recognition.frame import AS_IS

FILES = (
    "report.html", "inputs.json", "report.json", "model.yaml", "described.yaml", "gaps.csv", "candidates.csv",
    "against_start.csv", "parameters.csv", "report.md", "places.svg", "surest.svg", "distance.svg", "drift.svg",
)  # fmt: skip
"""Files of the folder."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.set_defaults(own_progress=True)
    add_examples(parser, "imugap discover run1.csv --test run2.csv --model simulator.yaml --out found")
    parser.description = (
        "Find where logs of a device and simulations of its error model disagree, name the effects that are missing, "
        "add them, and show that the discrepancy shrinks on data that no fit has seen."
    )
    parser.add_argument("log", nargs="+", help=f"{LOG_HELP}; one per run of the device")
    parser.add_argument(
        "--test", nargs="+", default=[], help="further runs for the distances (default: end of the log)"
    )
    parser.add_argument(
        "--reference",
        help="error-free log of the first run, for a device in motion (samples within 30 of its ends are not used)",
    )
    parser.add_argument("--model", help=f"start {MODEL_HELP} (default constant bias and white noise)")
    add_effects(parser)
    parser.add_argument(
        "--alpha", type=probability, default=ALPHA,
        help="probability of any name where nothing is missing (default %(default)s)",
    )  # fmt: skip
    add_gravity(parser)
    add_seed(parser)
    parser.add_argument("--workers", type=count, default=2, help="processes (default %(default)s)")
    parser.add_argument("--out", required=True, help=FOLDER_HELP.format("model, tables and figures"))
    add_format(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Discover on the logs, write the folder ``--out``, and print the verdict."""
    inputs = (*options.log, *options.test, options.reference, options.model)
    folder = require_folder(options.out, FILES, inputs)
    reading = settings_of(options)
    reading = replace(reading, frame=reading.frame or AS_IS)
    with tqdm(bar_format="{l_bar}{bar}| {n_fmt}/{total_fmt} [{elapsed}]", leave=False, disable=None) as bar:

        def progress(step: str, done: int, steps: int) -> None:
            bar.total, bar.n = steps, done
            bar.set_description(step)

        found = discover(
            [read(path, reading) for path in options.log], test=[read(path, reading) for path in options.test],
            reference=options.reference, model=options.model, effects=options.effects, alpha=options.alpha,
            gravity=options.gravity, seed=options.seed, workers=options.workers, progress=progress,
        )  # fmt: skip
        found.made_by(options.command_line).report(folder, options.format)
    for path, sentences in found.found.recognised.items():
        say(path, sentences)
    print(found.verdict)
