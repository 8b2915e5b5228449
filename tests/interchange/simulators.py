"""What simulators make of the numbers of an exported file: their noise algorithms, restated from their sources.

Each function reads the file as the simulator does, and returns the error of one axis, shape (count,). ``defect`` names
a fault that users reported, which the restatement then has. Versions: gz-sensors 9ba02f2, rotors_simulator 04f25c6,
AirSim 006d4e2, gnss-ins-sim 966ff27, PegasusSimulator 2c99164, Genesis with acc_noise.
"""

import json
import xml.etree.ElementTree as ET
from enum import Enum, auto
from math import exp, expm1, pi, sqrt

import numpy as np

DEG = pi / 180


class Defect(Enum):
    """Fault of a simulator."""

    OTHER_TIME = auto()
    """The bias takes the correlation time of the other sensor (Pegasus: gyroscopes that of the accelerometers)."""
    UNIFORM = auto()
    """Uniform numbers in the place of normal ones (rand for randn)."""
    NO_BIAS = auto()
    """The bias is propagated, but not added."""
    NOT_SCALED = auto()
    """The density is taken for the standard deviation of a sample."""


def _drawn(rng, count, defect=None):
    """Independent numbers of variance one."""
    return rng.uniform(-sqrt(3), sqrt(3), count) if defect is Defect.UNIFORM else rng.standard_normal(count)


def _recursion(decay, drive, first=0.0):
    """x(k) = decay x(k - 1) + drive(k), from ``first`` before the first sample."""
    values, level = np.empty(len(drive)), first
    for k, step in enumerate(drive):
        level = decay * level + step
        values[k] = level
    return values


def _exact(random_walk, time, interval, count, rng, first=0.0):
    """A Gauss-Markov process by its exact step, from the density of the noise that drives it (Maybeck 4-114)."""
    drive = sqrt(-(random_walk**2) * time / 2 * expm1(-2 * interval / time))
    return _recursion(exp(-interval / time), drive * rng.standard_normal(count), first)


def gazebo(text, axis, rate, count, rng):
    """gazebosim/gz-sensors: src/GaussianNoiseModel.cc (Load, ApplyImpl)."""
    element = "angular_velocity" if axis.startswith("gyro") else "linear_acceleration"
    noise = ET.fromstring(text).find(f"{element}/{axis[-1]}/noise")
    names = (
        "mean", "stddev", "bias_mean", "bias_stddev", "dynamic_bias_stddev", "dynamic_bias_correlation_time",
        "precision",
    )  # fmt: skip
    mean, std, start, spread, dynamic, time, precision = (float(noise.findtext(name) or 0) for name in names)
    bias = (start + spread * rng.standard_normal()) * rng.choice([-1, 1])
    biases = np.full(count, bias)
    if dynamic > 0 and time > 0:
        biases = _exact(dynamic, time, 1 / rate, count, rng, bias)
    output = biases + mean + std * rng.standard_normal(count)
    return np.rint(output / precision) * precision if precision > 1e-6 else output


def airsim(text, axis, rate, count, rng, defect=None):
    """microsoft/AirSim: AirLib/include/sensors/imu/ImuSimple.hpp (addNoise), ImuSimpleParams.hpp (units)."""
    (vehicle,) = json.loads(text)["Vehicles"].values()
    own = vehicle["Sensors"]["Imu"]
    if axis.startswith("gyro"):
        white = own["AngularRandomWalk"] / 60 * DEG
        stability, time = own["GyroBiasStability"] / 3600 * DEG, own["GyroBiasStabilityTau"]
    else:
        white = own["VelocityRandomWalk"] * 9.80665e-3
        stability, time = own["AccelBiasStability"] * 9.80665e-6, own["AccelBiasStabilityTau"]
    root = sqrt(1 / rate)
    walk = np.concatenate([[0.0], np.cumsum(stability / sqrt(time) * root * rng.standard_normal(count - 1))])
    scaled = white if defect is Defect.NOT_SCALED else white / root
    return scaled * _drawn(rng, count, defect) + (0.0 if defect is Defect.NO_BIAS else walk)


def _python(text):
    """The dictionaries that a file in Python defines."""
    found = {}
    exec(compile(text.replace("from isaaclab.utils.noise import", "# "), "exported", "exec"), found)
    return found


def gnss_ins_sim(text, axis, rate, count, rng):
    """Aceinna/gnss-ins-sim: gnss_ins_sim/pathgen/pathgen.py (acc_gen, gyro_gen, bias_drift), imu_model.py (units)."""
    errors, k = _python(text)["imu_err"], "xyz".index(axis[-1])
    sensor, white, unit = ("gyro", "arw", DEG / 3600) if axis.startswith("gyro") else ("accel", "vrw", 1.0)
    density = errors[f"{sensor}_{white}"][k] / 60 * (DEG if sensor == "gyro" else 1.0)
    drift, time = errors[f"{sensor}_b_stability"][k] * unit, errors[f"{sensor}_b_corr"][k]
    drive = drift * sqrt(1 - exp(-2 / (rate * time))) * rng.standard_normal(count)
    drive[0] = 0.0
    drifts = _recursion(1 - 1 / rate / time, drive)
    return errors[f"{sensor}_b"][k] * unit + drifts + density * sqrt(rate) * rng.standard_normal(count)


def pegasus(text, axis, rate, count, rng, defect=None):
    """PegasusSimulator: logic/sensors/imu.py (update), with its bias added, as rotors_simulator does, which it follows.

    ethz-asl/rotors_simulator: rotors_gazebo_plugins/src/gazebo_imu_plugin.cpp (addNoise).
    """
    own = _python(text)["imu_config"]
    sensor = "gyroscope" if axis.startswith("gyro") else "accelerometer"
    time = own["accelerometer" if defect is Defect.OTHER_TIME else sensor]["bias_correlation_time"]
    bias = _exact(own[sensor]["random_walk"], time, 1 / rate, count, rng)
    white = own[sensor]["noise_density"] * sqrt(rate) * _drawn(rng, count, defect)
    return white + (0.0 if defect is Defect.NO_BIAS else bias)


def genesis(text, axis, rate, count, rng):
    """Genesis: genesis/engine/sensors/base_sensor.py (_add_noise_drift_bias, _quantize_to_resolution)."""
    own, k = _python(text)["imu_options"], "xyz".index(axis[-1])
    prefix = "gyro" if axis.startswith("gyro") else "acc"
    noise, walk, bias = (own[f"{prefix}_{name}"][k] for name in ("noise", "random_walk", "bias"))
    output = bias + np.cumsum(walk * rng.standard_normal(count)) + noise * rng.standard_normal(count)
    step = own.get(f"{prefix}_resolution", (0.0, 0.0, 0.0))[k]
    return np.round(output / step) * step if step > 0 else output


def matlab(text, axis, rate, count, rng):
    """MATLAB imuSensor: gyroparams, accelparams; white noise, random walk and bias of a double-sided NoiseType."""
    part = json.loads(text)["imugap"]["Gyroscope" if axis.startswith("gyro") else "Accelerometer"]
    k = "xyz".index(axis[-1])
    white, walk, bias = (part[name][k] for name in ("NoiseDensity", "RandomWalk", "ConstantBias"))
    steps = walk / sqrt(rate) * rng.standard_normal(count)
    return bias + np.cumsum(steps) + white * sqrt(rate) * rng.standard_normal(count)
