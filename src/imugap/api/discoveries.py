"""Discover where a simulator and a device disagree, and what its error model lacks."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING

import pandas as pd

from imugap.api.logs import DeviceLog, LogSource, ModelSource, input_of, open_model, read
from imugap.api.result import Result, call
from imugap.discovery.device import Settings
from imugap.discovery.evaluation.distance import Distances
from imugap.discovery.finding import Discrepancy, Finding
from imugap.discovery.inputs import DiscoveryInputs, FileDiscovery, Files, discover_files, discover_recordings
from imugap.discovery.next_log import Advice
from imugap.discovery.report import candidate_table, discrepancy_table
from imugap.discovery.start_comparison.wording import sentences
from imugap.discovery.start_comparison.wording import table as comparison_table
from imugap.discovery.steps import Progress
from imugap.discovery.verdict import verdict
from imugap.interchange.plugins import catalogue
from imugap.io.recognition.settings import RecordingSettings
from imugap.model import ErrorModel
from imugap.pages.provenance import InputFile, Provenance
from imugap.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page

ALPHA = 0.01
"""Probability of any name where nothing is missing."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Discovered(Result):
    """What the error model of a device lacks.

    Attributes
    ----------
    found
        The discovery, with the properties of its logs.
    """

    found: FileDiscovery

    @classmethod
    def of(cls, files: Files, settings: Settings, progress: Progress = lambda step, done, steps: None) -> "Discovered":
        """Discover on files with all settings; :func:`discover` has those that a user needs."""
        found = discover_files(files, settings, progress)
        logs, tests = (
            [InputFile(role, one["path"], one["sha256"], found.recognised.get(one["path"], ())) for one in some]
            for role, some in (("log", found.logs), ("test log", found.tests))
        )
        single = {"reference": files.reference, "model": files.model}
        others = [
            InputFile.of(role, path, found.recognised.get(str(path), ()))
            for role, path in single.items()
            if path is not None
        ]
        paths = [one.path for one in logs]
        made = call("discover", [paths], test=[one.path for one in tests], **single, effects=files.effects)
        return cls(found=found, provenance=Provenance(made, (*logs, *tests, *others), _shown(settings)))

    @property
    def start(self) -> ErrorModel:
        """The error model before."""
        return self.found.found.start

    @property
    def model(self) -> ErrorModel:
        """The error model with what was missing."""
        return self.found.found.final

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Effects that were missing, the surest first."""
        return self.found.found.findings

    @property
    def unexplained(self) -> tuple[Discrepancy, ...]:
        """Where the log and the final model still disagree."""
        return self.found.found.unexplained

    @property
    def distances(self) -> Mapping[str, Distances]:
        """Distances of held-out data to the models before and after, beside their floor; 1 is a run of the model."""
        return self.found.found.distances

    @property
    def table(self) -> pd.DataFrame:
        """Effects that are named, alternatives to them, and those that were seen but not named."""
        return candidate_table(self.found.found)

    @property
    def verdict(self) -> str:
        """What is missing, which start parameters differ, what is left, and how far the model is from held-out data."""
        advice = (one.sentence() for one in self.advice)
        return "\n".join((verdict(self.found.found), *sentences(self.found.against), *advice))

    @property
    def against_start(self) -> pd.DataFrame:
        """Each parameter of the start model and axis, in the words and units of its file, beside that of the log.

        Columns: axis, effect, parameter, unit, start, log, low, high (the intervals of all rows hold together with
        probability 1 - alpha), within, p_value, verdict (agrees, differs, missing, not determined), remark. No rows
        without a start model.
        """
        return comparison_table(self.found.against)

    @property
    def parameters(self) -> pd.DataFrame:
        """Each parameter of the final model, SI, with its own 95 % interval where the log gives one.

        Columns: axis, effect, number (of the effects of one name on the axis), parameter, unit, value, low, high,
        remark.
        """
        return self.found.parameters

    @property
    def advice(self) -> tuple[Advice, ...]:
        """What to record next, for each finding whose name the log leaves open."""
        return self.found.advice

    def plot(self) -> "Figure":
        """Draw the surest place of each view, before and after."""
        from imugap.figures import discovery

        return discovery.surest(self.found.found, self.found.alpha)

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return report, final model, tables and figures."""
        from imugap.figures import discovery
        from imugap.pages.markdown import text

        found, alpha = self.found.found, self.found.alpha
        return {
            "report.json": self.found.report(),
            "model.yaml": self.model,
            "described.yaml": self.model if found.nameless is None else found.nameless.model,
            "gaps.csv": discrepancy_table(found.discrepancies, found.unexplained),
            "candidates.csv": self.table,
            "against_start.csv": self.against_start,
            "parameters.csv": self.parameters,
            "report.md": text(self.found, kind),
            "places.svg": discovery.places(found, alpha),
            "surest.svg": discovery.surest(found, alpha),
            "distance.svg": discovery.distance(found),
            "drift.svg": discovery.drift(found),
        }

    def _page(self) -> "Page":
        from imugap.pages.discover import page

        return page(self.found)


