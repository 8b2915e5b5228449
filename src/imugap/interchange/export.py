"""Export of an error model to common filters and simulators, as a state space for one's own filter, and as a program.

The conventions are those of :mod:`imugap.interchange.conventions`. Each file begins with the effects that were kept,
approximated (and how well), and omitted. A program (:mod:`imugap.interchange.code`) omits next to nothing.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import isclose
from os import PathLike
from pathlib import Path
from types import MappingProxyType

import numpy as np
import yaml

from imugap import log, spelling
from imugap.atomic import is_stream
from imugap.effects import RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel, Effect
from imugap.interchange import simulator_files
from imugap.interchange.augmentation import augmentation
from imugap.interchange.code.program import Language, program
from imugap.interchange.code.program import left_out as without_form
from imugap.interchange.conventions import (
    HOUR,
    KALIBR,
    KF_GINS,
    ROS,
    VINS,
    Convention,
    Parameter,
    Reduced,
    Rule,
    Triad,
    by_triad,
    left_out,
    reduced,
    reduced_axes,
)
from imugap.interchange.limits import Limits, ends_text
from imugap.interchange.limits import combined as combined_limits
from imugap.interchange.omissions import Distance, Omission, costs
from imugap.interchange.simulator_files import (
    Simulator,
    Written,
    gauss_markov_of_axis,
    number,
    parameters,
    random_walk_of_triad,
)
from imugap.model import ErrorModel
from imugap.units import from_si


class Target(StrEnum):
    """Target of an export."""

    KALIBR = "kalibr"
    """Kalibr's imu.yaml; OpenVINS reads the same keys below imu0."""
    VINS = "vins"
    ROS = "ros"
    GAZEBO = "gazebo"
    KF_GINS = "kf-gins"
    AIRSIM = "airsim"
    GENESIS = "genesis"
    GNSS_INS_SIM = "gnss-ins-sim"
    ISAAC_LAB = "isaac-lab"
    MATLAB = "matlab"
    """JSON of MATLAB's imuSensor."""
    PEGASUS = "pegasus"
    IMUGAP = "imugap"
    """The model with its discrete state space per axis."""
    PYTHON = "python"
    CPP = "cpp"
    GAZEBO_PLUGIN = "gazebo-plugin"

    @classmethod
    def of(cls, name: str) -> "Target":
        """Return the target of the given name; ValueError with the nearest one if unknown."""
        if name not in list(cls):
            raise ValueError(f"target: expected {spelling.expected(name, cls)}; found {name!r}")
        return cls(name)


HORIZONS = (1.0, 10.0, 100.0)
"""Averaging times [s] at which a file says what a random walk would be."""
ALIKE = 0.005
"""Relative difference of Allan deviations below which a file says nothing of where it is."""
NOTES = ".notes.txt"
"""End of the name of the file beside one whose format has no comments."""


@dataclass(frozen=True)
class ExportedFile:
    """File for a target.

    Attributes
    ----------
    text
        The file.
    left_out
        What it leaves out, with the size of each effect and what it costs.
    notes
        Notes that its format has no comments for; none where it begins with them.
    """

    text: str
    left_out: tuple[str, ...]
    notes: tuple[str, ...] = ()

    def texts(self, path: str | PathLike[str]) -> dict[str | Path, str]:
        """Return the text of each file to write: the file, and its notes beside it, unless it is a stream."""
        beside = bool(self.notes) and not is_stream(path)
        return {Path(path): self.text} | ({f"{path}{NOTES}": "\n".join(self.notes) + "\n"} if beside else {})


