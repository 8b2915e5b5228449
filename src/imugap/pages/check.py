"""Page of a check: verdict, findings with their consequences, axes, and samples over time."""

from collections.abc import Sequence

from imugap.analysis.check import COMMANDS, RecordingCheck
from imugap.figures.log import quantities
from imugap.integrity.regular import Regular
from imugap.pages.page import Block, DataTable, Gallery, Page, Part, Picture, Text

COLUMNS = {"axis": "axis", "nan": "lost", "minimum": "least", "maximum": "most", "lattice": "step"}
"""Facts of an axis that are shown, and their titles."""


def page(checks: Sequence[RecordingCheck], logs: Sequence[Regular]) -> Page:
    """Compose the page of the checks of some logs."""
    verdict = tuple(f"{one.source}: {one.verdict}." for one in checks)
    parts = tuple(
        Part(f"Findings in {one.source}" if len(checks) > 1 else "Findings", _blocks(one, log))
        for one, log in zip(checks, logs, strict=True)
    )
    return Page("Is the recording sound?", verdict, not any(one.findings for one in checks), parts)


def log_gallery(log: Regular) -> Gallery:
    """Return pictures of the samples over time."""
    pictures = [
        Picture(
            figure,
            f"{name.capitalize()} over time; of a long log, smallest and largest value of each stretch.",
            f"Curves of the {name} of each axis over {len(log.log) * log.interval:.4g} s",
        )
        for name, figure in quantities(log.log)
    ]
    return Gallery(tuple(pictures))


def _blocks(found: RecordingCheck, log: Regular) -> tuple[Block, ...]:
    rows = tuple((one.text, *(text or "–" for text in one.consequences)) for one in found.findings)
    consequences = DataTable("What each finding means for each command; – means nothing.", ("finding", *COMMANDS), rows)
    axes = tuple(
        tuple(_number(axis[name]) if name != "axis" else axis[name] for name in COLUMNS) for axis in found.facts["axes"]
    )
    return (
        *([consequences] if rows else [Text("Nothing speaks against this log.")]),
        log_gallery(log),
        DataTable("Axes, SI: lost values, range, and step of the values.", tuple(COLUMNS.values()), axes),
    )


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
