"""Noise parameters of common filters and simulators: names, units, and how they follow from an error model.

Every convention was read in the code that uses the numbers: the value given here is the one with which the tool
propagates the covariance (or draws the noise) of the model. ``source`` gives repository and file.

A tool has white noise and at most one slow process. Other effects are reduced (:class:`Reduced`): white noises
to one, and random walk, Gauss-Markov, flicker and power-law processes together to one process of the
tool's kind with the same Allan variance at one averaging time, the horizon. For a Gauss-Markov process far slower than
the horizon this is a random walk with K^2 = S_B = 2 std^2/T; a random walk keeps its K.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from enum import StrEnum
from math import hypot, inf, sqrt

import numpy as np

from imugap.effects import Bias, BiasInstability, Effect, GaussMarkov, PowerLaw, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.effects.power_law import STEEPEST
from imugap.log import AXES, TRIADS
from imugap.model import ErrorModel

SLOW = (RandomWalk, GaussMarkov, BiasInstability, PowerLaw)
"""Effects that are reduced to the slow process of a tool."""
KEPT = (WhiteNoise, Bias, TurnOnBias, *SLOW)
HOUR = 3600.0
FAST = 0.01
"""Correlation time [horizons] below which a Gauss-Markov process stands for white noise where a model has none."""
LONGEST = 100.0
"""Largest averaging time [horizons] in the search for the floor of the Allan deviation."""


class Triad(StrEnum):
    """Combination of three axes to one number, where a tool has one for a triad."""

    MEAN_SQUARE = "rms"
    """Root mean square: keeps the sum of the variances of the axes."""
    WORST = "worst"
    """The largest: no axis is underestimated (what allan_variance_ros does)."""


@dataclass(frozen=True)
class Rule:
    """Rule of the reduction of a model to the parameters of a tool.

    Attributes
    ----------
    rate
        Sampling rate [Hz].
    horizon
        Averaging time [s] at which the Allan variance of the slow part is kept: about the longest time without aiding.
    correlation_time
        Correlation time [s] of the slow process, where the tool has a Gauss-Markov process. None keeps that of an
        axis whose only slow process is one Gauss-Markov process, and is :data:`HOUR` for any other.
    triad
        Combination of three axes to one number.
    topic
        Topic of ROS on which the samples come; None where it is not known.
    """

    rate: float
    horizon: float = 10.0
    correlation_time: float | None = None
    triad: Triad = Triad.MEAN_SQUARE
    topic: str | None = None

    def __post_init__(self) -> None:
        """Check that times and rates are finite and positive."""
        for name in ("rate", "horizon", "correlation_time"):
            value = getattr(self, name)
            if value is not None and not 0 < value < inf:
                raise ValueError(f"{name}: expected a finite number > 0; found {value}")


@dataclass(frozen=True)
class Reduced:
    """Reduced error model of an axis, or of three axes together; SI.

    Attributes
    ----------
    white
        N.
    walk
        K of the random walk that replaces the slow part.
    markov, correlation_time
        Standard deviation and T of the Gauss-Markov process that replaces it.
    floor
        Smallest Allan deviation of the model.
    bias, turn_on
        Fixed bias, and standard deviation from power-on to power-on.
    start
        Standard deviation of the bias at power-on, from the turn-on bias and the stationary processes of the model. One
        that grows, as a random walk, begins at zero; flicker noise adds little.
    """

    white: float
    walk: float
    markov: float
    correlation_time: float
    floor: float
    bias: float
    turn_on: float
    start: float


def reduced(axis: str, model: AxisModel, rule: Rule) -> Reduced:
    """Reduce the model of an axis; ValueError without white noise, which every tool requires."""
    white = hypot(*(effect.density for effect in _of(model, WhiteNoise)))
    fast = [one for one in _of(model, GaussMarkov) if not white and one.correlation_time < FAST * rule.horizon]
    white = hypot(white, *(sqrt(one.psd(0.0)) for one in fast))
    if not white:
        raise ValueError(f"{axis}: expected white noise; found {', '.join(e.name for e in model) or 'no effect'}")
    for law in _of(model, PowerLaw):
        if law.exponent >= STEEPEST:
            raise ValueError(f"{axis}: {law.name}: expected an exponent below {STEEPEST:g}; found {law.exponent:g}")
    slow_ones = [effect for effect in _of(model, SLOW) if effect not in fast]
    processes = [effect for effect in slow_ones if effect.allan_variance(rule.horizon) > 0]
    slow = sum(float(effect.allan_variance(rule.horizon)) for effect in processes)
    alone = len(processes) == 1 and isinstance(processes[0], GaussMarkov)
    time = rule.correlation_time or (processes[0].correlation_time if alone else HOUR)
    tau = np.geomspace(1 / rule.rate, LONGEST * rule.horizon, 400)
    turn_on = hypot(*(effect.std for effect in _of(model, TurnOnBias)))
    return Reduced(
        white=white,
        walk=sqrt(slow / float(RandomWalk(1.0).allan_variance(rule.horizon))),
        markov=sqrt(slow / float(GaussMarkov(1.0, time).allan_variance(rule.horizon))),
        correlation_time=time,
        floor=float(np.sqrt(model.allan_variance(tau).min())),
        bias=sum(effect.value for effect in _of(model, Bias)),
        turn_on=turn_on,
        start=hypot(turn_on, *(effect.std for effect in slow_ones if isinstance(effect, GaussMarkov))),
    )


def combined(axes: Iterable[Reduced], triad: Triad) -> Reduced:
    """Return one set of numbers for several axes; the biases, which have a sign, are averaged."""
    axes = tuple(axes)
    spread = {item.name: [getattr(one, item.name) for one in axes] for item in fields(Reduced)}
    bias = float(np.mean(spread.pop("bias")))
    join = max if triad is Triad.WORST else lambda values: float(np.sqrt(np.mean(np.square(values))))
    return Reduced(bias=bias, **{name: join(values) for name, values in spread.items()})


def reduced_axes(model: ErrorModel, rule: Rule) -> dict[str, Reduced]:
    """Return the reduced model of each inertial axis."""
    return {axis: reduced(axis, model[axis], rule) for axis in AXES}


def by_triad(axes: Mapping[str, Reduced], rule: Rule) -> dict[str, Reduced]:
    """Return one reduced model for the three axes of each kind of sensor."""
    return {kind: combined((axes[axis] for axis in own), rule.triad) for kind, own in TRIADS.items()}


def left_out(model: AxisModel, also_kept: tuple[type[Effect], ...] = ()) -> list[Effect]:
    """Return the effects that a tool does not represent, where it keeps some kinds beside those of all tools."""
    return [effect for effect in model if not isinstance(effect, (*KEPT, *also_kept))]


def _of(model: AxisModel, kind: type | tuple[type, ...]) -> list:
    return [effect for effect in model if isinstance(effect, kind)]


@dataclass(frozen=True)
class Parameter:
    """Parameter of a tool.

    Attributes
    ----------
    name, meaning, unit, formula
        Name in the tool; meaning; unit (of :mod:`imugap.units`); formula in N, K, sigma and T.
    value
        Function of the reduced model, SI.
    """

    name: str
    meaning: str
    unit: str
    formula: str
    value: Callable[[Reduced, Rule], float]


@dataclass(frozen=True)
class Convention:
    """Parameters of a tool for gyroscopes and accelerometers, and the source files of the convention."""

    tool: str
    source: str
    gyro: tuple[Parameter, ...]
    accel: tuple[Parameter, ...]

    def parameters(self) -> tuple[Parameter, ...]:
        """Return all parameters, gyroscopes first."""
        return self.gyro + self.accel

    def unit(self, name: str) -> str:
        """Return the unit of a parameter, by its name in the tool."""
        return next(one.unit for one in self.parameters() if one.name == name)


def _white(of: Reduced, rule: Rule) -> float:
    return of.white


def _walk(of: Reduced, rule: Rule) -> float:
    return of.walk


def _markov(of: Reduced, rule: Rule) -> float:
    return of.markov


def _sample(of: Reduced, rule: Rule) -> float:
    return of.white * sqrt(rule.rate)


def _start(of: Reduced, rule: Rule) -> float:
    return of.start


def _open_start(of: Reduced, rule: Rule) -> float:
    """Return the deviation with which a filter starts the process that it takes for the slow part."""
    return hypot(of.turn_on, of.markov)


def _densities(gyro_n: str, gyro_w: str, accel_n: str, accel_w: str) -> dict[str, tuple[Parameter, ...]]:
    """Return the parameters of a tool that takes the densities themselves."""
    meanings = ("white noise, density", "random walk of the bias, density")
    rows = {
        "gyro": ((gyro_n, "rad/s/sqrt(Hz)"), (gyro_w, "rad/s^2/sqrt(Hz)")),
        "accel": ((accel_n, "m/s^2/sqrt(Hz)"), (accel_w, "m/s^3/sqrt(Hz)")),
    }
    return {
        kind: tuple(
            Parameter(name, meaning, unit, formula, value)
            for (name, unit), meaning, formula, value in zip(of, meanings, "NK", (_white, _walk), strict=True)
        )
        for kind, of in rows.items()
    }


KALIBR = Convention(
    "Kalibr, OpenVINS",
    "ethz-asl/kalibr: kalibr_common/ConfigReader.py (N/sqrt(dt) per sample, random walk > 0), wiki IMU Noise Model; "
    "rpng/open_vins: ov_msckf/src/state/Propagator.cpp (Qc = N^2/dt, G = dt)",
    **_densities(
        "gyroscope_noise_density", "gyroscope_random_walk", "accelerometer_noise_density", "accelerometer_random_walk"
    ),
)
ORB_SLAM3 = Convention(
    "ORB-SLAM3",
    "UZ-SLAMLab/ORB_SLAM3: src/Tracking.cc (times and over sqrt(IMU.Frequency)), src/ImuTypes.cc",
    **_densities("IMU.NoiseGyro", "IMU.GyroWalk", "IMU.NoiseAcc", "IMU.AccWalk"),
)


def _vins(kind: str, unit: str, derivative: str) -> tuple[Parameter, ...]:
    """Return the parameters of VINS for one triad.

    Its step of interval dt adds dt^2 n^2 (1/4 + 1/4) to the variance of the integral, for the midpoint of two samples
    that it takes for independent of those of the next step, and dt^2 w^2 to that of the bias. With N^2 dt and K^2 dt
    there, n is N sqrt(2/dt), sqrt(2) times the standard deviation of a sample, and w is K/sqrt(dt).
    """
    return (
        Parameter(
            f"{kind}_n", "white noise, of a sample; times sqrt 2 for its midpoint rule", unit, "N √(2/Δt)",
            lambda of, rule: sqrt(2) * _sample(of, rule),
        ),
        Parameter(
            f"{kind}_w", "noise of the derivative of the bias, of a sample", derivative, "K/√Δt",
            lambda of, rule: of.walk * sqrt(rule.rate),
        ),
    )  # fmt: skip


VINS = Convention(
    "VINS-Mono, VINS-Fusion",
    "HKUST-Aerial-Robotics/VINS-Mono and VINS-Fusion: vins_estimator/src/factor/integration_base.h (noise, V)",
    _vins("gyr", "rad/s", "rad/s^2"),
    _vins("acc", "m/s^2", "m/s^3"),
)


def _imu_utils(kind: str, unit: str) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{kind}_n", "white noise, of a sample (its README says density)", unit, "N/√Δt", _sample),
        Parameter(
            f"{kind}_w", "lowest Allan deviation (its README says random walk)", unit, "min σ(τ)",
            lambda of, rule: of.floor,
        ),
    )  # fmt: skip


IMU_UTILS = Convention(
    "imu_utils (what it prints)",
    "gaowenliang/imu_utils: src/gyr_lib/fitallan_gyr.cpp, src/imu_an.cpp, README.md; its issue 36",
    _imu_utils("gyr", "rad/s"),
    _imu_utils("acc", "m/s^2"),
)


def _variance(name: str, unit: str) -> tuple[Parameter, ...]:
    return (Parameter(name, "variance of a sample (diagonal)", unit, "N²/Δt", lambda of, rule: _sample(of, rule) ** 2),)


ROS = Convention(
    "ROS sensor_msgs/Imu",
    "ros2/common_interfaces: sensor_msgs/msg/Imu.msg (row major; first element -1: no estimate)",
    _variance("angular_velocity_covariance", "(rad/s)^2"),
    _variance("linear_acceleration_covariance", "(m/s^2)^2"),
)


def _gazebo(prefix: str, unit: str, driving: str) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{prefix}stddev", "white noise, of a sample", unit, "N/√Δt", _sample),
        Parameter(f"{prefix}mean", "bias, in every sample", unit, "bias", lambda of, rule: of.bias),
        Parameter(f"{prefix}bias_stddev", "bias at the start: its spread over runs", unit, "√(σ₀² + σ²)", _start),
        Parameter(
            f"{prefix}dynamic_bias_stddev", "density of the noise that drives the bias", driving, "σ √(2/T)",
            lambda of, rule: of.markov * sqrt(2 / of.correlation_time),
        ),
        Parameter(
            f"{prefix}dynamic_bias_correlation_time", "correlation time of the bias", "s", "T",
            lambda of, rule: of.correlation_time,
        ),
    )  # fmt: skip


GAZEBO = Convention(
    "Gazebo",
    "gazebosim/gz-sensors: src/GaussianNoiseModel.cc; gazebosim/sdformat: noise.sdf",
    _gazebo("angular_velocity ", "rad/s", "rad/s^2/sqrt(Hz)"),
    _gazebo("linear_acceleration ", "m/s^2", "m/s^3/sqrt(Hz)"),
)


def _hector(prefix: str, unit: str, driving: str) -> tuple[Parameter, ...]:
    """Return the parameters of hector_gazebo for one triad.

    Its step adds dt N(0, 2 drift^2 driftFrequency) to the bias, where the process of standard deviation drift would
    take sqrt(dt): what comes out has the standard deviation drift sqrt(dt).
    """
    return (
        Parameter(f"{prefix}GaussianNoise", "white noise, of a sample", unit, "N/√Δt", _sample),
        Parameter(
            f"{prefix}Drift", "bias; its driving noise takes dt for sqrt dt", driving, "σ/√Δt",
            lambda of, rule: of.markov * sqrt(rule.rate),
        ),
        Parameter(
            f"{prefix}DriftFrequency", "one over the correlation time of the bias", "1/s", "1/T",
            lambda of, rule: 1 / of.correlation_time,
        ),
    )  # fmt: skip


HECTOR = Convention(
    "hector_gazebo",
    "tu-darmstadt-ros-pkg/hector_gazebo: hector_gazebo_plugins/include/hector_gazebo_plugins/sensor_model.h",
    _hector("rate", "rad/s", "rad/s^2/sqrt(Hz)"),
    _hector("accel", "m/s^2", "m/s^3/sqrt(Hz)"),
)


def _kf_gins(white: str, slow: str, start: str, bias: str, units: tuple[str, str]) -> tuple[Parameter, ...]:
    return (
        Parameter(white, "white noise, density", units[0], "N", _white),
        Parameter(slow, "bias, Gauss-Markov: standard deviation", units[1], "σ", _markov),
        Parameter(start, "bias at the start: standard deviation", units[1], "√(σ₀² + σ²)", _open_start),
        Parameter(bias, "bias at the start", units[1], "bias", lambda of, rule: of.bias),
    )


KF_GINS = Convention(
    "KF-GINS",
    "i2Nav-WHU/KF-GINS: dataset/kf-gins.yaml, src/kf_gins.cpp (units), src/kf-gins/gi_engine.cpp (Qc = 2 std^2/T)",
    _kf_gins("arw", "gbstd", "initbgstd", "initgyrbias", ("deg/sqrt(h)", "deg/h")),
    (
        *_kf_gins("vrw", "abstd", "initbastd", "initaccbias", ("m/s/sqrt(h)", "mGal")),
        Parameter("corrtime", "correlation time of all biases", "h", "T", lambda of, rule: of.correlation_time),
    ),
)

AIRSIM_TAU = {"Gyro": 500.0, "Accel": 800.0}
"""Time constants of AirSim [s]: with the stability they give the density of the random walk of the bias."""


def _airsim(white: str, sensor: str, units: tuple[str, str]) -> tuple[Parameter, ...]:
    """Return the parameters of AirSim for one triad; its bias is a random walk of K = stability/sqrt(tau)."""
    tau = AIRSIM_TAU[sensor]
    return (
        Parameter(white, "white noise, density", units[0], "N", _white),
        Parameter(
            f"{sensor}BiasStability", "random walk of the bias, K over the root of tau", units[1], "K √τ",
            lambda of, rule: of.walk * sqrt(tau),
        ),
        Parameter(f"{sensor}BiasStabilityTau", "tau", "s", "τ", lambda of, rule: tau),
    )  # fmt: skip


AIRSIM = Convention(
    "AirSim",
    "microsoft/AirSim: AirLib/include/sensors/imu/ImuSimpleParams.hpp (keys, units), ImuSimple.hpp (arw/sqrt(dt), "
    "stability/sqrt(tau) sqrt(dt) per step), docs/sensors.md (SensorType 2)",
    _airsim("AngularRandomWalk", "Gyro", ("deg/sqrt(h)", "deg/h")),
    _airsim("VelocityRandomWalk", "Accel", ("mg/sqrt(Hz)", "ug")),
)


def _gnss_ins_sim(sensor: str, white: str, units: tuple[str, str]) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{sensor}_{white}", "white noise, density", units[0], "N", _white),
        Parameter(f"{sensor}_b", "bias", units[1], "bias", lambda of, rule: of.bias),
        Parameter(f"{sensor}_b_stability", "bias, Gauss-Markov: standard deviation", units[1], "σ", _markov),
        Parameter(f"{sensor}_b_corr", "correlation time of the bias", "s", "T", lambda of, rule: of.correlation_time),
    )


GNSS_INS_SIM = Convention(
    "gnss-ins-sim",
    "Aceinna/gnss-ins-sim: gnss_ins_sim/sim/imu_model.py (keys, units), gnss_ins_sim/pathgen/pathgen.py (bias_drift: "
    "starts at zero; of infinite correlation time it is white, of standard deviation b_stability per sample)",
    _gnss_ins_sim("gyro", "arw", ("deg/sqrt(h)", "deg/h")),
    _gnss_ins_sim("accel", "vrw", ("m/s/sqrt(h)", "m/s^2")),
)


def _pegasus(sensor: str, units: tuple[str, str, str]) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{sensor} noise_density", "white noise, density", units[0], "N", _white),
        Parameter(
            f"{sensor} random_walk", "density of the noise that drives the bias", units[1], "σ √(2/T)",
            lambda of, rule: of.markov * sqrt(2 / of.correlation_time),
        ),
        Parameter(
            f"{sensor} bias_correlation_time", "correlation time of the bias", "s", "T",
            lambda of, rule: of.correlation_time,
        ),
        Parameter(f"{sensor} turn_on_bias_sigma", "stated, not applied", units[2], "σ₀", lambda of, rule: of.turn_on),
    )  # fmt: skip


PEGASUS = Convention(
    "Pegasus Simulator (Isaac Sim)",
    "PegasusSimulator/PegasusSimulator: extensions/pegasus.simulator/pegasus/simulator/logic/sensors/imu.py (the "
    "gyroscopes take the correlation time of the accelerometers; the bias of these is driven by uniform numbers and "
    "not added; turn_on_bias_sigma is not used)",
    _pegasus("gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", "rad/s")),
    _pegasus("accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)", "m/s^2")),
)


def _matlab(sensor: str, units: tuple[str, str, str]) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{sensor} NoiseDensity", "white noise, density", units[0], "N", _white),
        Parameter(f"{sensor} RandomWalk", "random walk of the bias, density", units[1], "K", _walk),
        Parameter(f"{sensor} ConstantBias", "bias", units[2], "bias", lambda of, rule: of.bias),
    )


MATLAB = Convention(
    "MATLAB imuSensor",
    "mathworks.com/help/nav/ref: imusensor.loadparams, gyroparams, accelparams (names, units, misalignment); "
    "+fusion/+internal/IMUSensorParameters.m (defaults: NoiseType double-sided); IMUSensorSimulator.m and "
    "fractalcoef.m of R2026a as a published check of its Allan deviations quotes them (step of the random walk "
    "K/sqrt(bandwidth); bias instability through 1/(1 - 0.5/z))",
    _matlab("Gyroscope", ("rad/s/sqrt(Hz)", "rad/s^2/sqrt(Hz)", "rad/s")),
    _matlab("Accelerometer", ("m/s^2/sqrt(Hz)", "m/s^3/sqrt(Hz)", "m/s^2")),
)


def _genesis(prefix: str, unit: str) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{prefix}_noise", "white noise, of a sample", unit, "N/√Δt", _sample),
        Parameter(
            f"{prefix}_random_walk", "random walk of the bias, of a step", unit, "K √Δt",
            lambda of, rule: of.walk / sqrt(rule.rate),
        ),
        Parameter(f"{prefix}_bias", "bias", unit, "bias", lambda of, rule: of.bias),
    )  # fmt: skip


GENESIS = Convention(
    "Genesis",
    "Genesis-Embodied-AI/Genesis: genesis/options/sensors (IMU: keys), genesis/engine/sensors/imu.py, base_sensor.py "
    "(_add_noise_drift_bias: both deviations are those of one step of any length; then _quantize_to_resolution)",
    _genesis("gyro", "rad/s"),
    _genesis("acc", "m/s^2"),
)


def _isaac_lab(prefix: str, unit: str) -> tuple[Parameter, ...]:
    return (
        Parameter(f"{prefix} noise_cfg std", "white noise, of a sample", unit, "N/√Δt", _sample),
        Parameter(f"{prefix} bias_noise_cfg mean", "bias", unit, "bias", lambda of, rule: of.bias),
        Parameter(f"{prefix} bias_noise_cfg std", "bias: its spread over resets", unit, "√(σ₀² + σ²)", _start),
    )


ISAAC_LAB = Convention(
    "Isaac Lab",
    "isaac-sim/IsaacLab: source/isaaclab/isaaclab/utils/noise/noise_cfg.py (keys), noise_model.py (noise of each step; "
    "the bias is drawn at a reset, then constant)",
    _isaac_lab("angular_velocity", "rad/s"),
    _isaac_lab("linear_acceleration", "m/s^2"),
)

CONVENTIONS = (KALIBR, ORB_SLAM3, VINS, IMU_UTILS, ROS, GAZEBO, HECTOR, KF_GINS)