def exported(
    model: ErrorModel,
    target: Target,
    rule: Rule,
    bounds: Mapping[str, Sequence[Effect]] = MappingProxyType({}),
    distance: Distance | None = None,
    remarks: Sequence[str] = (),
    limits: Mapping[str, Limits] = MappingProxyType({}),
) -> ExportedFile:
    """Return the file for a target with what it leaves out.

    A model without an axis, white noise, or a process that the target requires is a ValueError.

    Parameters
    ----------
    bounds
        White noise and random walk where the log of an axis shows none, at the upper limits that it sets. They stand
        for what the tool requires, and the file states that they are limits.
    distance
        Distance of a log from simulations without an effect, which is stated of each that is left out; None for none.
    remarks
        Notes on the model, before all others; the own state space has no place for them.
    limits
        95 % limits of the reduced model of each axis; none where they are not known.
    """
    if target in PROGRAMS:
        return ExportedFile(program(model, PROGRAMS[target], rule.rate, remarks), tuple(omitted(model, target, rule)))
    if target is Target.IMUGAP:
        return ExportedFile(_imugap(model, rule), ())
    notes, lines = _written(model, target, rule, bounds, limits)
    lacking = tuple(omitted(model, target, rule, distance))
    said = (*remarks, *notes, *(f"Left out: {one}" for one in lacking))
    comment = _comment(target)
    if comment is None:
        return ExportedFile("\n".join(lines) + "\n", lacking, said)
    shown = (comment.format(note.replace("--", "-")) for note in said)
    return ExportedFile("\n".join([*shown, *lines]) + "\n", lacking)


def export(
    model: ErrorModel, target: Target, rule: Rule, bounds: Mapping[str, Sequence[Effect]] = MappingProxyType({})
) -> str:
    """Return the text of the file for ``target``; parameters as :func:`exported`."""
    return exported(model, target, rule, bounds).text


def notes(
    model: ErrorModel, target: Target, rule: Rule, bounds: Mapping[str, Sequence[Effect]] = MappingProxyType({})
) -> list[str]:
    """Return the notes of a file whose format has no comments; none for any other, which begins with them."""
    return list(exported(model, target, rule, bounds).notes)


def _comment(target: Target) -> str | None:
    """Return the form of a comment in the file for a target; None for a format without comments."""
    return SIMULATORS[target].comment if target in SIMULATORS else "# {}"


def also_kept(target: Target) -> tuple[type[Effect], ...]:
    """Return the effects that a target keeps beside those that every target keeps."""
    return SIMULATORS[target].also_kept if target in SIMULATORS else ()


def omitted(model: ErrorModel, target: Target, rule: Rule, distance: Distance | None = None) -> list[str]:
    """Return what the file for a target leaves out, with the size of each effect and what it costs."""
    if target in PROGRAMS:
        return [f"{effect}, which has no form sample by sample" for effect in without_form(model, 1 / rule.rate)]
    if target is Target.IMUGAP:
        return []
    return [one.sentence() for one in _left_out(model, also_kept(target), rule, distance)]


def _written(
    model: ErrorModel,
    target: Target,
    rule: Rule,
    bounds: Mapping[str, Sequence[Effect]],
    limits: Mapping[str, Limits],
) -> Written:
    """Return notes and lines of the file for a target."""
    model = ErrorModel({axis: AxisModel((*one, *bounds.get(axis, ()))) for axis, one in model.axes.items()})
    model = model.require_axes("model")
    if target in WRITERS:
        notes, lines = WRITERS[target](model, rule, LogEvidence(bounds, limits))
    else:
        simulator, axes = SIMULATORS[target], reduced_axes(model, rule)
        own, lines = simulator.write(model, axes, rule)
        notes = [*_head(model, simulator.convention, rule, simulator.processes(axes, rule)), *own]
    return [*_of_bounds(bounds), *notes], lines


@dataclass(frozen=True)
class LogEvidence:
    """What the log of a model determines: processes that it only bounds, and limits of the reduced model, by axis."""

    bounds: Mapping[str, Sequence[Effect]]
    limits: Mapping[str, Limits]

    def unseen(self, parameter: Parameter, kind: str) -> str:
        """Return that a number for three axes is an upper bound, and on which; nothing for an estimate."""
        process = {"N": WhiteNoise, "K": RandomWalk}[parameter.formula[0]]
        own = log.TRIADS[kind]
        axes = [axis for axis in own if any(isinstance(one, process) for one in self.bounds.get(axis, ()))]
        if not axes:
            return ""
        return "upper bound" + ("" if len(axes) == len(own) else f" on {', '.join(axes)}") + ": the log shows none"


