"""Write an error model in the form that a filter or a simulator reads, or as a program that applies it."""

import argparse

from imugap.analysis.omission_distance import distance
from imugap.atomic import write_together
from imugap.commands.arguments import add_effects, add_examples, rate
from imugap.commands.outputs import require_files, say_left_out, text_writers
from imugap.commands.reading import MODEL_HELP, model_at, open_model
from imugap.commands.reduction import add_rule, rule_of
from imugap.interchange.export import NOTES, Target, exported


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap export model.yaml --to kalibr --rate 200 --out imu.yaml",
        "imugap export model.yaml --to cpp --rate 200 --out imu.hpp",
    )
    parser.add_argument("model", help=MODEL_HELP)
    add_effects(parser)
    target = parser.add_argument(
        "--to", required=True,
        help=f"{', '.join(Target)}; the last three are source code with all effects, seeded, one sample at a time. "
        "What a target cannot hold is named on the standard error, with its size and what it costs, and in the file; "
        f"of JSON, which has no comments, in a file beside it, *{NOTES}",
    )  # fmt: skip
    target.completer = lambda **_: list(Target)
    parser.add_argument("--rate", type=rate, required=True, help="sampling rate [Hz]")
    add_rule(parser)
    parser.add_argument("--out", required=True, help="file to write")


def run(options: argparse.Namespace) -> None:
    """Export the model to ``--out``."""
    require_files({"--out": options.out}, [options.model])
    model, target = model_at(open_model(options.model, options.effects), options.rate), Target.of(options.to)
    file = exported(model, target, rule_of(options, options.rate), distance=distance)
    say_left_out(file)
    write_together(text_writers(file.texts(options.out)))
