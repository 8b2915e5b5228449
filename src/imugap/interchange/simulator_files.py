"""Files of simulators: AirSim, Gazebo, Genesis, gnss-ins-sim, Isaac Lab, Pegasus, and MATLAB's ``imuSensor``.

Each function that writes one returns notes on the file, and its lines. The conventions are those of
:mod:`imugap.interchange.conventions`.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from imugap.effects import (
    Effect,
    GaussMarkov,
    Misalignment,
    RandomWalk,
    Resolution,
    Saturation,
    ScaleFactor,
    Temperature,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import (
    AIRSIM,
    GAZEBO,
    GENESIS,
    GNSS_INS_SIM,
    ISAAC_LAB,
    MATLAB,
    PEGASUS,
    Convention,
    Parameter,
    Reduced,
    Rule,
    by_triad,
)
from imugap.log import TRIADS
from imugap.model import ErrorModel
from imugap.units import from_si

Axes = Mapping[str, Reduced]
"""Reduced model of each axis."""
Written = tuple[list[str], list[str]]
"""Notes, and lines."""
FINEST = 1e-6
"""Precision below which Gazebo does not round."""
NO_BIAS = "Bias and turn-on bias have no place here."
PER_STEP = "Valid at {rate:g} Hz only: the numbers are those of a step."


@dataclass(frozen=True)
class Simulator:
    """File of a simulator.

    Attributes
    ----------
    convention
        Its parameters, with the source in which they were read.
    write
        Function (model, reduced axes, rule) that returns notes and lines.
    processes
        Function (reduced axes, rule) that returns the processes of each axis that stand for those of the model.
    also_kept
        Effects that it keeps beside these.
    comment
        Form of a comment; None for a format without comments.
    """

    convention: Convention
    write: Callable[[ErrorModel, Axes, Rule], Written]
    processes: Callable[[Axes, Rule], Mapping[str, Sequence[Effect]]]
    also_kept: tuple[type[Effect], ...] = ()
    comment: str | None = "# {}"


def parameters(convention: Convention) -> dict[str, tuple[Parameter, ...]]:
    """Return the parameters of a convention by kind of sensor."""
    return {"gyro": convention.gyro, "accel": convention.accel}


def number(value: float) -> str:
    """Format a number for YAML 1.1: with a decimal point also where it has an exponent."""
    return "0.0" if value == 0 else f"{value:.6e}"


def random_walk_of_triad(axes: Axes, rule: Rule) -> dict[str, Sequence[Effect]]:
    """Return white noise and random walk of each axis, those of its triad."""
    triads = by_triad(axes, rule)
    return {
        axis: (WhiteNoise(triads[kind].white), RandomWalk(triads[kind].walk))
        for kind, own in TRIADS.items() for axis in own
    }  # fmt: skip


def random_walk_of_axis(axes: Axes, rule: Rule) -> dict[str, Sequence[Effect]]:
    """Return white noise and random walk of each axis."""
    return {axis: (WhiteNoise(one.white), RandomWalk(one.walk)) for axis, one in axes.items()}


def gauss_markov_of_triad(axes: Axes, rule: Rule) -> dict[str, Sequence[Effect]]:
    """Return white noise and Gauss-Markov process of each axis, those of its triad."""
    triads = by_triad(axes, rule)
    return {
        axis: (WhiteNoise(triads[kind].white), GaussMarkov(triads[kind].markov, triads[kind].correlation_time))
        for kind, own in TRIADS.items() for axis in own
    }  # fmt: skip


def gauss_markov_of_axis(axes: Axes, rule: Rule) -> dict[str, Sequence[Effect]]:
    """Return white noise and Gauss-Markov process of each axis."""
    return {axis: (WhiteNoise(one.white), GaussMarkov(one.markov, one.correlation_time)) for axis, one in axes.items()}


def white_of_axis(axes: Axes, rule: Rule) -> dict[str, Sequence[Effect]]:
    """Return the white noise of each axis."""
    return {axis: (WhiteNoise(one.white),) for axis, one in axes.items()}


def airsim(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the settings of AirSim."""
    triads = by_triad(axes, rule)
    imu = {"SensorType": 2, "Enabled": True}
    for kind, some in parameters(AIRSIM).items():
        imu |= {one.name: _rounded(from_si(one.value(triads[kind], rule), one.unit)) for one in some}
    vehicle = {"VehicleType": "SimpleFlight", "Sensors": {"Imu": imu}}
    settings = {"SettingsVersion": 1.2, "SimMode": "Multirotor", "Vehicles": {"Drone1": vehicle}}
    notes = [NO_BIAS, "The bias begins at zero, and is a random walk.", "Merge the Sensors into your settings.json."]
    return notes, json.dumps(settings, indent=2).splitlines()