def _kalibr(model: ErrorModel, rule: Rule, evidence: LogEvidence) -> Written:
    notes, lines = _per_triad(model, KALIBR, rule, evidence, Target.KALIBR, "Kalibr refuses a random walk of 0")
    lines += [f"rostopic: {rule.topic or '/imu0  # set to yours'}", f"update_rate: {round(float(rule.rate), 4)}  # Hz"]
    return notes, lines


def _vins(model: ErrorModel, rule: Rule, evidence: LogEvidence) -> Written:
    reason = "with a random walk of 0 the covariance of VINS has no inverse"
    notes, lines = _per_triad(model, VINS, rule, evidence, Target.VINS, reason)
    notes += [
        f"Valid at {rule.rate:g} Hz only: VINS takes the numbers per sample.",
        "acc_n and gyr_n hold a factor sqrt(2): VINS takes the two samples of its midpoint rule for independent of",
        "those of the next step, and would else propagate half the variance.",
    ]
    return notes, lines


def _per_triad(
    model: ErrorModel, convention: Convention, rule: Rule, evidence: LogEvidence, target: Target, reason: str
) -> Written:
    """Return notes and lines for a tool with one white noise and one random walk for each triad."""
    axes = reduced_axes(model, rule)
    triads = by_triad(axes, rule)
    for kind, one in triads.items():
        if not one.walk:
            raise ValueError(
                f"{kind}: expected a slow process; found white noise alone ({reason}). Next step: `imugap estimate LOG "
                f"--to {target} FILE` writes the largest random walk that a log at rest allows"
            )
    lines = [
        line
        for kind, some in parameters(convention).items()
        for one in some
        for line in _lines_of_triad(one, kind, model, rule, evidence)
    ]
    notes = [
        *_head(model, convention, rule, random_walk_of_triad(axes, rule)),
        f"Each number stands for three axes: {RULES[rule.triad]}.",
        *(f"  {axis}: N = {number(one.white)}, K = {number(one.walk)}" for axis, one in axes.items()),
        "Bias and turn-on bias have no place here: the tool estimates the bias.",
        *AT_REST,
    ]
    return notes, lines


def _lines_of_triad(parameter: Parameter, kind: str, model: ErrorModel, rule: Rule, evidence: LogEvidence) -> list[str]:
    """Return the line of a number for three axes with what is known of it, and of a walk what the horizon changes."""
    rules = (replace(rule, horizon=time) for time in (rule.horizon, *HORIZONS))
    at = {one.horizon: by_triad(reduced_axes(model, one), one)[kind] for one in rules}
    value = number(_shown(parameter, at[rule.horizon], rule))
    said = [parameter.unit, parameter.meaning, evidence.unseen(parameter, kind)]
    own = log.TRIADS[kind]
    if set(own) <= set(evidence.limits):
        axes = [reduced(axis, model[axis], rule) for axis in own]
        interval = combined_limits(axes, [evidence.limits[axis] for axis in own], rule.triad).interval(parameter, rule)
        said.append(interval and f"95 %: {ends_text(*(from_si(one, parameter.unit) for one in interval))}")
    line = f"{parameter.name}: {value}  # {', '.join(filter(None, said))}"
    others = [f"{_shown(parameter, at[time], rule):.2e} at {time:g} s" for time in HORIZONS]
    constant = isclose(*(parameter.value(at[time], rule) for time in (HORIZONS[0], HORIZONS[-1])), rel_tol=ALIKE)
    return [line] if constant else [line, f"#   with another horizon: {', '.join(others)}"]


