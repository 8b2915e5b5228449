"""Estimate the stochastic effects of a device at rest, and export them for a filter or a simulator."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from imugap.analysis import estimate as analysis
from imugap.analysis.estimate import LogEstimate
from imugap.analysis.omission_distance import distance
from imugap.api.logs import LogSource, ModelSource, open_model, read
from imugap.api.result import Result, SourcePath, call
from imugap.atomic import write_together
from imugap.estimation import report
from imugap.estimation.report import AxisEstimate, EstimatorSettings, Method
from imugap.interchange import export as conversion
from imugap.interchange.conventions import Rule, Triad
from imugap.interchange.export import ExportedFile, Target
from imugap.model import ErrorModel
from imugap.pages import estimate_table
from imugap.pages.provenance import Provenance
from imugap.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page

HORIZON = 10.0
"""Averaging time at which the Allan variance of the slow part of a model is kept in an export [s]."""


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Estimated(Result):
    """Estimated effects of a log.

    Attributes
    ----------
    estimate
        Estimates of the axes, and the log on an even clock.
    gravity
        Gravity of the site [m/s^2].
    asked
        Texts of the files that were asked for, by target; the page shows them first.
    """

    estimate: LogEstimate
    gravity: float = STANDARD_GRAVITY
    asked: Mapping[str, str] = field(default_factory=dict)

    @property
    def axes(self) -> tuple[AxisEstimate, ...]:
        """Estimate of each axis that has one."""
        return self.estimate.axes

    @property
    def model(self) -> ErrorModel:
        """The estimated effects as an error model."""
        return self.estimate.model

    @property
    def table(self) -> pd.DataFrame:
        """Parameters, SI: ``axis``, ``effect``, ``parameter``, ``value``, ``low`` and ``high`` (95 %), ``unit`` ..."""
        return report.table(self.axes)

    @property
    def rate_hz(self) -> float:
        """Sampling rate of the log [Hz]."""
        return self.estimate.rate_hz

    @property
    def remarks(self) -> tuple[str, ...]:
        """What was undone, left out or not estimated."""
        return (*map(str, self.estimate.regular.remarks), *self.estimate.failed)

    @property
    def fits(self) -> bool:
        """Whether the model of every axis fits its log."""
        return all(one.fits for one in self.axes)

    @property
    def verdict(self) -> str:
        """Motion of the device, goodness of fit of each axis, misfits first, what to do about them, length of log."""
        moved = [] if self.estimate.motion is None else [self.estimate.motion]
        bad = [f"{one.axis}: THE MODEL DOES NOT FIT THE LOG: {one.verdict()}" for one in self.axes if not one.fits]
        good = [f"{one.axis}: {one.verdict()}" for one in self.axes if one.fits]
        return "\n".join([*moved, *bad, *good, *([report.NEXT] if bad else []), *self.estimate.length])

    def __str__(self) -> str:
        """Return the verdict and the table of the estimates, as the command prints them."""
        return f"{self.verdict}\n\n{estimate_table.text(self.estimate, self.gravity)}"

    def export(
        self,
        target: str,
        path: SourcePath | None = None,
        *,
        horizon: float = HORIZON,
        correlation_time: float | None = None,
        triad: str = Triad.MEAN_SQUARE,
    ) -> str:
        """Return the parameters as a filter or simulator takes them, and write them to ``path`` if it is given.

        What a tool requires and the log does not show is at its upper limit, and the file says so. What the tool
        cannot hold is a warning, with the size of each effect and what leaving it out costs; notes on a file whose
        format has no comments are written beside it.

        Parameters
        ----------
        target
            Name of the tool, such as ``kalibr`` (:class:`imugap.interchange.export.Target`).
        horizon
            Averaging time at which the Allan variance of the slow part is kept [s].
        correlation_time
            Of the slow process, where the target has one [s]; by default its own.
        triad
            How three axes become one number, ``rms`` or ``worst``.
        """
        return _given(self.exported(target, horizon, correlation_time, triad), path)

    def exported(
        self,
        target: str,
        horizon: float = HORIZON,
        correlation_time: float | None = None,
        triad: str = Triad.MEAN_SQUARE,
    ) -> ExportedFile:
        """Return the file of :meth:`export` as a value, with what it leaves out; nothing is written, nothing warns."""
        rule = Rule(self.rate_hz, horizon, correlation_time, Triad(triad))
        return self.estimate.export(Target.of(target), rule, self.gravity)

    def plot(self) -> "Figure":
        """Draw the Allan deviation of each axis against that of its model."""
        from imugap.figures import estimation

        return estimation.fitted(report.curves(self.axes), {one.axis: one.off for one in self.axes})

    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return the estimates as records and as a table, the model, and the figure."""
        return {
            "estimates.json": [one.record() for one in self.axes], "estimates.csv": self.table,
            "model.yaml": self.model, "allan.svg": self.plot(),
        }  # fmt: skip

    def _page(self) -> "Page":
        from imugap.pages.estimate import page

        return page(self.estimate, self.gravity, self.asked)


def estimate(
    log: LogSource,
    *,
    axes: Sequence[str] = (),
    terms: Sequence[str] | None = None,
    method: str = Method.LIKELIHOOD,
    highest: float = inf,
    robust: bool = False,
    gravity: float = STANDARD_GRAVITY,
) -> Estimated:
    """Estimate the stochastic effects on each axis of a log at rest, with 95 % intervals.

    Knocks, outliers, stuck samples and gaps are left out and listed.

    Parameters
    ----------
    log
        Log of a device at rest.
    axes
        Axes; all that have samples by default.
    terms
        Names of the effects, ``white_noise``, ``random_walk`` ...; by default those that the log shows.
    method
        ``likelihood``, ``wavelet`` or ``allan``.
    highest
        Highest frequency that is used [Hz].
    robust
        Whether to bound the effect of outliers (method ``wavelet``).
    gravity
        Gravity of the site [m/s^2], for the bias in an export.
    """
    kinds = None if terms is None else report.kinds_of(terms)
    settings = EstimatorSettings(kinds, Method(method), highest, robust)
    found = read(log)
    result = analysis.estimate(found.recording, analysis.require_axes(found.recording, axes), settings)
    given = {"axes": tuple(axes), "terms": tuple(terms or ()), "robust": robust}
    given |= {"method": method if method != Method.LIKELIHOOD else "", "highest": highest if highest < inf else None}
    provenance = Provenance(call("estimate", [found.source], **given), (found.as_input("log"),))
    return Estimated(estimate=result, gravity=gravity, provenance=provenance)


def export(
    model: ModelSource,
    target: str,
    rate: float,
    path: SourcePath | None = None,
    *,
    horizon: float = HORIZON,
    correlation_time: float | None = None,
    triad: str = Triad.MEAN_SQUARE,
) -> str:
    """Return an error model as a filter or simulator takes it, and write it to ``path`` if it is given.

    Parameters as :meth:`Estimated.export`, and ``rate``, the sampling rate [Hz]. What the tool cannot hold is a
    warning.
    """
    rule = Rule(rate, horizon, correlation_time, Triad(triad))
    return _given(
        conversion.exported(open_model(model).at(rate).model, Target.of(target), rule, distance=distance), path
    )


def _given(file: ExportedFile, path: SourcePath | None) -> str:
    """Return the text, warn of what is left out, and write the file with its notes."""
    for one in file.left_out:
        warnings.warn(f"left out: {one}", stacklevel=3)
    if path is not None:
        write_together({to: partial(Path.write_text, data=text) for to, text in file.texts(path).items()})
    return file.text