def gazebo(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the ``imu`` element of the SDF of Gazebo."""
    lines = ["<imu>"]
    for kind, some in parameters(GAZEBO).items():
        element = some[0].name.split()[0]
        lines.append(f"  <{element}>")
        for axis in TRIADS[kind]:
            values = [(one.name.split()[1], number(one.value(axes[axis], rule))) for one in some]
            precision = _precision(model[axis])
            noise = "".join(f"<{name}>{value}</{name}>" for name, value in (*values, *precision))
            form = "gaussian_quantized" if precision else "gaussian"
            lines.append(f'    <{axis[-1]}><noise type="{form}">{noise}</noise></{axis[-1]}>')
        lines.append(f"  </{element}>")
    notes = [
        f"Valid at {rule.rate:g} Hz only: stddev is that of a sample.",
        "dynamic_bias_stddev is the density of the driving noise, not the standard deviation of the bias.",
        "mean is added to every sample. Gazebo would draw the sign of bias_mean, and let it decay.",
    ]
    return notes, [*lines, "</imu>"]


def _precision(model: AxisModel) -> list[tuple[str, str]]:
    """Return the precision of an axis with a resolution that Gazebo applies."""
    steps = [one.step for one in model if isinstance(one, Resolution) and one.step >= FINEST]
    return [("precision", number(max(steps)))] if steps else []


def gnss_ins_sim(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the dictionary of IMU errors of gnss-ins-sim."""
    lines = ["import numpy as np", "", "imu_err = {"]
    for kind, some in parameters(GNSS_INS_SIM).items():
        for one in some:
            values = [from_si(one.value(axes[axis], rule), one.unit) for axis in TRIADS[kind]]
            lines.append(f'    "{one.name}": np.array([{", ".join(map(_text, values))}]),  # {one.unit}')
    lines += ["}", "# imu = imu_model.IMU(accuracy=imu_err, axis=6, gps=False)"]
    notes = ["The drift of a bias begins at zero; there is no spread from power-on to power-on."]
    return notes, lines


def pegasus(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the configuration of the IMU of Pegasus."""
    triads, lines = by_triad(axes, rule), ["imu_config = {"]
    for kind, some in parameters(PEGASUS).items():
        sensor = some[0].name.split()[0]
        lines.append(f'    "{sensor}": {{')
        lines += [f'        "{one.name.split()[1]}": {_text(one.value(triads[kind], rule))},  # {one.unit}'
                  for one in some]  # fmt: skip
        lines.append("    },")
    lines += [f'    "update_rate": {float(rule.rate)},', "}", "# imu = IMU(imu_config)"]
    notes = [
        "The code of Pegasus does not add the bias to the output, gives the gyroscopes the correlation time of the",
        "accelerometers, and does not use turn_on_bias_sigma: as it is, its log has the white noise alone.",
        "A constant bias has no place here.",
    ]
    return notes, lines


def genesis(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the options of the IMU of Genesis."""
    lines = ["imu_options = {"]
    for kind, some in parameters(GENESIS).items():
        for one in some:
            values = [from_si(one.value(axes[axis], rule), one.unit) for axis in TRIADS[kind]]
            lines.append(f'    "{one.name}": ({", ".join(map(_text, values))}),  # {one.unit}')
        steps = [_only(model[axis], Resolution, "step") for axis in TRIADS[kind]]
        if any(steps):
            lines.append(f'    "{some[0].name.split("_")[0]}_resolution": ({", ".join(map(_text, steps))}),')
    lines += ["}", "# imu = scene.add_sensor(gs.sensors.IMU(entity_idx=0, **imu_options))"]
    return [PER_STEP.format(rate=rule.rate), "The walk begins at zero at each reset."], lines


def isaac_lab(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return the configuration of the noise of observations in Isaac Lab."""
    names = {"gyro": "angular_velocity", "accel": "linear_acceleration"}
    lines = ["from isaaclab.utils.noise import GaussianNoiseCfg, NoiseModelWithAdditiveBiasCfg", ""]
    triads, biases = by_triad(axes, rule), []
    for kind, (white, mean, spread) in parameters(ISAAC_LAB).items():
        of_axes = ", ".join(_text(axes[axis].bias) for axis in TRIADS[kind])
        biases.append(f"mean of {names[kind]} is the mean of the biases of x, y and z: {of_axes} {white.unit}.")
        values = [_text(one.value(triads[kind], rule)) for one in (white, mean, spread)]
        lines += [
            f"{names[kind]}_noise = NoiseModelWithAdditiveBiasCfg(",
            f"    noise_cfg=GaussianNoiseCfg(mean=0.0, std={values[0]}),  # {white.unit}",
            f"    bias_noise_cfg=GaussianNoiseCfg(mean={values[1]}, std={values[2]}),",
            ")",
        ]
    constant = "The bias is constant between resets: there is no slow process."
    return [PER_STEP.format(rate=rule.rate), constant, *biases], lines


def matlab(model: ErrorModel, axes: Axes, rule: Rule) -> Written:
    """Return a part for ``loadparams`` of MATLAB's ``imuSensor``."""
    part = {}
    for kind, name in (("accel", "Accelerometer"), ("gyro", "Gyroscope")):
        own = TRIADS[kind]
        ranges = [_only(model[axis], Saturation, "limit") for axis in own]
        part[name] = {
            "MeasurementRange": _rounded(max(ranges)) if all(ranges) else None,
            "Resolution": _rounded(max(_only(model[axis], Resolution, "step") for axis in own)),
            **{
                one.name.split()[1]: [_rounded(one.value(axes[axis], rule)) for axis in own]
                for one in parameters(MATLAB)[kind]
            },
            "BiasInstability": [0.0, 0.0, 0.0],
            "AxesMisalignment": [_shares(model[axis], k) for k, axis in enumerate(own)],
            "TemperatureBias": [_rounded(_only(model[axis], Temperature, "coefficient")) for axis in own],
            "NoiseType": "double-sided",
        }
    notes = [
        'Read it with loadparams(imu, file, "imugap"); SampleRate of the sensor as above.',
        "Three axes have one full scale and one resolution there: the largest.",
    ]
    return notes, json.dumps({"imugap": part}, indent=2).splitlines()


def _shares(model: AxisModel, k: int) -> list[float]:
    """Return the row of AxesMisalignment [%] of axis k."""
    row = [0.0, 0.0, 0.0]
    for effect in model:
        if isinstance(effect, Misalignment):
            row = [a + b for a, b in zip(row, (effect.x, effect.y, effect.z), strict=True)]
    row[k] = 1.0 + _only(model, ScaleFactor, "error")
    return [_rounded(100 * one) for one in row]


def _only(model: AxisModel, kind: type[Effect], name: str) -> float:
    """Return the sum of a parameter over the effects of a kind; zero where there is none."""
    return float(sum(getattr(one, name) for one in model if isinstance(one, kind)))


def _rounded(value: float) -> float:
    return float(f"{value:.7g}")


def _text(value: float) -> str:
    return repr(_rounded(value))


AIRSIM_FILE = Simulator(AIRSIM, airsim, random_walk_of_triad, comment=None)
GAZEBO_FILE = Simulator(GAZEBO, gazebo, gauss_markov_of_axis, (Resolution,), "<!-- {} -->")
GENESIS_FILE = Simulator(GENESIS, genesis, random_walk_of_axis, (Resolution,))
GNSS_INS_SIM_FILE = Simulator(GNSS_INS_SIM, gnss_ins_sim, gauss_markov_of_axis)
ISAAC_LAB_FILE = Simulator(ISAAC_LAB, isaac_lab, white_of_axis)
MATLAB_FILE = Simulator(
    MATLAB, matlab, random_walk_of_axis, (Resolution, Saturation, Temperature, ScaleFactor, Misalignment), comment=None
)
PEGASUS_FILE = Simulator(PEGASUS, pegasus, gauss_markov_of_triad)
