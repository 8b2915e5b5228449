"""Write an error model in the form that a filter or a simulator reads."""

import argparse

from imugap.atomic import atomic
from imugap.commands.arguments import add_examples, positive
from imugap.commands.outputs import require_files
from imugap.commands.reduction import add_rule, rule_of
from imugap.interchange.export import Target, export
from imugap.model import ErrorModel


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap export model.yaml --to kalibr --rate 200 --out imu.yaml")
    parser.add_argument("model", help="error model (YAML)")
    parser.add_argument("--to", required=True, help=", ".join(Target))
    parser.add_argument("--rate", type=positive, required=True, help="sampling rate [Hz]")
    add_rule(parser)
    parser.add_argument("--out", required=True, help="file to write")


def run(options: argparse.Namespace) -> None:
    """Export the model to ``--out``."""
    require_files({"--out": options.out}, [options.model])
    text = export(ErrorModel.read(options.model), Target.of(options.to), rule_of(options, options.rate))
    with atomic(options.out) as partial:
        partial.write_text(text)