def _ros(model: ErrorModel, rule: Rule, evidence: LogEvidence) -> Written:
    axes = reduced_axes(model, rule)
    lines = [f"orientation_covariance: [-1.0, {', '.join(8 * ['0.0'])}]  # no estimate of the orientation"]
    for kind, (parameter,) in parameters(ROS).items():
        diagonal = np.diag([parameter.value(axes[axis], rule) for axis in log.TRIADS[kind]]).ravel()
        lines.append(f"{parameter.name}: [{', '.join(map(number, diagonal))}]  # {parameter.unit}")
    notes = [
        *_head(model, ROS, rule, {axis: (WhiteNoise(one.white),) for axis, one in axes.items()}),
        f"Valid at {rule.rate:g} Hz only: the message holds the variance of a sample.",
        "Biases and slow processes are no part of the variance of a sample: the filter has to estimate them.",
    ]
    return notes, lines


def _kf_gins(model: ErrorModel, rule: Rule, evidence: LogEvidence) -> Written:
    rule = replace(rule, correlation_time=rule.correlation_time or HOUR)
    axes = reduced_axes(model, rule)
    rows = {}
    for kind, some in parameters(KF_GINS).items():
        for one in some:
            values = [number(_shown(one, axes[axis], rule)) for axis in log.TRIADS[kind]]
            rows[one.name] = f"{one.name}: [{', '.join(values)}]  # {one.unit}"
    common = KF_GINS.accel[-1]
    rows[common.name] = f"{common.name}: {number(_shown(common, axes['accel_x'], rule))}  # {common.unit}"
    lines = [rows[name] for name in ("initgyrbias", "initaccbias", "initbgstd", "initbastd")]
    lines += ["imunoise:", *(f"  {rows[name]}" for name in ("arw", "vrw", "gbstd", "abstd"))]
    lines += [f"  {name}: [0.0, 0.0, 0.0]  # ppm" for name in ("gsstd", "asstd")] + [f"  {rows['corrtime']}"]
    notes = [
        *_head(model, KF_GINS, rule, gauss_markov_of_axis(axes, rule)),
        "Axes: forward, right, down, as those of the model. One correlation time for all biases.",
        "The model holds no scale factor errors: set gsstd and asstd from the data sheet.",
        "KF-GINS holds a bias for good whose initial standard deviation and gbstd or abstd are zero: neither is here.",
        *AT_REST,
    ]
    return notes, lines


def _imugap(model: ErrorModel, rule: Rule) -> str:
    """Write the model and, per axis, Phi, Qd, H, Rd of its discrete state space and the covariance at power-on."""
    axes = {}
    for axis, one in model.sensors.items():
        try:
            space = augmentation(one)
        except ValueError as error:
            raise ValueError(f"{axis}: {error}") from error
        transition, noise = space.discretise(1 / rule.rate)
        axes[axis] = {
            "Phi": transition.tolist(), "Qd": noise.tolist(), "H": space.output.tolist(),
            "Rd": float(space.output_psd * rule.rate), "P0": space.initial_covariance.tolist(),
        }  # fmt: skip
    notes = [
        "Error model and its discrete state space, SI. Per axis: z(k+1) = Phi z(k) + w, cov w = Qd; error = H z + v,",
        "var v = Rd; cov z(0) = P0, mean 0. A random walk and the turn-on bias share a state. Take off the bias first.",
        *(f"Not in the state space: {axis} {effect.name}" for axis in model.axes for effect in left_out(model[axis])),
    ]
    body = {"rate_hz": float(rule.rate), "model": model.to_mapping(), "axes": axes}
    return _commented(notes, [yaml.safe_dump(body, sort_keys=False, default_flow_style=None, width=100).rstrip()])


RULES = {
    Triad.MEAN_SQUARE: "the root mean square, which keeps the sum of their variances (rms)",
    Triad.WORST: "the largest, so that no axis is underestimated (worst)",
}
"""How three axes become one number, and why."""
AT_REST = (
    "Values of a device at rest. A filter in motion takes more: for cheap MEMS devices 10 to 20 times as much is usual",
    "(ethz-asl/kalibr issue 663). Begin with a factor for each, then change it until the innovations of the filter are",
    "as large as it states:",
    "  noise density: 10. Vibration, scale factor and misalignment in motion act as fast as this noise; none shows at",
    "  rest.",
    "  random walk: 10. Temperature, and the wandering of the bias over times longer than the horizon, act as slowly",
    "  as this walk; a log at one temperature shows them in part.",
)

