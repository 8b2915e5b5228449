"""Page of an estimation: verdict, Allan deviations, parameters, and what a filter takes."""

from collections.abc import Mapping
from types import MappingProxyType

from imugap.analysis.estimate import LogEstimate
from imugap.estimation import report
from imugap.figures.estimation import fitted_axis
from imugap.figures.style import AXIS_TITLES
from imugap.interchange.conventions import Rule
from imugap.interchange.start_bias import known_biases
from imugap.io.recognition.frame import axes_text
from imugap.pages.check import log_gallery
from imugap.pages.model import asked_part, filter_part, simulator_part
from imugap.pages.page import Block, DataTable, Gallery, Page, Part, Picture, Points, Text
from imugap.units import habit
from imugap.workflow.tables import number, unit, with_interval

HORIZON = 10.0
"""Averaging time at which the Allan variance of the slow part is kept [s]."""


def page(found: LogEstimate, gravity: float, asked: Mapping[str, str] = MappingProxyType({})) -> Page:
    """Compose the page of an estimation; ``asked`` has the files that were asked for, the text of each by target."""
    bad = [one for one in found.axes if not one.fits]
    names = ", ".join(one.axis for one in bad)
    verdict = f"The model does not fit the log of {names}." if bad else "The model fits the log of every axis."
    remarks = (*map(str, found.regular.remarks), *found.failed)
    rule = Rule(found.rate_hz, HORIZON)
    return Page(
        "Which random errors has the device?",
        (
            *([] if found.motion is None else [found.motion]),
            verdict,
            *(f"{one.axis}: {one.verdict()}" for one in (*bad, *(a for a in found.axes if a.fits))),
            *((report.NEXT,) if bad else ()),
            *found.length,
        ),
        not bad and not found.failed,
        (
            Part("Allan deviations", (Text(ALLAN), _curves(found))),
            Part("Parameters", (_parameters(found), *_biases(found, gravity))),
            *((asked_part(asked),) if asked else ()),
            simulator_part(found.model, rule),
            filter_part(lambda target: found.export(target, rule, gravity).text, asked),
            Part("What was undone or left out", (Points(remarks),) if remarks else ()),
            Part("The log", (log_gallery(found.regular),)),
        ),
    )


ALLAN = (
    "The Allan deviation is the scatter of means over an averaging time from one to the next. White noise falls with "
    "slope -1/2, flicker noise is level, a random walk rises with slope +1/2. Where the black curve stays in the blue "
    "band, a log as long as this one shows no difference from the model. Orange marks where the model does not fit: "
    "the test of an octave sees a difference that is narrow in this picture."
)


BIAS = (
    "The bias is the mean of the log. That of a gyroscope holds the rotation of the Earth, up to 15 °/h. That of the "
    "accelerometers is known along gravity, as well as the gravity of the site; across it a bias is like a tilt."
)


def _curves(found: LogEstimate) -> Gallery:
    misfits = {one.axis: one.off for one in found.axes}
    pictures = [
        Picture(
            fitted_axis(axis, curve, misfits[axis]),
            f"{AXIS_TITLES[axis]}: the log, the fitted model, and where 95 % of the logs that it makes lie.",
            f"Allan deviation of {axis} over the averaging time, with the curve and band of its model",
        )
        for axis, curve in report.curves(found.axes).groupby("axis", sort=False)
    ]
    return Gallery(tuple(pictures))


def _parameters(found: LogEstimate) -> DataTable:
    rows = tuple(
        (
            one.axis, estimate.effect.replace("_", " "), estimate.parameter.replace("_", " "),
            *with_interval(estimate.value, estimate.low, estimate.high), unit(name),
            unit(habit(estimate.value, name)), str(estimate.verdict),
        )
        for one in found.axes for estimate, name in one.parameters()
    )  # fmt: skip
    titles = ("axis", "effect", "parameter", "value", "95 % interval", "unit", "in use", "the log")
    axes = axes_text(found.frame)
    return DataTable(f"Estimates with 95 % intervals, SI.{f' Axes: {axes}.' if axes else ''}", titles, rows)


def _biases(found: LogEstimate, gravity: float) -> tuple[Block, ...]:
    """Return the biases that the log shows, if any, and what they hold."""
    rows = tuple(
        ("accel, along gravity", number(bias), "m/s²", unit(habit(bias, "m/s^2"))) if axis == "accel"
        else (axis, number(bias), "rad/s", unit(habit(bias, "rad/s")))
        for axis, bias in known_biases(found.levels, gravity).items()
    )  # fmt: skip
    table = DataTable("Constant bias of this log, SI.", ("axis", "bias", "unit", "in use"), rows)
    return (Text(BIAS), table) if rows else ()
