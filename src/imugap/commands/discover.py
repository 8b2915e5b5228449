"""The folder that discovery leaves: report, model, tables, page and figures."""

import argparse
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
from tqdm import tqdm

from imugap.commands.arguments import add_effects, add_examples, add_gravity, add_seed, count, probability
from imugap.commands.outputs import add_format, require_folder, write_folder
from imugap.commands.reading import LOG_HELP, MODEL_HELP, add_reading, say, settings_of
from imugap.discovery.device import Settings
from imugap.discovery.inputs import FileDiscovery, Files, discover_files
from imugap.discovery.report import candidate_table, describe_range, discrepancy_table, verdict
from imugap.discovery.steps import Progress

FILES = (
    "report.json", "model.yaml", "gaps.csv", "candidates.csv", "report.md",
    "places.svg", "surest.svg", "distance.svg", "drift.svg",
)  # fmt: skip
"""What is in the folder."""
LEAST = 1e-300
"""Probability below which a page gives no number."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
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
        "--alpha", type=probability, default=0.01,
        help="probability of any name where nothing is missing (default 0.01)",
    )  # fmt: skip
    add_gravity(parser)
    add_seed(parser)
    parser.add_argument("--workers", type=count, default=2, help="processes (default %(default)s)")
    parser.add_argument("--out", required=True, help="folder for report, model, tables and figures")
    add_format(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Discover on the logs, write the folder ``--out``, and print the verdict."""
    reference, model = (None if path is None else Path(path) for path in (options.reference, options.model))
    files = Files(
        tuple(map(Path, options.log)),
        tuple(map(Path, options.test)),
        reference,
        model,
        options.effects,
        settings_of(options),
    )
    settings = Settings(alpha=options.alpha, seed=options.seed, workers=options.workers, gravity=options.gravity)
    with tqdm(bar_format="{l_bar}{bar}| {n_fmt}/{total_fmt} [{elapsed}]", leave=False, disable=None) as bar:

        def progress(step: str, done: int, steps: int) -> None:
            bar.total, bar.n = steps, done
            bar.set_description(step)

        result = compose(files, settings, options.out, progress, options.format)
    for path, sentences in result.recognised.items():
        say(path, sentences)
    print(verdict(result.found))


def compose(
    files: Files,
    settings: Settings,
    out: str | Path,
    progress: Progress = lambda step, done, steps: None,
    formats: Sequence[str] = ("svg",),
) -> FileDiscovery:
    """Discover on files and write all :data:`FILES` into the folder ``out``, or none if anything fails."""
    out = require_folder(out, FILES, (*files.logs, *files.tests, files.reference, files.model))
    result = discover_files(files, settings, progress)
    write(result, out, formats)
    return result


def write(result: FileDiscovery, out: str | Path, formats: Sequence[str] = ("svg",)) -> None:
    """Write all :data:`FILES` into the folder ``out``, the figures in each format, or none if one of them fails."""
    from imugap.figures import discovery  # figures take longer to import than to read and check the files

    found = result.found
    discrepancies, candidates = discrepancy_table(found.discrepancies, found.unexplained), candidate_table(found)
    views = discovery.places(found, result.alpha), discovery.surest(found, result.alpha)
    drawn = (*views, discovery.distance(found), discovery.drift(found))
    contents = (result.report(), found.final, discrepancies, candidates, page(result, formats[0]), *drawn)
    write_folder(out, dict(zip(FILES, contents, strict=True)), formats)


def page(result: FileDiscovery, kind: str = "svg") -> str:
    """Return the report to read, in Markdown; it shows the figures of a format that lie beside it."""
    found = result.found
    logs = [f"- {role}: `{one['path']}`, {one['duration_s']:.6g} s at {one['rate_hz']:.6g} Hz; its first stamp, "
            f"{one['begin_s']:.10g} s, is time zero here"
            + "".join(f"; {sentence}" for sentence in result.recognised.get(one["path"], ()))
            for role, some in (("log", result.logs), ("test", result.tests)) for one in some]  # fmt: skip
    held_out = "the test logs" if result.tests else "the last part of the log"
    parts = [
        "# Where simulation and measurement disagree, and what is missing",
        "\n".join(logs),
        "## Verdict",
        "\n".join(f"- {line}" for line in verdict(found).splitlines()),
        "## Effects",
        _table(_effects(result)),
        "## Places",
        "Where the log leaves the start model:",
        _table(_places(found.discrepancies)),
        "Where it leaves the final model:",
        _table(_places(found.unexplained)),
        f"![The surest place of each view before and after](surest.{kind})",
        f"![Each place before and after](places.{kind})\n\nViews with a place, before (start model, held-in part) and "
        f"after (final model, whole log). Line: the log. Band: where {1 - result.alpha:.0%} of simulated logs stay "
        "everywhere. Bars: the places. Probabilities much below one in a hundred are extrapolated from simulations.",
        "## Distance",
        f"On {held_out}. The floor is how far simulations of the final model are from each other.",
        _table(_distances(result)),
        f"![Distance before and after](distance.{kind})",
        f"![Navigation drift before and after](drift.{kind})",
    ]  # fmt: skip
    return "\n\n".join(parts) + "\n"


def _effects(result: FileDiscovery) -> pd.DataFrame:
    rows = [
        (
            ", ".join(one.axes),
            one.name,
            "; ".join(f"{name} {_interval(end)} {end.unit}".removesuffix(" 1") for name, end in one.parameters.items()),
            ", ".join(name for name, _ in one.alternatives) or "-",
        )
        for one in result.found.findings
    ]
    return pd.DataFrame(rows, columns=["axes", "name", "parameters (95 %)", "not to be told from it"])


def _places(discrepancies) -> pd.DataFrame:
    rows = [
        (place.axis, place.view, describe_range(place), f"{place.p_value:.1e}" if place.p_value else f"< {LEAST:.0e}")
        for place in discrepancies
    ]
    return pd.DataFrame(rows, columns=["axis", "view", "where", "p-value"])


def _distances(result: FileDiscovery) -> pd.DataFrame:
    rows = [
        (name, *(_interval(getattr(apart, state)) for state in ("before", "after", "floor")))
        for name, apart in result.found.distances.items()
    ]
    return pd.DataFrame(rows, columns=["distance", "before", "after", "floor"])


def _interval(one) -> str:
    return f"{one.value:.4g} [{one.low:.4g}, {one.high:.4g}]"


def _table(table: pd.DataFrame) -> str:
    """Return a table in Markdown, or that there is nothing."""
    if table.empty:
        return "Nothing."
    rows = [list(table.columns), ["---"] * len(table.columns), *table.to_numpy().tolist()]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in rows)
