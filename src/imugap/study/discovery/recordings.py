"""Recordings of devices that took no part in building the method: how each is read, and what is wrong with it."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path

from imugap.analysis.check import COMMANDS, LESS, MOVING, NOTED, check
from imugap.discovery.preparation.prepare import prepare
from imugap.io import recording
from imugap.io.recognition.frame import AS_IS
from imugap.io.recognition.units import given_units
from imugap.io.recording import Recording, RecordingSettings

SHOCKS = "shocks"
"""Name of a finding of a check that discovery makes by itself."""


@dataclass(frozen=True)
class RecordingRecipe:
    """How a recording is read.

    Attributes
    ----------
    title
        Name in tables and text.
    dataset, run
        Data set of the catalogue and its run.
    settings
        What the file cannot say. The axes stay those of the file.
    begin, end
        Stretch that is used, after the first stamp [s].
    moving
        Whether the run has poses, from which its error-free log is built.
    """

    title: str
    dataset: str
    run: int
    settings: RecordingSettings
    begin: float = 0.0
    end: float = inf
    moving: bool = False

    @classmethod
    def from_mapping(cls, given: Mapping) -> "RecordingRecipe":
        """Make a recipe of an entry of ``data/recordings.yaml``, valid and complete by its schema."""
        reading = given["reading"]
        units = given_units(reading["units"])
        settings = RecordingSettings(tuple(reading["columns"]), units, AS_IS, reading.get("rate_hz"))
        begin, end, moving = given["begin_s"], given.get("end_s", inf), "reference" in given
        return cls(given["title"], given["dataset"], given["run"], settings, begin, end, moving)

    def read(self, path: str | Path) -> Recording:
        """Read the stretch of a recording; what was lost in it stays lost."""
        whole = recording.read(path, self.settings)
        since = whole.table.index - whole.table.index[0]
        part = whole.table[(since >= self.begin) & (since < self.end)]
        return Recording(whole.source, part, whole.recognised, whole.weightless, whole.frame)


def properties(found: Recording) -> dict:
    """Return what is known of a recording before any search, as plain data.

    Returns
    -------
    dict
        ``duration_s``, ``rate_hz``, ``in_motion``, ``recognised`` (sentences), ``left_out`` (sentences on what
        discovery leaves out) and ``shocks`` (begin and end of each after the first sample [s]; none in motion).
    """
    checked = check(found)
    in_motion = checked.commands == MOVING
    column = COMMANDS.index("discover")
    noted = [one for one in checked.findings if one.consequences[column] in (NOTED, LESS) and one.name != SHOCKS]
    return {
        "duration_s": len(found.regular.log) * found.regular.interval,
        "rate_hz": 1 / found.regular.interval,
        "in_motion": in_motion,
        "recognised": list(found.recognised),
        "left_out": [one.text for one in noted],
        "shocks": [] if in_motion else [list(one) for one in prepare(found.table).shocks],
    }
