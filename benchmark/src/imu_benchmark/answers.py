"""Answers of a program: a folder with a folder for each case, which holds ``report.json``.

A report has the schema ``answer`` of this package, which those of ``imugap discover`` keep.
``seconds.json`` beside it, an object with the key ``seconds``, holds the run time.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from math import fsum, nan
from pathlib import Path

from imu_benchmark.schema import FormatError, check, load, read_json

REPORT, SECONDS = "report.json", "seconds.json"
ROUNDING = 1e-3
"""Largest distance of the sum of probabilities from one."""


@dataclass(frozen=True, eq=False)
class Entry:
    """The answers of a program: its name, the report and the run time [s] (not a number if unknown) of each case."""

    name: str
    reports: Mapping[str, Mapping]
    seconds: Mapping[str, float]


def parse(report: object, source: object) -> dict:
    """Return a report with the keys that it may omit, if it is one."""
    check(report, load("answer"), source)
    assert isinstance(report, dict)
    for place, weights in _weights(report):
        total = fsum(weights.values())
        if abs(total - 1) > ROUNDING:
            raise FormatError(source, place, "probabilities that add up to one", f"{total:.6g}")
    return {"gaps": []} | report


def read_report(path: str | Path) -> dict:
    """Read the report of a case."""
    return parse(read_json(path), path)


def read_entry(folder: str | Path, cases: Collection[str]) -> Entry:
    """Read the answers of a program to ``cases``; every case needs one."""
    folder = Path(folder)
    if not folder.is_dir():
        raise FormatError(folder, "", "a folder of answers", "none")
    strange = sorted({path.parent.name for path in folder.glob(f"*/{REPORT}")} - set(cases))
    if strange:
        raise FormatError(folder, strange[0], f"one of {len(cases)} cases", "no such case")
    reports = {case: read_report(folder / case / REPORT) for case in cases}
    return Entry(folder.name, reports, {case: _seconds(folder / case / SECONDS) for case in cases})


def digest(folder: str | Path) -> str:
    """Return the SHA-256 of all answers of a folder, by which an entry is fixed before the keys are revealed."""
    lines = [
        f"{path.parent.name} {sha256(path.read_bytes()).hexdigest()}\n"
        for path in sorted(Path(folder).glob(f"*/{REPORT}"))
    ]
    if not lines:
        raise FormatError(folder, "", f"answers CASE/{REPORT}", "none")
    return sha256("".join(lines).encode()).hexdigest()


def _weights(report: Mapping) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Yield place and values of all probabilities of a report."""
    if "probabilities" in report:
        yield ".probabilities", report["probabilities"]
    for part in ("effects", "withheld", "unexplained", "gaps"):
        for number, item in enumerate(report.get(part, [])):
            if "probabilities" in item:
                yield f".{part}[{number}].probabilities", item["probabilities"]


def _seconds(path: Path) -> float:
    if not path.exists():
        return nan
    found = read_json(path)
    schema = {"type": "object", "required": ["seconds"], "properties": {"seconds": {"type": "number", "minimum": 0}}}
    check(found, schema, path)
    return float(found["seconds"])
