"""Records that Snakemake keeps of the jobs of a run: rule, inputs, begin and end of the job of each output."""

import json
from base64 import urlsafe_b64decode
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

METADATA = ".snakemake/metadata"
"""Folder of the records, below the folder of the run: one file per output, named by its path in base 64."""
PART = "@"
"""What begins the name of each folder into which a long path is split."""


@dataclass(frozen=True)
class RunRecord:
    """Job that made an output.

    Attributes
    ----------
    rule
        Its rule.
    inputs, parameters
        Paths of its inputs, and its parameters as text.
    begin, end
        Unix times [s].
    """

    rule: str
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    begin: float
    end: float


def read(folder: str | Path) -> dict[str, RunRecord]:
    """Return the record of each output of the last run in a folder that is complete, by path; none where none is."""
    root = Path(folder, METADATA)
    found = {}
    for path in sorted(one for one in root.rglob("*") if one.is_file()):
        encoded = "".join(part.removeprefix(PART) for part in path.relative_to(root).parts)
        one = json.loads(path.read_text())
        if one.get("endtime") is None or one.get("starttime") is None or one.get("incomplete"):
            continue
        found[urlsafe_b64decode(encoded).decode()] = RunRecord(
            one["rule"], tuple(one.get("input") or ()), tuple(map(str, one.get("params") or ())),
            one["starttime"], one["endtime"],
        )  # fmt: skip
    return dict(sorted(found.items()))


def seconds_before(path: str, records: Mapping[str, RunRecord]) -> float | None:
    """Return the time of the job of an output and of all before it, each once [s]; None where it has no record."""
    if path not in records:
        return None
    jobs, waiting, seen = set(), [path], set()
    while waiting:
        one = records.get(waiting.pop())
        if one is None:
            continue
        jobs.add((one.rule, one.begin, one.end))
        waiting += [name for name in one.inputs if name not in seen]
        seen.update(one.inputs)
    return sum(end - begin for _, begin, end in jobs)
