"""Estimate the stochastic effects on each axis of a recording at rest.

Stages::

    read        Recording -> Regular             true samples of each axis, gaps as gaps
    estimate    axis -> AxisEstimate             imugap.estimation.report.estimate_axis; an axis may fail alone
    export      estimates -> text of a filter    with upper bounds for what the log does not show
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from imugap.analysis.omission_distance import distance
from imugap.effects import Bias
from imugap.effects.effect import AxisModel, Effect
from imugap.estimation import log_length, reduced_limits, report
from imugap.estimation.report import AxisEstimate, EstimatorSettings
from imugap.integrity import rest
from imugap.integrity.regular import Regular
from imugap.interchange.conventions import Rule
from imugap.interchange.export import PROGRAMS, ExportedFile, Target, exported
from imugap.interchange.start_bias import start_bias
from imugap.io.recognition.frame import AS_IS, axes_text, own_axes
from imugap.io.recording import Recording
from imugap.log import TEMPERATURE
from imugap.model import ErrorModel

OF_ROS = (Target.KALIBR, Target.VINS, Target.ROS, Target.GAZEBO, Target.GAZEBO_PLUGIN)
"""Targets of tools that take the axes of the log as they are."""
REST_S = 10.0
"""Shortest rest that is worth a log of its own [s]."""


@dataclass(frozen=True, eq=False)
class LogEstimate:
    """Estimates of the axes of a log.

    Attributes
    ----------
    regular
        The log on an even clock.
    axes
        Estimates, in the order of the axes.
    failed
        Sentences on the axes without an estimate.
    topic
        Topic of ROS from which the log is; None where it is from none.
    frame
        Where the axes of the file point (:mod:`imugap.io.recognition.frame`).
    """

    regular: Regular
    axes: tuple[AxisEstimate, ...]
    failed: tuple[str, ...]
    topic: str | None = None
    frame: str = AS_IS

    @cached_property
    def motion(self) -> str | None:
        """Return what the values mean where the device was moved, and the next step; None at rest."""
        found = rest.motion(self.regular.log, self.regular.interval)
        if found.at_rest:
            return None
        low, high = found.longest_rest
        step = f"cut the log to its rest from {low:.6g} to {high:.6g} s" if high - low >= REST_S else "record at rest"
        return (
            f"THE DEVICE WAS IN MOTION for {max(found.share, 0.01):.0%} of the log: the values describe its motion and "
            f"its vibration as well as the sensor, and are too large for a sensor alone; next: {step}"
        )

    @property
    def model(self) -> ErrorModel:
        """Return the estimated effects as an error model."""
        return ErrorModel({one.axis: one.fit.model for one in self.axes})

    @property
    def rate_hz(self) -> float:
        """Return the sampling rate to nine digits, without the round-off of the stamps [Hz]."""
        return float(f"{1 / self.regular.interval:.9g}")

    @property
    def levels(self) -> dict[str, float]:
        """Mean output of each axis, SI."""
        return {one.axis: float(one.used.values.mean()) for one in self.axes}

    @cached_property
    def length(self) -> tuple[str, ...]:
        """For each kind of sensor, how well the log determines it, and how long one would have to be."""
        return tuple(log_length.sentences(self.axes))

    @cached_property
    def bounds(self) -> dict[str, tuple[Effect, ...]]:
        """White noise and random walk at the upper limit, of each axis whose log shows none."""
        return {one.axis: limits for one in self.axes if (limits := report.bounds(one))}

    def export(self, target: Target, rule: Rule, gravity: float) -> ExportedFile:
        """Return the file for a filter: estimates, bounds for what the log hides, its bias at rest, any misfit.

        Parameters
        ----------
        gravity
            Gravity of the site [m/s^2].
        """
        axes = {one.axis: _present(one.fit.model) for one in self.axes}
        for axis, (bias, spread) in start_bias(self.levels, gravity).items():
            axes[axis] = AxisModel((*axes[axis], bias, *((spread,) if target is Target.KF_GINS else ())))
        reduced = target is not Target.IMUGAP and target not in PROGRAMS
        bounds = self.bounds if reduced else {}
        limits = {one.axis: reduced_limits.of(one, bounds.get(one.axis, ()), rule) for one in self.axes if reduced}
        misfits = {one.axis: one.goodness for one in self.axes if not one.fits}
        names, notes = {axis: axis for axis in axes}, []
        if target in OF_ROS and (own := own_axes(self.frame)):
            names, axes = _in_own_axes(axes, own)
            notes.append("Axes and the signs of biases: those of the log.")
        elif turned := axes_text(self.frame):
            notes.append(f"Axes and the signs of biases: {turned}.")
        notes = [f"THE MODEL DOES NOT FIT THE LOG of {names[axis]}: {text}" for axis, text in misfits.items()] + notes
        rule = replace(rule, topic=self.topic)
        model, bounds, limits = ({names[axis]: one for axis, one in some.items()} for some in (axes, bounds, limits))
        return exported(ErrorModel(model), target, rule, bounds, distance, notes, limits)


def _in_own_axes(axes: Mapping[str, AxisModel], own: Sequence[str]) -> tuple[dict[str, str], dict[str, AxisModel]]:
    """Return the name in the log of each axis, and the models with their biases along the axes of the log.

    ``own`` are the axes of the log that x, y and z are, with a minus sign where they are reversed.
    """
    along = {axis: own["xyz".index(axis[-1])] for axis in axes}
    names = {axis: f"{axis[:-1]}{one[-1]}" for axis, one in along.items()}
    signs = {axis: -1.0 if one.startswith("-") else 1.0 for axis, one in along.items()}
    return names, {axis: AxisModel(tuple(_signed(one, signs[axis]) for one in model)) for axis, model in axes.items()}


def _signed(effect: Effect, sign: float) -> Effect:
    """Return an effect of an axis on the axis of the given sign along it."""
    return replace(effect, value=sign * effect.value) if isinstance(effect, Bias) else effect


def require_axes(recording: Recording, asked: Sequence[str] = ()) -> list[str]:
    """Return the axes asked for, each once; all that have samples where none are; ValueError for one without."""
    found = recording.regular
    if not found.samples:
        unusable = "; ".join(found.unusable.values())
        raise ValueError(f"{recording.source}: columns: expected an axis that varies; found {unusable}")
    for axis in asked:
        if axis in found.unusable:
            raise ValueError(f"axis: expected one that varies; found {found.unusable[axis]}")
    known = tuple(found.samples)
    return [report.known_name(axis, known, "axis") for axis in dict.fromkeys(asked or known)]


def estimate(recording: Recording, axes: Sequence[str], settings: EstimatorSettings) -> LogEstimate:
    """Estimate each of the axes (:func:`require_axes`); ValueError where none has an estimate."""
    settings = replace(settings, axes=len(axes))
    regular, estimates, errors = recording.regular, [], []
    for axis in axes:
        one = regular.samples[axis]
        temperature = _temperature(regular, len(one.values))
        try:
            estimates.append(report.estimate_axis(axis, one.values, one.interval, settings, temperature, one.begin))
        except ValueError as error:
            errors.append(error)
    if not estimates:
        raise errors[0]
    failed = tuple(f"{error} (no estimate of this axis)" for error in errors)
    return LogEstimate(regular, tuple(estimates), failed, recording.topic, recording.frame)


def _temperature(found: Regular, count: int) -> np.ndarray | None:
    """Return the readings of the temperature at ``count`` samples, or None where there are none at the same times."""
    if TEMPERATURE not in found.log or len(found.log) != count:
        return None
    readings = found.log[TEMPERATURE].interpolate(limit_direction="both").to_numpy()
    return readings if np.isfinite(readings).all() else None


def _present(model: AxisModel) -> AxisModel:
    """Return a model without the processes of density zero."""
    return AxisModel(tuple(one for one in model if any(one.parameters().values())))
