"""Which rule makes each figure and table, with which command, and how long that takes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from imugap.site.markdown import code, plain, table
from imugap.workflow.run_records import RunRecord, seconds_before


@dataclass(frozen=True)
class RuleOutput:
    """Figure or table of the workflow: its path, the rule that makes it, and what that rule does."""

    path: str
    rule: str
    purpose: str


def page(outputs: Sequence[RuleOutput], records: Mapping[str, RunRecord]) -> str:
    """Return all figures and tables by rule.

    Parameters
    ----------
    records
        Records of the run on this machine by output, for the times; empty where there was none.
    """
    rules: dict[str, list[RuleOutput]] = {}
    for one in outputs:
        rules.setdefault(one.rule, []).append(one)
    rows = [
        (
            ", ".join(code(PurePath(one.path).stem) for one in of),
            plain(of[0].purpose),
            code(f"snakemake --cores all {of[0].path}"),
            _time(of[0].path, records),
        )
        for of in rules.values()
    ]
    return table(("figure or table", "what its rule does", "command", "processor time"), rows) + "\n"


def _time(path: str, records: Mapping[str, RunRecord]) -> str:
    seconds = seconds_before(path, records)
    if seconds is None:
        return "–"
    return f"{seconds / 60:.0f} min" if seconds >= 60 else f"{seconds:.0f} s"