PROGRAMS: Mapping[Target, Language] = {
    Target.PYTHON: Language.PYTHON,
    Target.CPP: Language.CPP,
    Target.GAZEBO_PLUGIN: Language.GAZEBO_PLUGIN,
}
"""Targets that are source code."""
SIMULATORS: Mapping[Target, Simulator] = {
    Target.AIRSIM: simulator_files.AIRSIM_FILE,
    Target.GAZEBO: simulator_files.GAZEBO_FILE,
    Target.GENESIS: simulator_files.GENESIS_FILE,
    Target.GNSS_INS_SIM: simulator_files.GNSS_INS_SIM_FILE,
    Target.ISAAC_LAB: simulator_files.ISAAC_LAB_FILE,
    Target.MATLAB: simulator_files.MATLAB_FILE,
    Target.PEGASUS: simulator_files.PEGASUS_FILE,
}
WRITERS: Mapping[Target, Callable[[ErrorModel, Rule, LogEvidence], Written]] = {
    Target.KALIBR: _kalibr,
    Target.VINS: _vins,
    Target.ROS: _ros,
    Target.KF_GINS: _kf_gins,
}


def _of_bounds(bounds: Mapping[str, Sequence[Effect]]) -> list[str]:
    """Return notes on the limits that stand for estimates."""
    notes = [
        f"Upper bound (one-sided 95 %), no estimate: {axis} {_described(effect)}"
        for axis, effects in bounds.items() for effect in effects
    ]  # fmt: skip
    return [*notes, "The log shows no such process there; a longer log lowers the bound."] if notes else []


def _left_out(
    model: ErrorModel, also_kept: tuple[type[Effect], ...], rule: Rule, distance: Distance | None
) -> list[Omission]:
    """Return what a tool leaves out, with its cost, of each axis."""
    longest = 10 * rule.horizon
    return [
        one for axis in log.AXES if axis in model.axes
        for one in costs(axis, model[axis], left_out(model[axis], also_kept), 1 / rule.rate, longest, distance)
    ]  # fmt: skip


def _head(model: ErrorModel, convention: Convention, rule: Rule, taken: Mapping[str, Sequence[Effect]]) -> list[str]:
    """Return the head of a file: target, sources, Allan deviation of the exported effects over the model."""
    tau = np.geomspace(1 / rule.rate, 10 * rule.horizon, 200)
    ratios = {
        axis: np.sqrt(AxisModel(tuple(effects)).allan_variance(tau) / model[axis].allan_variance(tau))
        for axis, effects in taken.items()
    }
    return [
        f"Error model for {convention.tool}.",
        f"Conventions: {convention.source}.",
        f"A slow process here has the Allan variance of all slow processes of the model at {rule.horizon:g} s.",
        f"Allan deviation here over that of the model, not of the log, {tau[0]:g} to {tau[-1]:g} s. Above 1 the tool",
        "takes the errors over such a time for larger than they are; below 1 for smaller, trusting the sensor too far.",
        *(f"  {axis}: {_range(ratio, tau)}" for axis, ratio in ratios.items()),
    ]


def _range(ratio: np.ndarray, tau: np.ndarray) -> str:
    """Return the range of a ratio over times, both of shape (times,), and the time at which it is farthest from 1."""
    ends = f"{ratio.min():.2f} to {ratio.max():.2f}"
    off = np.abs(np.log(ratio))
    return ends if off.max() < ALIKE else f"{ends}, farthest from 1 at {tau[np.argmax(off)]:.3g} s"


def _described(effect: Effect) -> str:
    return f"{effect.name} ({', '.join(f'{name} {number(value)}' for name, value in effect.parameters().items())})"


def _shown(parameter: Parameter, of: Reduced, rule: Rule) -> float:
    return from_si(parameter.value(of, rule), parameter.unit)


def _commented(notes: Iterable[str], lines: Iterable[str]) -> str:
    return "\n".join([*(f"# {note}" for note in notes), *lines]) + "\n"
