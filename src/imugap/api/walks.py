"""Navigate a walk with the device on a foot."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

import pandas as pd

from imugap.analysis.walk import (
    DEFAULT_MODEL,
    INDOORS,
    NavigatedWalk,
    WalkInputs,
    contradicted,
    navigate_walk,
    with_turn_on,
)
from imugap.api.logs import LogSource, ModelSource, input_of, open_model, read
from imugap.api.result import Result, call
from imugap.interchange.start_models.reading import Reading
from imugap.log import rate as rate_of
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import WalkAssumptions
from imugap.pages.provenance import Provenance
from imugap.units import STANDARD_GRAVITY, to_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Walked(Result):
    """Path of a walk.

    Attributes
    ----------
    found
        Solution of the smoother, and how the foot comes to rest.
    """

    found: NavigatedWalk

    @property
    def trajectory(self) -> pd.DataFrame:
        """Smoothed Trajectory with standard deviations (``_std``), sensor errors, and whether the foot is at stance."""
        return self.found.table()

    @property
    def strides(self) -> pd.DataFrame:
        """Begin and end [s], length, rise, peak height [m] and heading [deg] of each stride, with deviations."""
        return self.found.strides()

    @property
    def summary(self) -> dict[str, float]:
        """Distance, duration, strides, and where the walk ended, with standard deviations."""
        return self.found.summary()

    @property
    def verdict(self) -> str:
        """How far the walk went, and where it ended."""
        return self.found.verdict()

    def plot(self) -> "Figure":
        """Draw the walk from above."""
        from imugap.figures import walk

        return walk.plan(self.found.smoothed)

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return solution, strides, summary and figures."""
        from imugap.figures import walk

        return {
            "solution.parquet": self.trajectory, "strides.csv": self.strides, "summary.json": self.summary,
            "plan.svg": walk.plan(self.found.smoothed), "over_time.svg": walk.all_over_time(self.found.smoothed),
        }  # fmt: skip

    def _page(self) -> "Page":
        from imugap.pages.walk import page

        return page(self.found)


def walk(
    log: LogSource,
    *,
    model: ModelSource | None = None,
    effects: str | None = None,
    gravity: float = STANDARD_GRAVITY,
    full_scale: float = inf,
    outdoors: bool = False,
    heading_free: bool = False,
) -> Walked:
    """Navigate a walk with the device on a foot, corrected whenever the foot stands.

    Parameters
    ----------
    log
        Log of all six axes, which begins with a stand of 0.2 s or more (or ``heading_free``).
    model
        Error model of the device; by default that of a cheap one.
    effects
        Name of a module whose effects join the catalogue.
    gravity
        Gravity of the site [m/s^2].
    full_scale
        Full scale of the accelerometers [g], where heel strikes come near to it.
    outdoors
        Whether floors are not level between stairs and ramps.
    heading_free
        Whether the log may begin in motion; heading zero is then that of the foot at the first sample.
    """
    found = read(log)
    opened = None if model is None else open_model(model, effects)
    inputs = WalkInputs.of(found.recording)
    given = Reading(DEFAULT_MODEL) if opened is None else opened.at(rate_of(inputs.log))
    ground = WalkAssumptions() if outdoors else INDOORS
    assumptions = replace(ground, gravity=gravity, full_scale=to_si(full_scale, "g"), heading_free=heading_free)
    errors, remarks = (given.model, ()) if opened is None else _of_this_run(given.model, opened.path)
    inputs = replace(inputs, model=errors, assumptions=assumptions)
    try:
        navigated = navigate_walk(inputs)
    except ValueError as error:
        raise ValueError(f"{found.source}: {error}") from error
    if opened is not None:
        remarks += contradicted(errors, navigated.smoothed.stand, 1 / rate_of(inputs.log))
    files = (found.as_input("log"), *input_of(opened, (*given.remarks, *remarks)))
    made = call("walk", [found.source], model=model, effects=effects, outdoors=outdoors, heading_free=heading_free)
    settings = {"gravity [m/s²]": gravity, "floors": "any" if outdoors else "level but for stairs and ramps"}
    settings["start"] = "stand" if navigated.smoothed.stand.still else "in motion"
    return Walked(found=navigated, provenance=Provenance(made, files, settings))


def _of_this_run(model: ErrorModel, source: object) -> tuple[ErrorModel, tuple[str, ...]]:
    """Return a given model for a run of its device, and what was changed; ValueError with the next step."""
    try:
        return with_turn_on(model.require_axes(source))
    except ValueError as error:
        raise ValueError(f"{error} (without a model that of a cheap device is taken)") from error
