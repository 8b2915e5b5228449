"""Command line of the benchmark: ``imu-benchmark COMMAND``."""

import argparse
import json
import secrets
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from imu_benchmark import answers, commitments, recipe, schema, summary
from imu_benchmark.baselines import BASELINES, answer_all, named
from imu_benchmark.schema import FormatError
from imu_benchmark.scores import confusion

CLEAR = 10.0
"""Size in detection limits from which an effect counts as clear."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, or 1 with one line where an input is not what it should be."""
    parsed = _parser().parse_args(arguments)
    try:
        parsed.run(parsed)
    except FormatError as error:
        print(f"imu-benchmark: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"imu-benchmark: expected the package {error.name} (pip install 'imu-benchmark[baselines]'); found none",
              file=sys.stderr)  # fmt: skip
        return 1
    return 0


def _make(given: argparse.Namespace) -> None:
    seed = secrets.randbits(128) if given.seed is None else given.seed
    commitments.make(seed, given.cases, recipe.read(given.recipe), given.public, given.secret)
    print(f"{given.cases} cases in {given.public}; keep {given.secret} until the answers are in")


def _verify(given: argparse.Namespace) -> None:
    print(f"{len(commitments.read_cases(given.public))} cases as the manifest says")


def _check(given: argparse.Namespace) -> None:
    cases = commitments.read_cases(given.public)
    answers.read_entry(given.entry, cases)
    print(f"{len(cases)} answers; SHA-256 {answers.digest(given.entry)}")


def _reveal(given: argparse.Namespace) -> None:
    commitments.reveal(given.secret, given.public)
    print(f"keys in {Path(given.public) / commitments.KEYS}")


def _score(given: argparse.Namespace) -> None:
    cases = commitments.read_cases(given.public)
    keys = commitments.read_keys(given.public)
    scored = [summary.scored(answers.read_entry(entry, cases), keys, given.clear) for entry in given.entries]
    names = [one.name for one in scored]
    if len(set(names)) < len(names):
        raise FormatError("entries", "", "folders of different names", ", ".join(names))
    together = summary.together(scored)
    if given.out:
        out = Path(given.out)
        out.mkdir(parents=True, exist_ok=True)
        together.to_csv(out / "summary.csv", index=False)
        for one in scored:
            _write_scores(one, given.clear, out / one.name)
    with pd.option_context("display.width", None, "display.max_columns", None, "display.max_colwidth", None):
        print(summary.table(together).to_string(index=False))


def _write_scores(one: summary.Scored, clear: float, folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    parts = {"cases": one.scores.cases, "effects": one.scores.effects, "parameters": one.scores.parameters}
    parts |= {"forecasts": one.forecasts, "confusion": confusion(one.scores.effects, clear).reset_index()}
    for name, table in parts.items():
        table.to_csv(folder / f"{name}.csv", index=False)


def _baseline(given: argparse.Namespace) -> None:
    answer_all(named(given.name), given.public, given.out)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("imu-benchmark", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: Callable, text: str) -> argparse.ArgumentParser:
        one = commands.add_parser(name, help=text, description=text)
        one.set_defaults(run=run)
        return one

    make = command("make", _make, "Make cases and keys: a folder to publish, and a file to keep.")
    make.add_argument("public", help="folder to publish, which is made")
    make.add_argument("--secret", required=True, help="file of plan and keys, which is made")
    make.add_argument("--cases", type=_positive, default=100, help="number of cases")
    make.add_argument("--recipe", help="recipe in TOML (default: that of the command recipe)")
    make.add_argument("--seed", type=int, help="seed (default: a random number of 128 bits)")
    command("recipe", lambda _: print(recipe.shipped(), end=""), "Print the recipe of this package.")
    command("schema", lambda _: print(json.dumps(schema.load("answer"), indent=1)), "Print the schema of an answer.")
    verify = command("verify", _verify, "Compare the files of a benchmark with its manifest.")
    check = command("check", _check, "Read the answers of an entry, and print the digest that fixes them.")
    reveal = command("reveal", _reveal, "Publish the keys beside the cases, if they are those of the manifest.")
    score = command("score", _score, "Score entries, if cases and keys are those of the manifest.")
    baseline = command("baseline", _baseline, "Answer the cases of a benchmark with a baseline.")
    check.add_argument("entry", help="folder with a folder for each case, which holds report.json")
    reveal.add_argument("secret", help="file of plan and keys")
    baseline.add_argument("name", choices=BASELINES)
    for one in (verify, check, reveal, score, baseline):
        one.add_argument("public", help="folder of the benchmark, with cases and manifest.json")
    score.add_argument("entries", nargs="+", metavar="entry", help="folder of the answers of a program")
    score.add_argument(
        "--clear", type=float, default=CLEAR, help="size from which effects are clear [detection limits]"
    )
    score.add_argument("--out", help="folder for the table and for the scores of each entry case by case")
    baseline.add_argument("--out", required=True, help="folder for the answers, which is made")
    return parser


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError
    return number
