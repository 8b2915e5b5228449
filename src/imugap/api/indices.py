"""Compute the performance indices of a device from static runs."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from imugap.analysis import indices as analysis
from imugap.analysis.indices import DeviceIndices
from imugap.api.logs import LogSource, read
from imugap.api.result import Result, call
from imugap.estimation.indices import INDICES
from imugap.pages.provenance import Provenance
from imugap.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Characterised(Result):
    """Performance indices of a device.

    Attributes
    ----------
    found
        Table of the indices, and sentences on what was left out.
    runs
        Number of static runs.
    """

    found: DeviceIndices
    runs: int

    @property
    def table(self) -> pd.DataFrame:
        """Indices, SI: ``axis``, ``symbol``, ``value``, ``low`` and ``high`` (95 %), ``holds``, ``runs``.

        A value that does not hold is an upper bound.
        """
        return self.found.table

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was left out of the runs, and which indices they are too short for."""
        return self.found.remarks

    @property
    def verdict(self) -> str:
        """How many indices were read, and which are upper bounds only."""
        bounds = self.table[~self.table["holds"]]
        runs = f"{self.runs} run{'s' if self.runs > 1 else ''}"
        first = f"{len(self.table) - len(bounds)} of {len(self.table)} indices are readings, from {runs}."
        named = [
            f"{axis}: upper bounds only: {', '.join(INDICES[one].title for one in of['symbol'])}."
            for axis, of in bounds.groupby("axis", sort=False)
        ]
        return "\n".join([first, *named])

    def plot(self) -> "Figure":
        """Draw each index of each axis with its interval."""
        from imugap.figures.indices import intervals

        return intervals(self.table)

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return the table and the figure."""
        return {"indices.csv": self.table, "indices.svg": self.plot()}

    def _page(self) -> "Page":
        from imugap.pages.indices import page

        return page(self.table, self.remarks, self.verdict)


def indices(*runs: LogSource, period: float = 1.0, gravity: float = STANDARD_GRAVITY) -> Characterised:
    """Compute bias, stability, repeatability, N, B and K of a device, with 95 % intervals.

    Knocks, outliers, stuck samples and gaps are left out and listed.

    Parameters
    ----------
    runs
        Logs of the device at rest, one per run; the repeatability needs two.
    period
        Averaging period of the bias stability [s].
    gravity
        Gravity of the site [m/s^2], which ``accel_z`` reads with the opposite sign.
    """
    if not runs:
        raise ValueError("runs: expected at least one log; found none")
    logs = [read(one) for one in runs]
    found = analysis.indices([one.recording for one in logs], period, gravity)
    inputs = tuple(one.as_input("log") for one in logs)
    made = call("indices", [one.source for one in logs])
    settings = {"averaging period of the stability [s]": period, "gravity [m/s²]": gravity}
    return Characterised(found=found, runs=len(logs), provenance=Provenance(made, inputs, settings))
