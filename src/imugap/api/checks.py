"""Check recordings: usable or not, for what, and what was found where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from imugap.analysis.check import RecordingCheck
from imugap.analysis.check import check as check_recording
from imugap.api.logs import DeviceLog, LogSource, read
from imugap.api.result import Result, call
from imugap.pages.provenance import Provenance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Checked(Result):
    """Check of recordings.

    Attributes
    ----------
    logs
        The recordings.
    checks
        Verdict, findings with their consequences, and facts of each of them.
    """

    logs: tuple[DeviceLog, ...]
    checks: tuple[RecordingCheck, ...]

    @classmethod
    def together(cls, some: Sequence["Checked"]) -> "Checked":
        """Join several checks."""
        logs, checks, inputs = (
            tuple(one for found in some for one in getattr(found, name)) for name in ("logs", "checks", "inputs")
        )
        return cls(logs=logs, checks=checks, provenance=replace(some[0].provenance, inputs=inputs))

    @property
    def usable(self) -> bool:
        """Whether every recording is usable for all commands for which it is meant."""
        return not any(one.never for one in self.checks)

    @property
    def verdict(self) -> str:
        """For which commands each recording is usable, and the next step for the others."""
        return "\n".join(f"{one.source}: {one.verdict}" for one in self.checks)

    def facts(self) -> list[dict]:
        """Return all properties of each recording, as plain data."""
        return [{"source": one.source, "verdict": one.verdict} | one.facts for one in self.checks]

    def plot(self) -> "Figure":
        """Draw the samples of the first recording over time."""
        return self.logs[0].plot()

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return the facts."""
        return {"facts.json": self.facts()}

    def _page(self) -> "Page":
        from imugap.pages.check import page

        return page(self.checks, [one.recording.regular for one in self.logs])


def check(*logs: LogSource) -> Checked:
    """Check recordings: what is wrong with stamps and samples, where, and what it means for each analysis.

    Raises
    ------
    imugap.LogError
        Where no rate or no value of a recording is right.
    """
    found = tuple(map(read, logs))
    checks = tuple(check_recording(one.recording) for one in found)
    made = call("check", (one.source for one in found))
    provenance = Provenance(made, tuple(one.as_input("log") for one in found))
    return Checked(logs=found, checks=checks, provenance=provenance)