def discover(
    log: LogSource | Iterable[LogSource],
    *,
    test: Iterable[LogSource] = (),
    reference: LogSource | None = None,
    model: ModelSource | None = None,
    effects: str | None = None,
    alpha: float = ALPHA,
    gravity: float = STANDARD_GRAVITY,
    seed: int = 0,
    workers: int = 1,
    progress: Progress = lambda step, done, steps: None,
) -> Discovered:
    """Find where a simulator and a device disagree, name what is missing, add it, and measure the gain.

    The axes stay those of the files, unless a log was read with a frame.

    Parameters
    ----------
    log
        Log of the device, or several, one per run.
    test
        Further runs, on which the distances are taken; by default the last part of the log.
    reference
        Error-free log of the run, for a device in motion.
    model
        What the simulator has now; by default a constant bias and white noise.
    effects
        Name of a module whose effects join the catalogue.
    alpha
        Probability of any name where nothing is missing.
    gravity
        Gravity of the site of a device at rest [m/s^2].
    seed
        Seed of all simulations; the same seed gives the same result.
    workers
        Processes. More than one needs a script whose calls are below ``if __name__ == "__main__":``.
    progress
        Called as each step begins, with its name, the steps that are done, and their number.
    """
    kinds = catalogue(effects)
    opened = None if model is None else open_model(model, effects)
    runs = [log] if isinstance(log, DeviceLog | pd.DataFrame | str | PathLike) else list(log)
    logs, tests = (tuple(read(one).in_own_axes() for one in some) for some in (runs, test))
    ideal = None if reference is None else _turned_like(logs[0], reference)
    inputs = DiscoveryInputs(
        tuple(one.recording for one in logs), tuple(one.recording for one in tests),
        None if ideal is None else ideal.recording, opened,
    )  # fmt: skip
    settings = Settings(alpha=alpha, seed=seed, catalogue=tuple(kinds.values()), workers=workers, gravity=gravity)
    found = discover_recordings(inputs, settings, progress)
    given = {"test": [one.source for one in tests], "reference": ideal and ideal.source, "model": model}
    sources = [logs[0].source if len(logs) == 1 else [one.source for one in logs]]
    files = [*(one.as_input("log") for one in logs), *(one.as_input("test log") for one in tests)]
    files += [] if ideal is None else [ideal.as_input("reference")]
    files += input_of(opened, found.remarks)
    provenance = Provenance(call("discover", sources, **given, effects=effects), tuple(files), _shown(settings))
    return Discovered(found=found, provenance=provenance)


def _turned_like(log: DeviceLog, reference: LogSource) -> DeviceLog:
    """Return the error-free log in the axes of a log, unless it was read before."""
    if isinstance(reference, DeviceLog):
        return reference.in_own_axes()
    return read(reference, RecordingSettings(frame=log.recording.frame))


def _shown(settings: Settings) -> dict[str, object]:
    """Return the settings on which a result depends."""
    return {"alpha": settings.alpha, "gravity [m/s²]": settings.gravity, "seed": settings.seed}
