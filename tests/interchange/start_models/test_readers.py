"""Every file is recognised by its content, its numbers are those of the tool, and what is left out is said."""

import json
import re
from dataclasses import replace
from math import log as ln
from math import pi, sqrt
from pathlib import Path

import pytest

from imugap import log
from imugap.effects import (
    CATALOGUE,
    Bias,
    GaussMarkov,
    Misalignment,
    RandomWalk,
    Resolution,
    Saturation,
    ScaleFactor,
    Temperature,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule
from imugap.interchange.export import Target, export
from imugap.interchange.start_models.catalogue import READERS, ModelFile
from imugap.model import ErrorModel
from imugap.units import STANDARD_GRAVITY

RATE = 200.0
DEG = pi / 180

GAZEBO = """<?xml version="1.0"?>
<sdf version="1.9"><model name="robot"><link name="base"><sensor name="imu" type="imu">
  <update_rate>100</update_rate>
  <imu>
    <angular_velocity>
      <x><noise type="gaussian"><mean>0.001</mean><stddev>0.02</stddev><bias_mean>0.1</bias_mean>
        <bias_stddev>0.5</bias_stddev><dynamic_bias_stddev>0.01</dynamic_bias_stddev>
        <dynamic_bias_correlation_time>400</dynamic_bias_correlation_time><precision>0.002</precision></noise></x>
      <y><noise type="none"/></y>
    </angular_velocity>
    <linear_acceleration><z><noise type="gaussian"><stddev>0.3</stddev><precision>1e-9</precision></noise></z>
    </linear_acceleration>
  </imu></sensor></link></model></sdf>"""

KALIBR = """rostopic: /imu0
update_rate: 200.0
gyroscope_noise_density: 1.0e-3
gyroscope_random_walk: 2.0e-5
accelerometer_noise_density: 3.0e-2
accelerometer_random_walk: 4.0e-4
"""
OPENVINS = "%YAML:1.0\n\nimu0:\n  T_i_b: [[1, 0], [0, 1]]\n  Tw: [1, 0]\n" + "".join(
    f"  {line}\n" for line in KALIBR.splitlines()[2:]
)
VINS = "%YAML:1.0\nimu_topic: /imu0\nacc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 1.0e-4\n"
KF_GINS = """imupath: "./a.txt"
initgyrbias: [ 1, -2, 3 ]
initaccbias: [ 10, 0, 0 ]
initgyrscale: [ 0, 0, 500 ]
imunoise:
  arw: [0.003, 0.004, 0.005]
  vrw: [0.03, 0.03, 0.03]
  gbstd: [0.5, 0.5, 0.5]
  abstd: [15.0, 15.0, 15.0]
  gsstd: [300.0, 300.0, 300.0]
  asstd: [0.0, 0.0, 0.0]
  corrtime: 4.0
"""
AIRSIM = json.dumps(
    {"SettingsVersion": 1.2, "Vehicles": {"Drone1": {"Sensors": {"Imu": {
        "SensorType": 2, "AngularRandomWalk": 0.6, "GyroBiasStability": 9.2, "GyroBiasStabilityTau": 100,
        "VelocityRandomWalk": 0.5}}}}}, indent="\t"
)  # fmt: skip
GNSS_INS_SIM = """import numpy as np
D2R = 1
def run():
    imu_err = {'gyro_b': np.array([1.0, -1.0, 0.5]) * 1800.0, 'gyro_arw': np.array([0.25, 0.5, 0.75]) * 2,
               'gyro_b_stability': np.array([3.5, 3.5, 3.5]), 'gyro_b_corr': np.array([100.0, 200.0, 300.0]),
               'accel_b': np.array([0.0e-3, 1e-3, 0.0e-3]), 'accel_vrw': np.array([0.03, 0.03, 0.04]),
               'accel_b_stability': np.array([4e-5, 5e-5, 8e-5]), 'mag_std': np.array([0.2, 0.2, 0.2])}
    return imu_model.IMU(accuracy=imu_err, axis=6, gps=False)
"""
PEGASUS = """from pegasus.simulator.logic.sensors import IMU
imu = IMU({"gyroscope": {"noise_density": 2.0 * 35.0 / 3600.0 / 180.0 * pi, "bias_correlation_time": 500.0},
           "accelerometer": {"random_walk": 2.0 * 3.0e-3}, "update_rate": 100.0})
"""
MATLAB = json.dumps(
    {"GenericLowCost6Axis": {
        "Accelerometer": {"MeasurementRange": 19.6, "Resolution": 0.002, "ConstantBias": [0.1, 0.2, 0.3],
                          "NoiseDensity": [0.001, 0.002, 0.003], "TemperatureBias": 0.03, "AxesMisalignment": [1, 2, 3],
                          "NoiseType": "single-sided", "RandomWalk": 0.01},
        "Gyroscope": {"MeasurementRange": None, "NoiseDensity": 0.004, "BiasInstability": [0.02, 0, 0],
                      "AxesMisalignment": [[101, 1, 0], [0, 100, 0], [0, 0, 100]], "AccelerationBias": 0.1}}}
)  # fmt: skip

GENESIS = """imu = scene.add_sensor(gs.sensors.IMU(entity_idx=robot.idx, acc_noise=(0.1, 0.2, 0.3), gyro_noise=0.01,
    acc_bias=(0.1, 0.0, 0.0), acc_random_walk=1e-3, gyro_resolution=0.002, delay=0.01))
"""

FILES = {
    "robot.sdf": GAZEBO, "imu.yaml": KALIBR, "kalibr_imu_chain.yaml": OPENVINS, "vins.yaml": VINS,
    "kf-gins.yaml": KF_GINS, "settings.json": AIRSIM, "demo.py": GNSS_INS_SIM, "pegasus.py": PEGASUS,
    "generic.json": MATLAB, "genesis.py": GENESIS,
}  # fmt: skip
TOOLS = ("Gazebo", "Kalibr", "Kalibr", "VINS", "KF-GINS", "AirSim", "gnss-ins-sim", "Pegasus", "MATLAB",
         "Genesis")  # fmt: skip


@pytest.fixture
def read(tmp_path):
    """Read the text of a file at a rate: its model and remarks."""

    def of(name, text=None, rate=RATE):
        path = tmp_path / name
        path.write_text(FILES[name] if text is None else text)
        found = ModelFile.open(path, CATALOGUE).at(rate)
        return found.model, ", ".join(found.remarks)

    return of


@pytest.mark.parametrize(("name", "tool"), list(zip(FILES, TOOLS, strict=True)))
def test_a_file_is_recognised_by_its_content(read, name, tool):
    _, said = read(name)
    assert said.startswith(f"recognised as a file of {tool}")
    _, again = read("other.name" if not name.endswith(".py") else "other.py", FILES[name])
    assert again == said


def approx(*effects):
    """The effects with parameters that are equal to rounding."""
    return [(one.name, pytest.approx(one.parameters(), rel=1e-9)) for one in AxisModel(effects)]


def listed(model, axis):
    return [(one.name, one.parameters()) for one in model[axis]]


def test_gazebo_takes_the_numbers_per_sample_at_the_update_rate(read):
    model, said = read("robot.sdf")
    std = 0.01 * sqrt(400 / 2)
    expected = approx(
        WhiteNoise(0.02 / 10), GaussMarkov(std, 400.0), Bias(0.101), TurnOnBias(sqrt(0.25 - std**2)), Resolution(0.002)
    )
    assert listed(model, "gyro_x") == expected
    assert listed(model, "gyro_y") == listed(model, "accel_x") == []
    assert listed(model, "accel_z") == approx(WhiteNoise(0.03))
    assert "at the update_rate, 100 Hz, not at 200 Hz" in said
    assert "draws the sign of bias_mean" in said
    assert "precision below 1e-06" in said


def test_gazebo_without_a_rate_takes_that_of_the_log_or_refuses(read):
    text = GAZEBO.replace("<update_rate>100</update_rate>", "")
    model, _ = read("robot.sdf", text)
    assert listed(model, "accel_z") == approx(WhiteNoise(0.3 / sqrt(RATE)))
    with pytest.raises(ValueError, match=r"robot.sdf: stddev: expected a sampling rate, .*; found none"):
        read("robot.sdf", text, rate=None)


def test_kalibr_and_openvins(read):
    for name in ("imu.yaml", "kalibr_imu_chain.yaml"):
        model, said = read(name, rate=None)
        assert listed(model, "gyro_z") == approx(WhiteNoise(1e-3), RandomWalk(2e-5))
        assert listed(model, "accel_x") == approx(WhiteNoise(3e-2), RandomWalk(4e-4))
    assert "not in the model: Tw" in said


def test_vins_takes_numbers_per_sample(read):
    model, said = read("vins.yaml")
    assert listed(model, "gyro_x") == approx(WhiteNoise(0.01 / sqrt(2 * RATE)), RandomWalk(1e-4 / sqrt(RATE)))
    assert "at 200 Hz" in said


def test_kf_gins(read):
    model, said = read("kf-gins.yaml", rate=None)
    found = [Bias(-2 * DEG / 3600), WhiteNoise(0.004 * DEG / 60), GaussMarkov(0.5 * DEG / 3600, 4 * 3600.0)]
    assert listed(model, "gyro_y") == approx(*found)
    assert approx(ScaleFactor(5e-4))[0] in listed(model, "gyro_z")
    assert listed(model, "accel_x") == approx(Bias(1e-4), WhiteNoise(0.03 / 60), GaussMarkov(1.5e-4, 4 * 3600.0))
    assert "not in the model: gsstd" in said
    assert "asstd" not in said


def test_airsim_with_its_defaults(read):
    model, said = read("settings.json", rate=None)
    walk = 9.2 * DEG / 3600 / sqrt(100)
    assert listed(model, "gyro_x") == approx(WhiteNoise(0.6 * DEG / 60), RandomWalk(walk))
    g = STANDARD_GRAVITY
    assert listed(model, "accel_z") == approx(WhiteNoise(0.5e-3 * g), RandomWalk(36e-6 * g / sqrt(800)))
    assert "by default of AirSim: AccelBiasStability" in said


def test_gnss_ins_sim_evaluates_the_arithmetic_of_its_dictionary(read):
    model, said = read("demo.py")
    found = [Bias(0.5 * DEG), WhiteNoise(0.5 * DEG / 60), GaussMarkov(3.5 * DEG / 3600, 100.0)]
    assert listed(model, "gyro_x") == approx(*found)
    assert listed(model, "accel_y") == approx(Bias(1e-3), WhiteNoise(0.03 / 60), WhiteNoise(5e-5 / sqrt(RATE)))
    assert "accel_b_corr is infinite: gnss-ins-sim draws white noise" in said
    assert "not in the model: mag_std" in said
    with pytest.raises(ValueError, match=r"demo.py: accel_b_stability: expected a sampling rate"):
        read("demo.py", rate=None)


def test_pegasus_with_its_defaults(read):
    model, said = read("pegasus.py", rate=None)
    std = 3.878509448876288e-05 * sqrt(500 / 2)
    assert listed(model, "gyro_z") == approx(WhiteNoise(2 * 35 / 3600 / 180 * pi), GaussMarkov(std, 500.0))
    assert listed(model, "accel_z") == approx(WhiteNoise(0.004), GaussMarkov(6e-3 * sqrt(150), 300.0))
    assert "does not use turn_on_bias_sigma" in said


def test_genesis_takes_numbers_per_step(read):
    model, said = read("genesis.py")
    assert listed(model, "accel_y") == approx(WhiteNoise(0.2 / sqrt(RATE)), RandomWalk(1e-3 * sqrt(RATE)))
    assert approx(Bias(0.1))[0] in listed(model, "accel_x")
    assert listed(model, "gyro_z") == approx(WhiteNoise(0.01 / sqrt(RATE)), Resolution(0.002))
    assert "per step at 200 Hz" in said
    assert "not in the model: delay" in said


def test_matlab_holds_more_than_noise(read):
    model, said = read("generic.json")
    accel = [
        Bias(0.2), WhiteNoise(0.002 / sqrt(2)), RandomWalk(0.01 * sqrt(2)), Temperature(0.03),
        Misalignment(x=0.01, z=0.03), Saturation(19.6), Resolution(0.002),
    ]  # fmt: skip
    assert listed(model, "accel_y") == approx(*accel)
    gyro = [WhiteNoise(0.004), GaussMarkov(0.02 / sqrt(0.75), 1 / (RATE * ln(2))), ScaleFactor(0.01)]
    assert listed(model, "gyro_x") == approx(*gyro, Misalignment(y=0.01))
    assert listed(model, "gyro_z") == approx(WhiteNoise(0.004))
    assert "not in the model: Gyroscope AccelerationBias" in said


def test_matlab_without_a_name_of_the_part(read):
    (part,) = json.loads(MATLAB).values()
    assert read("part.json", json.dumps(part)) == read("generic.json")


def device(*effects):
    return ErrorModel(dict.fromkeys(log.AXES, AxisModel(effects)))


MARKOV = device(Bias(0.01), TurnOnBias(2e-3), WhiteNoise(1e-3), GaussMarkov(5e-4, 7200.0))
HOLDS = {
    Target.GAZEBO: device(Bias(0.01), TurnOnBias(2e-3), WhiteNoise(1e-3), GaussMarkov(5e-4, 60.0), Resolution(1e-3)),
    Target.KALIBR: device(WhiteNoise(1e-3), RandomWalk(2e-5)),
    Target.VINS: device(WhiteNoise(1e-3), RandomWalk(2e-5)),
    Target.KF_GINS: MARKOV,
    Target.AIRSIM: device(WhiteNoise(1e-3), RandomWalk(2e-5)),
    Target.GENESIS: device(Bias(0.01), WhiteNoise(1e-3), RandomWalk(2e-5), Resolution(1e-3)),
    Target.GNSS_INS_SIM: device(Bias(0.01), WhiteNoise(1e-3), GaussMarkov(5e-4, 60.0)),
    Target.MATLAB: device(Bias(0.01), WhiteNoise(1e-3), RandomWalk(2e-5), Saturation(20.0), Resolution(1e-3)),
    Target.PEGASUS: device(WhiteNoise(1e-3), GaussMarkov(5e-4, 60.0)),
}
"""What each target holds whole."""


@pytest.mark.parametrize("target", HOLDS)
def test_a_model_that_the_target_holds_comes_back(read, target):
    model, rule = HOLDS[target], replace(Rule(RATE), correlation_time=7200.0 if target is Target.KF_GINS else None)
    name = "exported.py" if target in (Target.GENESIS, Target.GNSS_INS_SIM, Target.PEGASUS) else "exported"
    found, _ = read(name, export(model, target, rule))
    for axis in log.AXES:
        expected = {one.name: pytest.approx(one.parameters(), rel=3e-6) for one in model[axis]}
        assert {one.name: one.parameters() for one in found[axis]} == expected


@pytest.mark.parametrize(("name", "text"), list(FILES.items()))
def test_the_keys_of_a_file_give_its_numbers(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    found = ModelFile.open(path, CATALOGUE).at(RATE)
    values = [
        abs(key.value(effect))
        for axis, effects in found.model.axes.items()
        for key in found.keys["gyro" if axis in log.GYRO else "accel"]
        for effect in effects if isinstance(effect, key.kind)
    ]  # fmt: skip
    numbers = [abs(float(one)) for one in re.findall(r"\d+\.?\d*(?:[eE][-+]?\d+)?", text)]
    assert sum(any(one == pytest.approx(number, rel=1e-6) for number in numbers) for one in values) > 2


def test_every_reader_names_its_source():
    assert len({one.tool for one in READERS}) == len(READERS)
    for one in READERS:
        assert ":" in one.convention.source
        assert all(parameter.unit for parameter in one.convention.parameters())


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.sdf", "<sdf><imu></sdf>", r"line 1, column 13: expected XML; found a fault"),
        ("a.sdf", "<sdf/>", r"expected a model, or a file of Gazebo, .*; found none of them"),
        ("a.sdf", "<!DOCTYPE a [<!ENTITY b 'c'>]><imu/>", "expected XML without a document type; found one"),
        ("a.sdf", "<imu/>", "expected errors of an IMU in the file of Gazebo; found none"),
        ("a.sdf", GAZEBO.replace("0.02<", "x<"), "stddev: expected a finite number; found 'x'"),
        ("a.sdf", GAZEBO.replace("0.02<", "-1<"), "white_noise.density: expected a finite number .*; found -0.1"),
        ("a.sdf", GAZEBO.replace('"gaussian"', '"custom"', 1), "expected noise of type none, .*; found 'custom'"),
        ("a.py", "x = {'gyro_b': 1", "line 1: expected Python; found a fault"),
        ("a.py", "x = 1", "expected a model, or a file of"),
        ("a.py", GNSS_INS_SIM.replace("np.array([0.25, 0.5, 0.75]) * 2", "f()"), "gyro_arw: expected .*; found None"),
        ("a.py", GNSS_INS_SIM * 2, "expected one dictionary of IMU errors; found 2"),
        ("a.json", MATLAB.replace("0.004", '"x"'), "NoiseDensity: expected one number or 3; found 'x'"),
        ("a.json", MATLAB.replace("single-sided", "x"), "NoiseType: expected double-sided or single-sided; found 'x'"),
        ("a.json", AIRSIM.replace("100", "0"), "GyroBiasStabilityTau: expected a number > 0; found 0"),
        ("a.yaml", KALIBR.replace("1.0e-3", "[1, 2]"), "gyroscope_noise_density: expected a number; found"),
        ("a.yaml", KF_GINS.replace("[0.003, 0.004, 0.005]", "[1, 2]"), "arw: expected one number or 3; found"),
        ("a.yaml", KF_GINS.replace("corrtime: 4.0", "corrtime: 0"), "corrtime: expected a number > 0; found 0"),
        ("a.yaml", "gyro_x: [{white_nois: {density: 1}}]",
            r"effect: expected a known name \(did you mean white_noise\?\); found 'white_nois'"),
        ("a.yaml", "[1, 2]", "expected a mapping of axes; found a list of 2"),
        ("a.yaml", "", "expected a model of at least one axis; found none"),
        ("a.json", "{" * 100_000, "expected"),
    ],
)  # fmt: skip
def test_what_is_no_model_is_one_line(read, name, text, message):
    with pytest.raises(ValueError, match=rf"{name}: .*{message}") as caught:
        read(name, text)
    assert "found" in str(caught.value)


def test_a_model_of_the_library_is_read_as_before(read):
    text = Path("tests/reference/model.yaml").read_text()
    model, said = read("model.yaml", text)
    assert model == ErrorModel.read("tests/reference/model.yaml")
    assert not said
